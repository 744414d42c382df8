"""Meshes: reading, checking, measuring, writing."""

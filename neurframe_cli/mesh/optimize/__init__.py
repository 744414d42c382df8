"""Optimisation of quad and hex meshes against the surface that they were made from."""

"""Filling what the hexes of a flawed map leave empty: with pyramids on their quads and tets between."""

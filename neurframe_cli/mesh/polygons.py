"""Polygons as triangles."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints


def triangulate(V: Floats, polygons: Sequence[Sequence[int]]) -> Ints:
    """(m,3) triangles of polygons over V (n,3); those with fewer than three corners (points, lines) have none.

    A polygon becomes a fan round the corner that gives the largest smallest triangle, measured along the polygon's
    normal: exact for every polygon that is star-shaped from a corner, and for all convex ones.
    """
    triangles: list[Sequence[int]] = []
    for polygon in polygons:
        if len(polygon) == 3:
            triangles.append(polygon)
        elif len(polygon) > 3:
            triangles.extend(_best_fan(V, np.array(polygon, np.int64)).tolist())
    return np.array(triangles, np.int64).reshape(-1, 3)


def _best_fan(V: Floats, polygon: Ints) -> Ints:
    corners = V[polygon] - V[polygon].mean(axis=0)
    normal = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0)
    best, best_area = polygon, -np.inf
    for start in range(len(polygon)):
        turned = np.roll(corners, -start, axis=0)
        areas = np.cross(turned[1:-1] - turned[0], turned[2:] - turned[0]) @ normal
        if areas.min() > best_area:
            best, best_area = np.roll(polygon, -start), float(areas.min())
    apex = np.full(len(polygon) - 2, best[0])
    return np.stack([apex, best[1:-1], best[2:]], axis=1)

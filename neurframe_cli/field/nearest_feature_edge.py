"""Distance and direction of the feature edge nearest to each point."""

from __future__ import annotations

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints


def nearest_feature_edge(points: Floats, V: Floats, edges: Ints) -> tuple[Floats, Floats]:
    """(distances (n,), unit directions (n,3)) from points (n,3) to the segments V[edges], edges (k,2), k > 0.

    Point-segment distances through libigl's bounding volume hierarchy: exact up to rounding.
    """
    import igl

    squared, nearest, _ = igl.point_mesh_squared_distance(points, V, edges)
    along = V[edges[:, 1]] - V[edges[:, 0]]
    directions = along / np.linalg.norm(along, axis=1, keepdims=True)
    return np.sqrt(squared), np.asarray(directions[nearest])

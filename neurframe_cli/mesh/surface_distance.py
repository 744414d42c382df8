"""How far two surfaces are apart, by sampling."""

from __future__ import annotations

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints


def sample_surface(V: Floats, F: Ints, spacing: float) -> Floats:
    """Vertices and, per triangle, the points of a regular grid no coarser than `spacing` (in the units of V)."""
    longest = np.max([np.linalg.norm(V[F[:, i]] - V[F[:, i - 1]], axis=1) for i in range(3)], axis=0)
    # 64 steps an edge: 2,000 points on the largest triangle are enough to find a missing part
    steps = np.clip(np.ceil(longest / spacing), 1, 64).astype(np.int64)
    points = [V[np.unique(F)]]
    for count in np.unique(steps):
        a, b, c = (V[F[steps == count, i]] for i in range(3))
        points += [
            (a * (count - i - j) + b * i + c * j) / count
            for i in range(count + 1)
            for j in range(count + 1 - i)
            if i + j > 0 and max(i, j, count - i - j) < count
        ]
    return np.concatenate(points)


def distances(points: Floats, V: Floats, F: Ints) -> Floats:
    """(p,) distance of each point to the surface V (n,3), F (m,3)."""
    import igl

    squared = igl.point_mesh_squared_distance(points, V, F)[0]
    return np.asarray(np.sqrt(squared))

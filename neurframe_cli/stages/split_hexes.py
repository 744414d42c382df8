"""Every hex in eight: half the edge length, the same structure."""

from __future__ import annotations

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints

# corners of a hexahedron in VTK order, as points of the unit cube
CUBE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]])
# the points of a split cube, at twice their coordinates, and for each the corners that it lies between
LATTICE = np.stack(np.meshgrid(*[np.arange(3)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
AROUND = [np.flatnonzero((np.abs(2 * CUBE - point) <= 1).all(axis=1)) for point in LATTICE]
CHILDREN = (CUBE[:, None] + CUBE[None]) @ np.array([9, 3, 1])


def split_hexes(V: Floats, H: Ints) -> tuple[Floats, Ints]:
    """Positions (m,3), V (n,3) first, and hexes (8 h,8): H (h,8) split at the middles of edges, faces and cells."""
    nodes = np.empty((len(H), len(LATTICE)), np.int64)
    points, total = [V], len(V)
    for many in (1, 2, 4, 8):
        members = [k for k, corners in enumerate(AROUND) if len(corners) == many]
        corners = np.sort(H[:, [AROUND[k] for k in members]], axis=2)
        if many == 1:
            nodes[:, members] = corners[..., 0]
            continue
        unique, inverse = np.unique(corners.reshape(-1, many), axis=0, return_inverse=True)
        nodes[:, members] = total + inverse.reshape(len(H), -1)
        points.append(V[unique].mean(axis=1))
        total += len(unique)
    return np.concatenate(points), nodes[:, CHILDREN].reshape(-1, 8)

"""Which tets share a face, which faces are boundary."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from neurframe_cli.mesh.arrays import Ints

# local faces of a tet, face i opposite vertex i, counter-clockwise seen from outside a positive tet
TET_FACES = np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]], np.int64)


@dataclass(frozen=True)
class TetAdjacency:
    """Faces of a tet mesh.

    neighbors (m,4) int64: tet across local face i, -1 at the boundary; dual_edges (e,2) int64: pairs of tets that share
    a face, smaller first; dual_faces (e,3) int64: that face's vertices, outward from the first tet;
    boundary_faces (b,3) int64: outward boundary triangles; boundary_tets (b,) int64: the tet behind each.
    """

    neighbors: Ints
    dual_edges: Ints
    dual_faces: Ints
    boundary_faces: Ints
    boundary_tets: Ints


def tet_adjacency(T: Ints) -> TetAdjacency:
    """Adjacency of T (m,4); raises ValueError where a face belongs to more than two tets."""
    m = len(T)
    faces = T[:, TET_FACES].reshape(-1, 3)
    keys = np.sort(faces, axis=1)
    order = np.lexsort(keys.T[::-1])
    same = (keys[order][1:] == keys[order][:-1]).all(axis=1)
    if (same[1:] & same[:-1]).any():
        i = order[1:][:-1][same[1:] & same[:-1]][0]
        raise ValueError(f"face {tuple(faces[i])} belongs to more than two tets")
    first, second = order[:-1][same], order[1:][same]
    first, second = np.minimum(first, second), np.maximum(first, second)
    by_tet = np.argsort(first, kind="stable")
    first, second = first[by_tet], second[by_tet]
    neighbors = np.full(4 * m, -1, np.int64)
    neighbors[first], neighbors[second] = second // 4, first // 4
    boundary = np.flatnonzero(neighbors == -1)
    return TetAdjacency(
        neighbors.reshape(m, 4),
        np.stack([first // 4, second // 4], axis=1),
        faces[first],
        faces[boundary],
        boundary // 4,
    )

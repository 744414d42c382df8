"""Small tet meshes with known fields for the tests of training."""

from __future__ import annotations

from itertools import pairwise, product

import numpy as np

from neurframe_cli.mesh.arrays import Features, Floats, TetMesh, as_tets
from neurframe_cli.mesh.tet_adjacency import tet_adjacency

# the six tets of a cube along its diagonal, one per order of the axes
_PATHS = [[(0, 0, 0), a, b, (1, 1, 1)] for a, b in (
    ((1, 0, 0), (1, 1, 0)), ((1, 0, 0), (1, 0, 1)), ((0, 1, 0), (1, 1, 0)),
    ((0, 1, 0), (0, 1, 1)), ((0, 0, 1), (1, 0, 1)), ((0, 0, 1), (0, 1, 1)),
)]  # fmt: skip


def box_mesh(cells: int, bend: float = 0.0) -> TetMesh:
    """A box 3 x 2 x 2 in units of cells/2, six tets a cell; bend turns its far end by that many radians."""
    shape = np.array([3 * cells // 2, cells, cells])
    grid = np.array(list(product(*(range(n + 1) for n in shape))), np.float64) / cells
    number = np.ravel_multi_index
    T = [
        [number(tuple(np.add(cell, corner)), tuple(shape + 1)) for corner in path]
        for cell in product(*(range(n) for n in shape))
        for path in _PATHS
    ]
    V, T = _bent(grid, bend), np.array(T)
    volumes = np.linalg.det(V[T[:, 1:]] - V[T[:, :1]])
    T[volumes < 0] = T[volumes < 0][:, [0, 1, 3, 2]]
    return as_tets(V, T)


def rotation() -> Floats:
    """A rotation with nothing special about it."""
    Q, _ = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))
    return np.asarray(Q * np.sign(np.linalg.det(Q)))


def tilted_box(cells: int) -> TetMesh:
    """box_mesh, its axes along the columns of rotation()."""
    box = box_mesh(cells)
    return as_tets(box.V @ rotation().T, box.T)


def box_features(tets: TetMesh) -> Features:
    """The twelve edges of an unbent box, as the boundary edges whose faces make a right angle."""
    F = tet_adjacency(tets.T).boundary_faces
    normals = np.cross(tets.V[F[:, 1]] - tets.V[F[:, 0]], tets.V[F[:, 2]] - tets.V[F[:, 0]])
    seen: dict[tuple[int, int], int] = {}
    edges = []
    for i, face in enumerate(F):
        for a, b in pairwise([*face, face[0]]):
            other = seen.setdefault((min(a, b), max(a, b)), i)
            if abs(normals[other] @ normals[i]) < 1e-9 * (normals[i] @ normals[i]):
                edges.append((min(a, b), max(a, b)))
    return Features(np.array(edges, np.int64))


def _bent(V: Floats, bend: float) -> Floats:
    if not bend:
        return V
    angle, radius = bend * V[:, 0] / V[:, 0].max(), V[:, 0].max() / bend + V[:, 1]
    return np.stack([radius * np.sin(angle), radius * np.cos(angle), V[:, 2]], axis=1)

"""Corners and directions of quads and hexes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints
from neurframe_cli.mesh.quality.scaled_jacobian import HEX_CORNERS

QUAD_CORNERS = np.array([[0, 1, 3], [1, 2, 0], [2, 3, 1], [3, 0, 2]])
# the parallel edges of each direction
QUAD_DIRECTIONS = np.array([[[0, 1], [3, 2]], [[1, 2], [0, 3]]])
HEX_DIRECTIONS = np.array(
    [
        [[0, 1], [3, 2], [4, 5], [7, 6]],
        [[1, 2], [0, 3], [5, 6], [4, 7]],
        [[0, 4], [1, 5], [2, 6], [3, 7]],
    ]
)


@dataclass(frozen=True)
class CellKind:
    """corners (c, 1 + d): each corner and its neighbours, right-handed; directions (d,p,2): parallel edges."""

    corners: Ints
    directions: Ints

    @property
    def corner_directions(self) -> Ints:
        """Direction (c,d) of the edge from each corner to each of its neighbours."""
        direction_of = {
            frozenset(edge): k for k, edges in enumerate(self.directions.tolist()) for edge in edges
        }
        return np.array([[direction_of[frozenset((c[0], v))] for v in c[1:]] for c in self.corners.tolist()])


QUADS = CellKind(QUAD_CORNERS, QUAD_DIRECTIONS)
HEXES = CellKind(HEX_CORNERS, HEX_DIRECTIONS)


def target_lengths(X: Floats, cells: Ints, kind: CellKind, anisotropy: float, rounds: int) -> Floats:
    """Target edge lengths (n,c,d) at the corners of the cells: size^(1 - anisotropy) · length^anisotropy.

    The size of a cell is the geometric mean of its lengths by direction, averaged over neighbours; the length in each
    direction is averaged over the parallel edges of the cell and of the cells beside it.  Both `rounds` times.
    """
    length = _averaged_lengths(X, cells, kind, rounds)
    length = np.maximum(length, 1e-6 * length.mean())  # collapsed cells need a target, too
    size = np.exp(np.log(length).mean(axis=1))
    use = np.maximum(np.bincount(cells.ravel(), minlength=len(X)), 1)
    for _ in range(rounds):
        at_vertices = np.bincount(cells.ravel(), np.repeat(size, cells.shape[1]), minlength=len(X)) / use
        size = at_vertices[cells].mean(axis=1)
    wanted = size[:, None] ** (1.0 - anisotropy) * length**anisotropy
    return np.asarray(wanted[:, kind.corner_directions])


def _averaged_lengths(X: Floats, cells: Ints, kind: CellKind, rounds: int) -> Floats:
    """Length (n,d) of each cell by direction, averaged along the sheets of parallel edges."""
    ends = np.sort(cells[:, kind.directions], axis=-1)
    _, edge = np.unique(ends[..., 0] * len(X) + ends[..., 1], return_inverse=True)
    parallel = edge.reshape(ends.shape[:-1])
    lengths = np.linalg.norm(X[ends[..., 1]] - X[ends[..., 0]], axis=-1).mean(axis=2)
    use = np.bincount(parallel.ravel())
    for _ in range(rounds):
        shared = np.repeat(lengths.ravel(), parallel.shape[2])
        lengths = (np.bincount(parallel.ravel(), shared) / use)[parallel].mean(axis=2)
    return np.asarray(lengths)

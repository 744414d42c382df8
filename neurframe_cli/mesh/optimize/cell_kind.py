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
    """Target edge lengths (n,c,d) at the corners of the cells.

    The size of a cell is the geometric mean of its mean lengths by direction, averaged over neighbours `rounds` times;
    the target is size^(1 - anisotropy) · (own length in that direction)^anisotropy.
    """
    ends = X[cells[:, kind.directions]]
    by_direction = np.linalg.norm(ends[:, :, :, 1] - ends[:, :, :, 0], axis=-1).mean(axis=2)
    by_direction = np.maximum(by_direction, 1e-6 * by_direction.mean())  # collapsed cells need a target, too
    size = np.exp(np.log(by_direction).mean(axis=1))
    use = np.maximum(np.bincount(cells.ravel(), minlength=len(X)), 1)
    for _ in range(rounds):
        at_vertices = np.bincount(cells.ravel(), np.repeat(size, cells.shape[1]), minlength=len(X)) / use
        size = at_vertices[cells].mean(axis=1)
    wanted = size[:, None] ** (1.0 - anisotropy) * by_direction**anisotropy
    return np.asarray(wanted[:, kind.corner_directions])

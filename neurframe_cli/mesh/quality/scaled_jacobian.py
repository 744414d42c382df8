"""Scaled Jacobian of quads and hexes: at each corner, the volume of the unit edge vectors (Knupp 2000)."""

from __future__ import annotations

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints

# the three neighbours of each corner of a hexahedron in VTK order, right-handed
HEX_CORNERS = np.array(
    [
        [0, 1, 3, 4],
        [1, 2, 0, 5],
        [2, 3, 1, 6],
        [3, 0, 2, 7],
        [4, 7, 5, 0],
        [5, 4, 6, 1],
        [6, 5, 7, 2],
        [7, 6, 4, 3],
    ]
)
SMALLEST_LENGTH = 1e-300  # a zero edge gives 0 instead of a division by zero


def hex_scaled_jacobians(V: Floats, H: Ints) -> Floats:
    """Scaled Jacobian (n,8) at the corners of hexes H (n,8) in VTK order; 1 is a right angle, <= 0 is inverted."""
    origin = V[H[:, HEX_CORNERS[:, 0]]]
    edges = V[H[:, HEX_CORNERS[:, 1:]]] - origin[:, :, None, :]
    unit = edges / np.maximum(np.linalg.norm(edges, axis=-1, keepdims=True), SMALLEST_LENGTH)
    return np.asarray(np.linalg.det(unit))


def quad_scaled_jacobians(V: Floats, Q: Ints) -> Floats:
    """Scaled Jacobian (n,4) at the corners of quads Q (n,4), signed by the quad's own normal (cross of diagonals)."""
    P = V[Q]
    normal = np.cross(P[:, 2] - P[:, 0], P[:, 3] - P[:, 1])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), SMALLEST_LENGTH)
    ahead, behind = np.roll(P, -1, axis=1) - P, np.roll(P, 1, axis=1) - P
    lengths = np.linalg.norm(ahead, axis=2) * np.linalg.norm(behind, axis=2)
    return np.asarray(
        np.einsum("ncd,nd->nc", np.cross(ahead, behind), normal) / np.maximum(lengths, SMALLEST_LENGTH)
    )

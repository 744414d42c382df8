"""The frames that an integer-grid map stands for, and its matchings."""

from __future__ import annotations

import numpy as np

from neurframe_cli.field.octahedral_group import nearest_element
from neurframe_cli.mesh.arrays import Floats, Ints
from neurframe_cli.mesh.read_hex_map import HexMap
from neurframe_cli.mesh.tet_adjacency import TetAdjacency


def map_frames(hex_map: HexMap) -> Floats:
    """The frame (m,3,3) nearest to the map in each tet, axes in its columns, in the order of the parameters.

    The gradients of the parameters are the rows of J, with u = J x + t; the rotation R nearest to J (its polar factor)
    takes axis k to the k-th unit vector, so the axes are the rows of R.  Of a tet that is turned over, the nearest
    rotation all the same; of one that is flat, one of the nearest.
    """
    x, u = hex_map.V[hex_map.T], hex_map.parameters
    dx, du = x[:, 1:] - x[:, :1], u[:, 1:] - u[:, :1]  # one edge a row
    J = np.swapaxes(np.linalg.pinv(dx) @ du, 1, 2)
    left, _, right = np.linalg.svd(J)
    turned = np.linalg.det(left @ right) < 0
    left[turned, :, 2] *= -1.0
    return np.asarray(np.swapaxes(left @ right, 1, 2))


def map_matchings(hex_map: HexMap, adjacency: TetAdjacency) -> Ints:
    """Matchings (e,) of the dual edges (a, b) of the map's tets: frames[a] ~ frames[b] @ GROUP[index].

    With u_a = G u_b + t on their face, the gradients have J_a = G J_b, so that frames[a] = frames[b] G'.  G is what
    takes two edges of the face and their cross product from one chart to the other, and the nearest element of GROUP.
    """
    charts = [_face_chart(hex_map, adjacency, side) for side in (0, 1)]
    G = np.swapaxes(charts[0], 1, 2) @ np.linalg.pinv(np.swapaxes(charts[1], 1, 2))
    return nearest_element(np.swapaxes(G, 1, 2))


def _face_chart(hex_map: HexMap, adjacency: TetAdjacency, side: int) -> Floats:
    """Two edges of each inner face and their cross product (e,3,3), a row each, in the chart of the tet on one side."""
    tets = adjacency.dual_edges[:, side]
    corner = (hex_map.T[tets][:, None, :] == adjacency.dual_faces[:, :, None]).argmax(axis=2)
    u = hex_map.parameters[tets[:, None], corner]
    e, f = u[:, 1] - u[:, 0], u[:, 2] - u[:, 0]
    return np.stack([e, f, np.cross(e, f)], axis=1)

"""Matchings: which of the 24 rotations takes the frame of one tet nearest to that of its neighbour."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from neurframe_cli.field.octahedral_group import GROUP, INVERSE, nearest_element
from neurframe_cli.field.rotations import angle_between
from neurframe_cli.mesh.arrays import Floats, Ints
from neurframe_cli.mesh.tet_adjacency import TetAdjacency


@dataclass(frozen=True)
class Matchings:
    """Best matchings of a frame field, one per dual edge (a, b) of the adjacency.

    index (e,) int64: frames[a] ~ frames[b] @ GROUP[index]; angle (e,): what is left between the two, in radians.
    """

    index: Ints
    angle: Floats


def best_matchings(frames: Floats, adjacency: TetAdjacency) -> Matchings:
    """Matchings of frames (m,3,3) across all interior faces; of equally good ones the first in GROUP.

    The nearest rotation g to frames[b]' frames[a] has the largest inner product with it, as all have equal norm.
    """
    a, b = adjacency.dual_edges.T
    relative = np.swapaxes(frames[b], 1, 2) @ frames[a]
    index = nearest_element(relative)
    return Matchings(index, angle_between(relative, GROUP[index]))


def matchings_by_face(index: Ints, adjacency: TetAdjacency) -> Ints:
    """Matchings from both sides: (m,4) with frames[t] ~ frames[neighbors[t,i]] @ GROUP[.], -1 at the boundary."""
    m = len(adjacency.neighbors)
    by_face = np.full((m, 4), -1, np.int64)
    a, b = adjacency.dual_edges.T
    by_face[a, _local_face(adjacency, a, b)] = index
    by_face[b, _local_face(adjacency, b, a)] = INVERSE[index]
    return by_face


def _local_face(adjacency: TetAdjacency, here: Ints, there: Ints) -> Ints:
    """The face (e,) of tet `here` behind which tet `there` lies; two distinct tets share one face at most."""
    return np.asarray((adjacency.neighbors[here] == there[:, None]).argmax(axis=1))

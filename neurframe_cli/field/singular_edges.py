"""Singular edges: interior edges round which the frames do not come back to themselves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from neurframe_cli.field.edge_rings import EdgeRings, edge_rings
from neurframe_cli.field.matching import best_matchings, matchings_by_face
from neurframe_cli.field.octahedral_group import AXIS, COMPOSE, TURN, Turn
from neurframe_cli.field.singular_arcs import smoothed_tangents
from neurframe_cli.mesh.arrays import Floats, Ints
from neurframe_cli.mesh.tet_adjacency import TetAdjacency, tet_adjacency


@dataclass(frozen=True)
class SingularEdges:
    """The discrete singular graph of a frame field.

    edges (k,2) int64 vertex pairs, smaller first; turn (k,) a Turn each; quarters (k,): the index in quarters, +1
    where three hexes meet (the frame turns with the walk round the edge), -1 where five do, 2 for a half turn, 0
    for compound edges; axis_angle_deg (k,): angle between the arc's tangent and the axis of the holonomy, NaN for
    compound edges; length (k,) in input units; diagonal: of the mesh's bounding box.

    Sign and angle are taken from the smoothed tangent: an edge of a zigzag may run across the arc or backwards.
    """

    edges: Ints
    turn: Ints
    quarters: Ints
    axis_angle_deg: Floats
    length: Floats
    diagonal: float

    @property
    def total_length(self) -> float:
        """Length of all singular edges in bounding-box diagonals."""
        return float(self.length.sum() / self.diagonal) if len(self.length) else 0.0

    @property
    def compound_length(self) -> float:
        """Length of the compound edges, which no hex mesh has, in bounding-box diagonals."""
        return (
            float(self.length[self.turn == Turn.COMPOUND].sum() / self.diagonal) if len(self.length) else 0.0
        )

    def summary(self) -> dict[str, float]:
        """Numbers for a report: how many of each kind, total lengths in bounding-box diagonals."""
        return {
            "singular_edges": len(self.edges),
            "singular_length": self.total_length,
            "valence_3_edges": int((self.quarters == 1).sum()),
            "valence_5_edges": int((self.quarters == -1).sum()),
            "half_turn_edges": int((self.turn == Turn.HALF).sum()),
            "compound_edges": int((self.turn == Turn.COMPOUND).sum()),
            "compound_length": self.compound_length,
        }


def singular_edges(
    V: Floats, T: Ints, frames: Floats, adjacency: TetAdjacency | None = None
) -> SingularEdges:
    """Singular edges of the field frames (m,3,3) on V (n,3), T (m,4) with best matchings.

    Raises ValueError where T is no manifold.  Nieser, Reitebuch & Polthier (2011), section 3.
    """
    adjacency = adjacency or tet_adjacency(T)
    rings = edge_rings(T, adjacency)
    by_face = matchings_by_face(best_matchings(frames, adjacency).index, adjacency)
    return classify_rings(V, frames, rings, holonomies(rings, by_face))


def holonomies(rings: EdgeRings, by_face: Ints) -> Ints:
    """Index (k,) of the rotation that a frame has made once round each edge, by matchings per face (m,4).

    In the axes of the ring's first tet: carried round the edge, frames[first] arrives as frames[first] @ GROUP[.].
    """
    total = np.zeros(len(rings.edges), np.int64)
    step_of = by_face[rings.tets, rings.faces]
    left, step = np.arange(len(total)), 0
    while len(left):
        total[left] = COMPOSE[step_of[rings.offsets[left] + step], total[left]]
        step += 1
        left = left[rings.offsets[left] + step < rings.offsets[left + 1]]
    return total


def classify_rings(V: Floats, frames: Floats, rings: EdgeRings, holonomy: Ints) -> SingularEdges:
    """The edges whose holonomy (k,) is not the identity, with their kinds."""
    singular = np.flatnonzero(holonomy)
    holonomy = holonomy[singular]
    edges, first = rings.edges[singular], rings.tets[rings.offsets[singular]]
    axis = np.einsum("nij,nj->ni", frames[first], AXIS[holonomy])
    tangent = smoothed_tangents(V, edges)
    inner = np.einsum("ni,ni->n", tangent, axis)
    across = np.linalg.norm(np.cross(tangent, axis), axis=1)
    turn = TURN[holonomy]
    quarters = np.select([turn == Turn.QUARTER, turn == Turn.HALF], [np.where(inner > 0, 1, -1), 2], 0)
    angle = np.where(turn == Turn.COMPOUND, np.nan, np.degrees(np.arctan2(across, np.abs(inner))))
    length = np.linalg.norm(V[edges[:, 1]] - V[edges[:, 0]], axis=1)
    diagonal = float(np.linalg.norm(V.max(axis=0) - V.min(axis=0)))
    return SingularEdges(edges, turn, quarters, angle, length, diagonal)

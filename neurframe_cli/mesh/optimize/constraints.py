"""Where each vertex may move: pinned, along a feature curve, on a patch of the surface, or freely."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from neurframe_cli.mesh.arrays import Bools, Floats, Ints
from neurframe_cli.mesh.optimize.simplex_tree import SimplexTree

FREE, ON_SURFACE, ON_CURVE, PINNED = 0, 1, 2, 3


@dataclass(frozen=True)
class Track:
    """The vertices (k,) that slide on one curve or one patch."""

    tree: SimplexTree
    vertices: Ints


@dataclass(frozen=True)
class Foot:
    """Positions that satisfy the constraints (n,3) and the unit tangent (curves) or normal (surface) there (n,3)."""

    points: Floats
    directions: Floats


class Constraints:
    """kind (n,) one of FREE, ON_SURFACE, ON_CURVE, PINNED; pinned vertices go to `pins` (n,3)."""

    def __init__(self, kind: Ints, pins: Floats, tracks: list[Track]) -> None:
        self.kind, self.pins, self.tracks = kind, pins, tracks

    def project(self, x: Floats) -> Foot:
        """Closest positions that satisfy the constraints: exact closest points on the input."""
        points, directions = x.copy(), np.zeros_like(x)
        points[self.kind == PINNED] = self.pins[self.kind == PINNED]
        for track in self.tracks:
            foot = track.tree.closest(x[track.vertices])
            points[track.vertices], directions[track.vertices] = foot.points, foot.directions
        return Foot(points, directions)

    def project_some(self, x: Floats, vertices: Ints) -> Floats:
        """Positions (n,3) as x, but for `vertices` (k,), which are where `project` puts them."""
        chosen, points = np.zeros(len(x), bool), x.copy()
        chosen[vertices] = True
        pinned = chosen & (self.kind == PINNED)
        points[pinned] = self.pins[pinned]
        for track in self.tracks:
            members = track.vertices[chosen[track.vertices]]
            if len(members):
                points[members] = track.tree.closest(x[members]).points
        return points

    def tangential(self, vectors: Floats, directions: Floats) -> Floats:
        """The part of vectors (n,3) that the constraints allow, to first order."""
        along = np.einsum("nd,nd->n", vectors, directions)[:, None] * directions
        kept = np.where(self._is(ON_CURVE), along, vectors - along)
        return np.where(self._is(PINNED), 0.0, kept)

    def _is(self, kind: int) -> Bools:
        return np.asarray(self.kind == kind)[:, None]

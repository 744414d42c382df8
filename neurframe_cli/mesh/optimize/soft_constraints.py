"""Hexes whose vertices cannot all be where they should: what no step that makes no hex worse finds."""

from __future__ import annotations

import numpy as np

from neurframe_cli.mesh.arrays import Floats
from neurframe_cli.mesh.optimize.approach import SLIDING, approach, retreat
from neurframe_cli.mesh.optimize.improve import State
from neurframe_cli.mesh.optimize.near_surface import NearSurface, Placed

BAD = 0.05  # scaled Jacobian; such a hex is of no more use than an inverted one


class SoftConstraints:
    """Hexes from their positions X (n,3) in the map towards the places of `start` (n,3), nearer than the limit of
    `near`; `sliding`: places are never held."""

    def __init__(self, near: NearSurface, X: Floats, start: Floats, sliding: bool = False) -> None:
        self.near, self.X, self.start = near, X, start
        both = (SLIDING, 0.0) if near.improver.first.inverted else (0.0, SLIDING)
        self.ways = (0.0,) if sliding else both
        self._approached: list[State | None] = []

    def untangled(self) -> Placed | None:
        """Without inverted hexes, or None if that cannot be had."""
        found = self._approach()
        return None if found is None else self.near.placed(found)

    def nearer(self, placed: Placed) -> Placed:
        """Where there are bad hexes or the mesh is beyond the limit: hexes that are not inverted, and nearer to the
        surface or near enough."""
        away, limit = placed.away, self.near.limit
        if placed.worst > BAD and away <= limit:
            return placed
        found = None
        if away <= limit:
            found = retreat(self.near.improver, placed.state.x, self._excess)
        if found is None and (placed.state.inverted or away > limit):
            found = self._approach()
        if found is None:
            return placed
        made = self.near.placed(found)
        return placed if made.away > max(limit, away) else made

    def _approach(self) -> State | None:
        """Worked out once."""
        if not self._approached:
            found = approach(self.near.improver, self.X, self.start, self.ways, self._excess)
            self._approached.append(found)
        return self._approached[0]

    def _excess(self, x: Floats) -> float:
        """Distance of all faces beyond the limit, in units of the mesh."""
        return float(np.maximum(self.near.probe.measure(x).by_face - self.near.limit, 0.0).sum())

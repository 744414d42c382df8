"""Hexes whose vertices cannot all be where they should: what no step that makes no hex worse finds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from neurframe_cli.mesh.arrays import Floats
from neurframe_cli.mesh.optimize.approach import SLIDING, approach, retreat
from neurframe_cli.mesh.optimize.distance_probe import DistanceProbe, Distances
from neurframe_cli.mesh.optimize.improve import Improver, State

BAD = 0.05  # scaled Jacobian; such a hex is of no more use than an inverted one


@dataclass(frozen=True)
class Placed:
    """A mesh, and how far its faces are from the surface."""

    state: State
    distances: Distances


class SoftConstraints:
    """Hexes of `improver`, from their positions X (n,3) in the map towards the places of `start` (n,3); `limit`, in
    units of the mesh, of their distance from the surface; `sliding`: places are never held."""

    def __init__(
        self,
        improver: Improver,
        X: Floats,
        start: Floats,
        probe: DistanceProbe,
        limit: float,
        sliding: bool = False,
    ) -> None:
        self.improver, self.X, self.start, self.probe, self.limit = improver, X, start, probe, limit
        both = (SLIDING, 0.0) if improver.first.inverted else (0.0, SLIDING)
        self.ways = (0.0,) if sliding else both
        self._approached: list[State | None] = []

    def untangled(self) -> Placed | None:
        """Without inverted hexes, or None if that cannot be had."""
        found = self._approach()
        return None if found is None else self._placed(found)

    def nearer(self, placed: Placed) -> Placed:
        """Where there are bad hexes or the mesh is beyond the limit: hexes that are not inverted, and nearer to the
        surface or near enough."""
        away = float(placed.distances.by_face.max())
        if placed.state.quality.min() > BAD and away <= self.limit:
            return placed
        found = None
        if away <= self.limit:
            found = retreat(self.improver, placed.state.x, self._excess)
        if found is None and (placed.state.inverted or away > self.limit):
            found = self._approach()
        if found is None or self._distance(found.x) > max(self.limit, away):
            return placed
        return self._placed(found)

    def _approach(self) -> State | None:
        """Worked out once."""
        if not self._approached:
            improver, X, start = self.improver, self.X, self.start
            found = approach(improver, X, start, self.ways, self._excess)
            self._approached.append(found)
        return self._approached[0]

    def _placed(self, state: State) -> Placed:
        return Placed(state, self.probe.measure(state.x))

    def _distance(self, x: Floats) -> float:
        return float(self.probe.measure(x).by_face.max())

    def _excess(self, x: Floats) -> float:
        """Distance of all faces beyond the limit, in units of the mesh."""
        return float(np.maximum(self.probe.measure(x).by_face - self.limit, 0.0).sum())

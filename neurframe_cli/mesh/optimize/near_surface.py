"""Moves of a mesh that take no face farther from its surface than a limit."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints, silent
from neurframe_cli.mesh.optimize.constraints import ON_CURVE, Constraints
from neurframe_cli.mesh.optimize.distance_probe import DistanceProbe, Distances
from neurframe_cli.mesh.optimize.improve import Improver, State

ON = 0.02  # edge lengths between a vertex and the feature that it is on
# worst scaled Jacobian of hexes: below it a layer of hexes is tried, beyond it other things than quality count for more
GOOD_ENOUGH = 0.3
# all vertices on features, beside a worst scaled Jacobian of GOOD_ENOUGH: a poor hex may make a mesh useless
FEATURES_WEIGH = 0.5


@dataclass(frozen=True)
class Placed:
    """A mesh, and how far its faces are from the surface."""

    state: State
    distances: Distances

    @property
    def worst(self) -> float:
        """The least scaled Jacobian."""
        return float(self.state.quality.min())

    @property
    def away(self) -> float:
        """The largest distance, in units of the mesh."""
        return float(self.distances.by_face.max())


@dataclass(frozen=True)
class NearSurface:
    """The mesh of `improver`; limit, in units of the mesh: no face gets farther away than that, or than it was;
    useless_beyond, likewise: a mesh that is farther away is of no use."""

    improver: Improver
    probe: DistanceProbe
    limit: float
    useless_beyond: float

    def constrained(self, constraints: Constraints) -> NearSurface:
        """The same mesh with other constraints."""
        return replace(self, improver=self.improver.constrained(constraints))

    def placed(self, state: State) -> Placed:
        """The state with its distances."""
        return Placed(state, self.probe.measure(state.x))

    def on_features(self, placed: Placed) -> float:
        """The share of the vertices held by features that are on them; 1 where there are none."""
        constraints = self.improver.constraints
        held = constraints.kind >= ON_CURVE
        if not held.any():
            return 1.0
        off = np.linalg.norm(constraints.project(placed.state.x).points - placed.state.x, axis=1)
        return float((off[held] <= ON * np.median(self.improver.energy.lengths)).mean())

    def worth(self, placed: Placed) -> tuple[bool, bool, float]:
        """The larger, the better: a mesh near the surface, hexes up to GOOD_ENOUGH, vertices on their features."""
        quality = min(placed.worst / GOOD_ENOUGH, 1.0) + FEATURES_WEIGH * self.on_features(placed)
        return placed.away <= self.useless_beyond, placed.away <= self.limit, quality

    def within(self, origin: Placed, improved: State) -> Placed:
        """As much of the way from `origin` to `improved` as the limit allows; `origin` where that is better."""
        final = self.moved(origin, improved.x)
        return final if final.state.better_than(origin.state) else origin

    def improved(self, origin: Placed) -> Placed:
        """The mesh improved under its constraints, from where it is."""
        better = self.improver.run(origin.state, origin.state.x, silent)[0]
        return self.within(origin, better)

    def moved(self, origin: Placed, goal: Floats, allowed: Floats | None = None) -> Placed:
        """As much of the way from `origin` to `goal` (n,3) as guarded_step allows, with cells no worse than `allowed`
        (c,) and no face beyond the limit that was not."""
        near = np.maximum(origin.distances.by_face, self.limit)
        last = origin.distances

        def too_far(x: Floats) -> Ints:
            nonlocal last
            last = self.probe.measure(x)
            return np.unique(self.probe.faces[last.by_face > near])

        final = self.improver.guarded(origin.state, goal, too_far, allowed)
        return Placed(final, last)

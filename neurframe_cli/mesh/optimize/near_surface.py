"""Moves of a mesh that take no face farther from its surface than a limit."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints, silent
from neurframe_cli.mesh.optimize.constraints import Constraints
from neurframe_cli.mesh.optimize.distance_probe import DistanceProbe, Distances
from neurframe_cli.mesh.optimize.improve import Improver, State

WORTH, SHARE = 0.2, 0.6  # scaled Jacobian, and share of the worst one, that a hex keeps while vertices settle


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
    """The mesh of `improver`; limit, in units of the mesh: no face gets farther away than that, or than it was."""

    improver: Improver
    probe: DistanceProbe
    limit: float

    def constrained(self, constraints: Constraints) -> NearSurface:
        """The same mesh with other constraints."""
        return replace(self, improver=self.improver.constrained(constraints))

    def placed(self, state: State) -> Placed:
        """The state with its distances."""
        return Placed(state, self.probe.measure(state.x))

    def within(self, origin: Placed, improved: State) -> Placed:
        """As much of the way from `origin` to `improved` as the limit allows; `origin` where that is better."""
        final = self.moved(origin, improved.x)
        return final if final.state.better_than(origin.state) else origin

    def improved(self, origin: Placed) -> Placed:
        """The mesh improved under its constraints, from where it is."""
        better = self.improver.run(origin.state, origin.state.x, silent)[0]
        return self.within(origin, better)

    def settled(self, placed: Placed) -> Placed:
        """Vertices where the constraints want them, wherever no hex gets poor for that, nor worse than the worst one
        was at first: soft constraints leave all of them a little off, and planes uneven."""
        goal = self.improver.constraints.project(placed.state.x).points
        quality = placed.state.quality
        least = max(WORTH, SHARE * placed.worst, self.improver.first.quality.min())
        return self.moved(placed, goal, np.minimum(quality, least))

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

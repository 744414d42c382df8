"""Rounds of minimisation in the tangent spaces and projection, each kept only where it does no harm."""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from dataclasses import dataclass

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints, Progress
from neurframe_cli.mesh.optimize.cell_kind import CellKind, target_lengths
from neurframe_cli.mesh.optimize.constraints import Constraints, Foot
from neurframe_cli.mesh.optimize.corner_energy import CornerEnergy, EnergyWeights
from neurframe_cli.mesh.optimize.guard import guarded_step, least_allowed
from neurframe_cli.mesh.optimize.lbfgs import LbfgsOptions, minimise

# normals (k,3) that say which side is outside, given positions (n,3) and quads (k,); hexes need none
Normals = Callable[[Floats, Ints], Floats]
Harmed = Callable[[Floats], Ints]

# least determinant, in units of the target, from which the energy is a barrier; below it is regularised
BARRIER_FROM = 1e-3
LEAST_MERIT, PATIENCE = 1e-3, 4  # a phase ends after so many rounds that gain less


@dataclass(frozen=True)
class ImproveOptions:
    """rounds at most; steps: L-BFGS iterations in a round; size: weight of size against shape; power: exponent for the
    worst corners in the last rounds; anisotropy: share of each cell's own proportions in its target; gain: decrease of
    the energy a corner (1 at best) in a round, below which the last rounds begin."""

    rounds: int = 20
    steps: int = 15
    size: float = 0.1
    power: float = 4.0
    anisotropy: float = 0.5
    gain: float = 3e-4


@dataclass(frozen=True)
class State:
    """Positions (n,3), outward normals of quads (c,3), quality (c,): worst scaled Jacobian of each cell."""

    x: Floats
    outside: Floats | None
    quality: Floats

    @property
    def inverted(self) -> int:
        return int((self.quality <= 0.0).sum())

    @property
    def merit(self) -> float:
        return float(self.quality.min() + self.quality.mean())

    def better_than(self, other: State) -> bool:
        return (-self.inverted, self.merit) > (-other.inverted, other.merit)


@dataclass
class _Walk:
    """best: what is kept; foot, outside: where the minimisation is, which may be worse for a while."""

    best: State
    foot: Foot
    outside: Floats | None
    rounds: int = 0


class Improver:
    """A mesh with its constraints: cells (c,k) of one kind over the vertices X (n,3), and what is good about them."""

    def __init__(
        self,
        X: Floats,
        cells: Ints,
        kind: CellKind,
        constraints: Constraints,
        normals: Normals | None,
        options: ImproveOptions,
    ) -> None:
        self.cells, self.constraints = cells, constraints
        self.normals, self.options = normals, options
        lengths = target_lengths(X, cells, kind, options.anisotropy, rounds=5)
        corners = cells[:, kind.corners].reshape(-1, kind.corners.shape[1])
        self.energy = CornerEnergy(len(X), corners[:, 0], corners[:, 1:], lengths.reshape(len(corners), -1))
        self.first = self.state(X)

    def constrained(self, constraints: Constraints) -> Improver:
        """The same mesh with other constraints."""
        other = copy(self)
        other.constraints = constraints
        return other

    def run(self, origin: State, start: Floats, progress: Progress) -> tuple[State, int]:
        """Best state found from `start` (n,3), in its worst cell no worse than `origin`, and the number of rounds."""
        foot = self.constraints.project(start)
        walk = _Walk(origin, foot, self._outside(foot.points, np.arange(len(self.cells))))
        self._phase(walk, 1.0, PATIENCE, progress)
        self._phase(walk, self.options.power, 1, progress)
        return walk.best, walk.rounds

    def _phase(self, walk: _Walk, power: float, patience: int, progress: Progress) -> None:
        """Rounds until the energy gains too little, or for `patience` rounds the best state."""
        idle = 0
        while idle < patience and walk.rounds < self.options.rounds:
            walk.foot, gain = self._relaxed(walk.foot, walk.outside, power)
            kept = self.guarded(walk.best, walk.foot.points)
            helped = kept.inverted < walk.best.inverted or kept.merit > walk.best.merit + LEAST_MERIT
            idle = 0 if helped else idle + 1
            walk.best = kept if kept.better_than(walk.best) else walk.best
            walk.outside = kept.outside
            walk.rounds += 1
            report = f"worst {kept.quality.min():.3f}, mean {kept.quality.mean():.3f}"
            progress(walk.rounds / (self.options.rounds + 1), report)
            if gain < self.options.gain:
                break

    def guarded(
        self, old: State, new: Floats, harmed: Harmed | None = None, allowed: Floats | None = None
    ) -> State:
        """As near to `new` as every cell allows that may not fall below `allowed` (c,), or else what `old` permits, and
        as `harmed` allows: the vertices (k,) whose steps do some other harm."""
        allowed = least_allowed(old.quality) if allowed is None else allowed
        states: list[State] = []

        def all_harmed(x: Floats) -> Ints:
            states[:] = [self.state(x, *states)]
            vertices = np.unique(self.cells[states[0].quality < allowed])
            return harmed(x) if len(vertices) == 0 and harmed is not None else vertices

        def around(vertices: Ints) -> Ints:
            return np.unique(self.cells[np.isin(self.cells, vertices).any(axis=1)])

        guarded_step(old.x, new, all_harmed, self.constraints.project_some, around)
        return states[0]

    def _relaxed(self, foot: Foot, outside: Floats | None, power: float) -> tuple[Foot, float]:
        """Some steps down the energy in the tangent spaces at `foot`, projected; the decrease a corner."""
        normals = None if outside is None else _corner_normals(foot.points, self.cells, outside)
        least = self.energy.least_determinant(foot.points, normals)
        epsilon = 0.0 if least > BARRIER_FROM else float(np.hypot(BARRIER_FROM, 0.2 * min(least, 0.0)))
        weights = EnergyWeights(self.options.size, power, epsilon)

        def energy(x: Floats) -> tuple[float, Floats]:
            value, gradient = self.energy.evaluate(x, normals, weights)
            return value, self.constraints.tangential(gradient, foot.directions)

        limits = LbfgsOptions(iterations=self.options.steps)
        new, decrease = minimise(energy, foot.points, self.energy.scale, limits)
        return self.constraints.project(new), decrease / self.energy.corners

    def state(self, x: Floats, known: State | None = None) -> State:
        """The mesh with its vertices at x (n,3); cells that are where they were in `known` are not measured again."""
        if known is None:
            everything = np.arange(len(self.cells))
            outside = self._outside(x, everything)
            return State(x, outside, self._quality(x, outside, everything))
        moved = np.flatnonzero((x != known.x).any(axis=1)[self.cells].any(axis=1))
        outside = self._outside(x, moved)
        quality = _replaced(known.quality, moved, self._quality(x, outside, moved))
        if outside is not None and known.outside is not None:
            outside = _replaced(known.outside, moved, outside)
        return State(x, outside, quality)

    def _outside(self, x: Floats, cells: Ints) -> Floats | None:
        return None if self.normals is None else self.normals(x, cells)

    def _quality(self, x: Floats, outside: Floats | None, cells: Ints) -> Floats:
        """Worst scaled Jacobian of `cells` (k,); that of a quad that faces inward counts as negative."""
        count = self.energy.corners // len(self.cells)
        corners = (cells[:, None] * count + np.arange(count)).ravel()
        if outside is None:
            return np.asarray(self.energy.scaled_jacobians(x, None, corners).reshape(-1, count).min(axis=1))
        own = quad_normals(x, self.cells[cells])
        worst = self.energy.scaled_jacobians(x, _at_corners(own), corners).reshape(-1, count).min(axis=1)
        outward = np.einsum("cd,cd->c", own, outside) > 0.0
        return np.asarray(np.where(outward, worst, -np.abs(worst)), np.float64)


def _replaced(values: Floats, index: Ints, new: Floats) -> Floats:
    result = values.copy()
    result[index] = new
    return result


def _corner_normals(x: Floats, quads: Ints, outside: Floats) -> Floats:
    """Normal (4 c, 3) at the corners of each quad: its own, or the surface's where it faces inward."""
    own = quad_normals(x, quads)
    chosen = np.where(np.einsum("cd,cd->c", own, outside)[:, None] > 0.0, own, outside)
    return _at_corners(chosen)


def _at_corners(normals: Floats) -> Floats:
    """(4 c, 3) from one normal (c,3) a quad."""
    return np.repeat(normals, 4, axis=0)


def quad_normals(x: Floats, quads: Ints) -> Floats:
    """Unit normal (c,3) of the mean plane of each quad."""
    P = x[quads]
    normal = np.cross(P[:, 2] - P[:, 0], P[:, 3] - P[:, 1])
    return np.asarray(normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300))

"""Boundary vertices pulled to their places by a growing penalty, where they cannot all be there at once.

Hexes with two faces on one plane, or an edge across a feature that no edge of theirs follows, leave a mesh whose
vertices are all in place inverted; one that only moves vertices as far as no hex gets worse stays off the surface.
Between the two lies the minimum of

    E(x) + w/2 sum_i c_i |x_i - p_i|²

with the corner energy E, a barrier once nothing is inverted, the places p_i where the constraints want the vertices,
and the curvatures c_i of E.  The smallest weight w that brings the mesh near enough leaves the best hexes.  The places
slide along the surface, or are held at first: without weight a mesh with inverted hexes shrinks away from the surface
to untangle, and what is nearest there is not where it came from.  Both ways are tried for the hexes of a map, that one
first where hexes are inverted.  A mesh that is near already starts with a large weight, or its vertices would slide to
where they leave gaps.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from neurframe_cli.mesh.arrays import Floats
from neurframe_cli.mesh.optimize.constraints import FREE
from neurframe_cli.mesh.optimize.corner_energy import EnergyWeights
from neurframe_cli.mesh.optimize.improve import BARRIER_FROM, Improver, State
from neurframe_cli.mesh.optimize.lbfgs import LbfgsOptions, minimise

FIRST, LAST, GROWTH = 0.1, 1e5, 4.0  # weights of the penalty
NEARLY = 1.3  # times the least excess: what comes after makes hexes worse and the mesh hardly nearer
SLIDING = 50.0  # weight up to which places are held
STEPS = 30  # L-BFGS iterations with each
IDLE = 3  # weights beyond SLIDING that bring the mesh hardly nearer; what comes after does not, either
POWER = 2.0  # of the corner energy, which favours the worst hexes


def approach(
    improver: Improver,
    X: Floats,
    start: Floats,
    ways: Sequence[float],
    excess: Callable[[Floats], float],
) -> State | None:
    """The first state on the way from X (n,3) to the constraints that inverts nothing and is near enough; if there is
    none, one of those that are nearly as near as the nearest, or None if all invert something.

    start (n,3): where the vertices go where their places are held; ways: up to which weight they are held in each;
    excess: of all faces together over the limit of the distance, 0 where they are near enough.  The largest distance
    would tell less: where one place can never be reached, all weights would be the same.
    """
    sound: list[tuple[float, State]] = []
    for sliding in ways:
        least, idle = np.inf, 0
        for weight, found in _way(improver, X, start, sliding):
            if found.inverted:
                continue
            away = excess(found.x)
            sound.append((away, found))
            if away <= 0.0:
                return found
            idle = idle + 1 if weight > SLIDING and NEARLY * away > least else 0
            least = min(least, away)
            if idle == IDLE:
                break
    enough = NEARLY * min((away for away, _ in sound), default=0.0)
    return next((state for away, state in sound if away <= enough), None)


def _way(improver: Improver, x: Floats, start: Floats, sliding: float) -> Iterator[tuple[float, State]]:
    """Growing weights and the states for them, from x (n,3): to the places of `start` (n,3) up to the weight `sliding`,
    then to the nearest ones."""
    weight, goal = FIRST, improver.constraints.project(start).points
    while weight < LAST:
        if weight > sliding:
            goal = improver.constraints.project(x).points
        x = _pulled(improver, x, weight, goal)
        yield weight, improver.state(x)
        weight *= GROWTH


def retreat(improver: Improver, start: Floats, excess: Callable[[Floats], float]) -> State | None:
    """The state with the best hexes that is near enough, from `start` (n,3), which is near but has
    bad ones; None if there is none without inverted hexes."""
    best, weight = None, LAST
    places = improver.constraints.project(start).points
    while weight > FIRST:
        x = _pulled(improver, start, weight, places)
        state = improver.state(x)
        weight /= GROWTH
        if state.inverted:
            continue
        if excess(x) > 0.0:
            break
        best = state
    return best


def _pulled(improver: Improver, x: Floats, weight: float, places: Floats) -> Floats:
    """Near the minimum of the energy above, from x (n,3), for `places` (n,3)."""
    energy = improver.energy
    held = (improver.constraints.kind != FREE)[:, None]
    pull = np.where(held, weight / energy.scale, 0.0)
    least = energy.least_determinant(x, None)
    epsilon = 0.0 if least > 0.0 else float(np.hypot(BARRIER_FROM, 0.2 * least))
    weights = EnergyWeights(improver.options.size, POWER, epsilon)

    def penalised(y: Floats) -> tuple[float, Floats]:
        value, gradient = energy.evaluate(y, None, weights)
        off = y - places
        return value + 0.5 * float((pull * off * off).sum()), gradient + pull * off

    scale = 1.0 / (1.0 / energy.scale + pull)
    return minimise(penalised, x, scale, LbfgsOptions(iterations=STEPS))[0]

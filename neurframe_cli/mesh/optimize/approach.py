"""Boundary vertices pulled to their places by a growing penalty, where they cannot all be there at once.

Hexes with two faces on one plane, or an edge across a feature that no edge of theirs follows, leave a mesh whose
vertices are all in place inverted; one that only moves vertices as far as no hex gets worse stays off the surface.
Between the two lies the minimum of

    E(x) + w/2 sum_i c_i |x_i - p_i|²

with the corner energy E, a barrier once nothing is inverted, the places p_i where the constraints want the vertices,
and the curvatures c_i of E.  The smallest weight w that brings the mesh near enough leaves the best hexes.  A mesh that
is near already starts with a large one, or its vertices would slide along the surface to where they leave gaps.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from neurframe_cli.mesh.arrays import Floats
from neurframe_cli.mesh.optimize.constraints import FREE
from neurframe_cli.mesh.optimize.corner_energy import EnergyWeights
from neurframe_cli.mesh.optimize.improve import BARRIER_FROM, Improver, State
from neurframe_cli.mesh.optimize.lbfgs import LbfgsOptions, minimise

FIRST, LAST, GROWTH = 0.1, 1e5, 4.0  # weights of the penalty
STEPS = 30  # L-BFGS iterations with each
POWER = 2.0  # of the corner energy, which favours the worst hexes


def approach(
    improver: Improver, start: Floats, distance: Callable[[Floats], float], limit: float
) -> State | None:
    """The first state on the way from `start` (n,3) to the constraints that inverts nothing and is within the limit of
    the distance; if there is none, the nearest one that inverts nothing, or None."""
    x, weight = start, FIRST
    nearest, least = None, np.inf
    while weight < LAST:
        x = _pulled(improver, x, weight)
        state = improver.state(x)
        if state.inverted == 0 and (away := distance(x)) < least:
            nearest, least = state, away
            if away <= limit:
                break
        weight *= GROWTH
    return nearest


def retreat(
    improver: Improver, start: Floats, distance: Callable[[Floats], float], limit: float
) -> State | None:
    """The state with the best hexes that is not farther away than the limit, from `start` (n,3), which is near but has
    bad ones; None if there is none without inverted hexes."""
    best, weight = None, LAST
    while weight > FIRST:
        x = _pulled(improver, start, weight)
        state = improver.state(x)
        weight /= GROWTH
        if state.inverted:
            continue
        if distance(x) > limit:
            break
        best = state
    return best


def _pulled(improver: Improver, x: Floats, weight: float) -> Floats:
    """Near the minimum of the energy above, the places held where they are at x (n,3)."""
    energy, goal = improver.energy, improver.constraints.project(x).points
    held = (improver.constraints.kind != FREE)[:, None]
    pull = np.where(held, weight / energy.scale, 0.0)
    least = float(energy.determinants(x, None).min())
    epsilon = 0.0 if least > 0.0 else float(np.hypot(BARRIER_FROM, 0.2 * least))
    weights = EnergyWeights(improver.options.size, POWER, epsilon)

    def penalised(y: Floats) -> tuple[float, Floats]:
        value, gradient = energy.evaluate(y, None, weights)
        off = y - goal
        return value + 0.5 * float((pull * off * off).sum()), gradient + pull * off

    scale = 1.0 / (1.0 / energy.scale + pull)
    return minimise(penalised, x, scale, LbfgsOptions(iterations=STEPS))[0]

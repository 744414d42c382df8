"""Vertices of hexes brought to the places that their constraints want, where soft constraints left them a little off.

First all together, the vertices of every hex that gets poor stepping back.  That stops many that do no harm: the whole
neighbourhood of a hex stands still for one of its corners.  So then each alone: vertices that share no hex go at the
same time, corners and curves before the surface, and one that makes a hex poor steps back without the others.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from neurframe_cli.mesh.arrays import Bools, Floats, Ints
from neurframe_cli.mesh.optimize.improve import Improver, State
from neurframe_cli.mesh.optimize.near_surface import NearSurface, Placed

WORTH, SHARE = 0.2, 0.6  # scaled Jacobian, and share of the worst one, that a hex keeps
FRACTIONS = (1.0, 0.5)  # of the way, for a vertex alone
SWEEPS = 3
CLOSE = 1e-3  # edge lengths; nearer vertices are in place


def settled(near: NearSurface, placed: Placed, alone: bool) -> Placed:
    """The mesh with vertices at their places, wherever no hex gets poor for that, nor worse than the worst one was at
    first, and no face too far from the surface; `alone`: those that do not get there together go one by one, too, which
    brings many more to their places and leaves hexes little to spare."""
    quality = placed.state.quality
    least = max(WORTH, SHARE * placed.worst, near.improver.first.quality.min())
    goal = near.improver.constraints.project(placed.state.x).points
    placed = near.moved(placed, goal, np.minimum(quality, least))
    if not alone:
        return placed
    allowed = np.minimum(placed.state.quality, least)
    state = placed.state
    for seed in range(SWEEPS):
        swept = _one_by_one(near.improver, state, allowed, seed)
        if (swept.x == state.x).all():
            break
        state = swept
    return near.moved(placed, state.x, allowed)


def _one_by_one(improver: Improver, state: State, allowed: Floats, seed: int) -> State:
    """One sweep over the vertices that are off their places; no cell falls below `allowed` (c,)."""
    goal = improver.constraints.project(state.x).points
    off = np.linalg.norm(goal - state.x, axis=1) > CLOSE * np.median(improver.energy.lengths)
    order = np.random.default_rng(seed).permutation(len(off)) + len(off) * improver.constraints.kind
    for together in _apart(improver.cells, np.where(off, order, -1)):
        for fraction in FRACTIONS:
            x = state.x.copy()
            x[together] += fraction * (goal[together] - x[together])
            moved = improver.state(x, state)
            poor = np.zeros(len(x), bool)
            poor[improver.cells[moved.quality < allowed]] = True
            together, kept = together[poor[together]], together[~poor[together]]
            if len(kept):
                x[together] = state.x[together]
                state = improver.state(x, state)
            if len(together) == 0:
                break
    return state


def _apart(cells: Ints, order: Ints) -> Iterator[Ints]:
    """Sets of vertices (k,) that share no cell, until each with an `order` (n,) of 0 or more was in one: of those in a
    cell the one of the highest order comes first."""
    order = order.copy()
    while (order >= 0).any():
        of_cells = order[cells]
        first = of_cells.max(axis=1)
        behind: Bools = np.zeros(len(order), bool)
        behind[cells[of_cells < first[:, None]]] = True
        together = np.flatnonzero((order >= 0) & ~behind)
        order[together] = -1
        yield together

"""Features that let go of the vertices of poor hexes, where these cannot be better with them."""

from __future__ import annotations

import numpy as np

from neurframe_cli.mesh.arrays import Bools, Surface
from neurframe_cli.mesh.optimize.constraints import ON_CURVE
from neurframe_cli.mesh.optimize.let_go import let_go
from neurframe_cli.mesh.optimize.near_surface import NearSurface, Placed
from neurframe_cli.mesh.optimize.soft_constraints import BAD, SoftConstraints

RINGS = 3  # of hexes whose features let go
ABOUT = 1.05  # times the limit of the distance, for much better hexes
NEAR_ENOUGH = 1.2  # times the limit, for features that have let go: settling brings the mesh nearer
POOREST = (0.08, 0.12, 0.16, 0.2)  # scaled Jacobians of hexes that features let go of, one after the other


def released_round_bad(
    near: NearSurface, placed: Placed, surface: Surface, least: float = BAD
) -> tuple[Placed, int]:
    """Hexes better than `least`, where letting go of features in the others makes them so, or round those that stay bad
    in as many rings of hexes as needed; with the number of vertices let go."""
    cells = near.improver.cells
    chosen, freed = np.zeros(len(cells), bool), 0
    for rings in range(RINGS):
        bad = np.asarray(placed.state.quality <= least)
        if not bad.any():
            break
        for _ in range(rings):
            bad = np.asarray(np.isin(cells, cells[bad]).any(axis=1))
        chosen |= bad
        count = _held_count(near, chosen)
        if count == freed:
            continue
        freed = count
        placed = _without_features(near, surface, chosen).improved(placed)
    return placed, freed


def released_of_soft(near: NearSurface, placed: Placed, surface: Surface) -> tuple[Placed, int]:
    """The same for hexes that soft constraints have drawn to the surface: of poor ones and all round them, but only if
    that brings the mesh near enough where it was not; then of the poorest, drawn anew."""
    released = 0
    if placed.away > near.limit:
        freed, count = released_round_bad(near, placed, surface, POOREST[-1])
        if freed.away <= NEAR_ENOUGH * near.limit:
            placed, released = freed, count
    placed, more = _drawn_anew(near, placed, surface)
    return placed, max(released, more)


def _drawn_anew(near: NearSurface, placed: Placed, surface: Surface) -> tuple[Placed, int]:
    """Hexes drawn to the surface anew, from where they are, features having let go of the poorest, then of less poor
    ones, as long as that makes the poorest better and leaves no place too far away."""
    chosen, freed = np.zeros(len(near.improver.cells), bool), 0
    for least in POOREST:
        poor = np.asarray(placed.state.quality <= least)
        if not poor.any():
            continue
        free = _without_features(near, surface, chosen | poor)
        x = placed.state.x
        drawn = SoftConstraints(free, x, x, sliding=True).untangled()
        if drawn is None:
            break
        drawn = free.improved(drawn)
        if drawn.worst <= placed.worst or drawn.away > max(ABOUT * near.limit, placed.away):
            break
        placed, chosen = drawn, chosen | poor
        freed = _held_count(near, chosen)
    return placed, freed


def _without_features(near: NearSurface, surface: Surface, chosen: Bools) -> NearSurface:
    """The same mesh, features having let go of the `chosen` hexes (c,)."""
    improver = near.improver
    return near.constrained(let_go(improver.constraints, surface, improver.cells[chosen]))


def _held_count(near: NearSurface, chosen: Bools) -> int:
    """How many vertices of the `chosen` hexes (c,) features hold."""
    held = near.improver.constraints.kind >= ON_CURVE
    return int(held[np.unique(near.improver.cells[chosen])].sum())

"""Moves are kept where they do no harm: the worst cell never gets worse."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints

Positions = Callable[[Floats], Floats]
STEP_FRACTIONS = np.array([1.0, 0.5, 0.25, 0.0])
JUST_POSITIVE = 1e-3


def least_allowed(quality: Floats) -> Floats:
    """What each cell may fall to, given its quality (n,) before: not below the worst cell of all; while that one is
    inverted, cells that are not stay so."""
    worst = quality.min()
    if worst > 0.0:
        return np.full_like(quality, worst)
    return np.where(quality > 0.0, np.minimum(quality, JUST_POSITIVE), worst)


def guarded_step(
    old: Floats, new: Floats, cells: Ints, quality: Positions, project: Positions, allowed: Floats
) -> tuple[Floats, Floats]:
    """Positions between old and new (n,3) at which every cell has at least its `allowed` quality (c,); their quality.

    The vertices of a cell that falls short take a half, a quarter, then none of their step, until all cells pass;
    `old` passes, so this ends.
    """
    x, found, level = new, quality(new), np.zeros(len(old), np.int64)
    while (found < allowed).any():
        level[np.unique(cells[found < allowed])] += 1
        fraction = STEP_FRACTIONS[np.minimum(level, len(STEP_FRACTIONS) - 1)][:, None]
        x = project(old + fraction * (new - old))
        # bit for bit, so that what passed before passes again
        x = np.where(fraction == 1.0, new, np.where(fraction == 0.0, old, x))
        found = quality(x)
    return x, found

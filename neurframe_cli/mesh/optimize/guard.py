"""Moves are kept where they do no harm: the worst cell never gets worse."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints

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
    old: Floats,
    new: Floats,
    harmed: Callable[[Floats], Ints],
    project: Callable[[Floats, Ints], Floats],
    around: Callable[[Ints], Ints],
) -> Floats:
    """Positions between old and new (n,3) that harm nothing.

    harmed(x) names the vertices (k,), each once, whose steps do harm, none at `old`; they take a half, a quarter, then
    none of their step, until none is named.  Where all the named ones stand still already, the harm is done by others:
    those around(vertices) (k,), `vertices` among them, step back, then those two rings around, four, in the end all,
    so that this ends soon.  The last x that harmed() saw is the one that is returned.  project(x, vertices) puts
    `vertices` (k,) where they may be and leaves the others.
    """
    x, level = new, np.zeros(len(old), np.int64)
    last, rings = len(STEP_FRACTIONS) - 1, 1
    while len(vertices := harmed(x)):
        while (level[vertices] == last).all():
            vertices = _rings_around(vertices, rings, len(old), around)
            rings *= 2
        vertices = vertices[level[vertices] < last]
        level[vertices] += 1
        part = STEP_FRACTIONS[level[vertices]][:, None]
        x = x.copy()
        x[vertices] = old[vertices] + part * (new[vertices] - old[vertices])
        x = project(x, vertices[level[vertices] < last])
        stopped = vertices[level[vertices] == last]
        x[stopped] = old[stopped]  # bit for bit, so that what passed before passes again
    return x


def _rings_around(vertices: Ints, rings: int, count: int, around: Callable[[Ints], Ints]) -> Ints:
    """The vertices and so many rings of others; all of the `count` where there are no more rings."""
    for _ in range(rings):
        wider = around(vertices)
        if len(wider) == len(vertices):
            return np.arange(count)
        vertices = wider
    return vertices

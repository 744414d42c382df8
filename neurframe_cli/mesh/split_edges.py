"""Finer triangles without any change of the shape."""

from __future__ import annotations

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints, Surface
from neurframe_cli.mesh.surface_edges import directed_edges


def with_short_edges(surface: Surface, longest: float) -> Surface:
    """The same surface with no edge above `longest`: longest edges are halved in both triangles until there is none.

    Rivara 1984: the angles do not fall below half of the smallest one before.
    """
    V, F = surface.V, surface.F
    while True:
        edges, of_side = np.unique(np.sort(directed_edges(F), axis=1), axis=0, return_inverse=True)
        of_side = of_side.reshape(-1, 3)
        length = np.linalg.norm(V[edges[:, 1]] - V[edges[:, 0]], axis=1)
        chosen = _local_maxima(length, of_side, longest)
        if not chosen.any():
            return Surface(V, F)
        middle = np.where(chosen, len(V) + np.cumsum(chosen) - 1, -1)
        V = np.concatenate([V, V[edges[chosen]].mean(axis=1)])
        F = _halved(F, middle[of_side])


def _local_maxima(length: Floats, of_side: Ints, longest: float) -> Ints:
    """Which edges (e,) are too long, and the longest of every triangle that they belong to, ties by number."""
    rank = np.empty(len(length), np.int64)
    rank[np.lexsort([np.arange(len(length)), length])] = np.arange(len(length))
    greatest = rank[of_side].max(axis=1)
    blocked = np.zeros(len(length), bool)
    blocked[of_side[rank[of_side] < greatest[:, None]]] = True
    return np.asarray((length > longest) & ~blocked)


def _halved(F: Ints, middle: Ints) -> Ints:
    """Triangles F (m,3) with those halved that have a new vertex `middle` (m,3; -1 for none) on one of their sides."""
    side = middle.argmax(axis=1)
    rows = np.flatnonzero(middle[np.arange(len(F)), side] >= 0)
    turn = (side[rows][:, None] + np.arange(3)) % 3
    a, b, c = F[rows[:, None], turn].T
    new = middle[rows, side[rows]]
    kept = np.delete(F, rows, axis=0)
    return np.concatenate([kept, np.stack([a, new, c], axis=1), np.stack([new, b, c], axis=1)])

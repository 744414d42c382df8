"""Arcs of a singular graph, and their tangents without the zigzag of the mesh edges."""

from __future__ import annotations

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints
from neurframe_cli.mesh.features import chains_of

# edges on each side that are averaged: the arc of a straight line zigzags with a period of two or three
WINDOW = 2


def singular_arcs(edges: Ints) -> tuple[Ints, ...]:
    """Vertex sequences that cover the edges (k,2) once each, from node to node or round a loop.

    A node is a vertex with other than two singular edges; a loop repeats its first vertex at the end.
    """
    degree = np.bincount(edges.ravel())
    return chains_of(edges, degree != 2)


def smoothed_tangents(V: Floats, edges: Ints) -> Floats:
    """Unit tangents (k,3) of the arcs at their edges (k,2), pointing as edge vectors do: first to second vertex.

    The chord over WINDOW edges on both sides, cut off at the ends of an open arc; in a loop too short for that,
    the edge itself.
    """
    tangents = np.empty((len(edges), 3))
    row = {(u, v): i for i, (u, v) in enumerate(edges.tolist())}
    for arc in singular_arcs(edges):
        chords = _chords(V, arc)
        for u, v, chord in zip(arc[:-1].tolist(), arc[1:].tolist(), chords, strict=True):
            if (u, v) in row:
                tangents[row[u, v]] = chord
            else:
                tangents[row[v, u]] = -chord
    return np.asarray(tangents / np.linalg.norm(tangents, axis=1, keepdims=True))


def _chords(V: Floats, arc: Ints) -> Floats:
    """From WINDOW vertices before to WINDOW vertices after each edge of the arc."""
    count = len(arc) - 1
    closed = arc[0] == arc[-1]
    window = 0 if closed and count <= 2 * WINDOW + 1 else WINDOW
    before, after = np.arange(count) - window, np.arange(count) + 1 + window
    if closed:
        return np.asarray(V[arc[after % count]] - V[arc[before % count]])
    return np.asarray(V[arc[np.minimum(after, count)]] - V[arc[np.maximum(before, 0)]])

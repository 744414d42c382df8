"""Corners of quads that a feature curve would pull straight."""

from __future__ import annotations

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints

STRAIGHT_DEG = 150.0


def straight_corners(X: Floats, faces: Ints, paths: list[Ints]) -> Ints:
    """Vertices (k,), each once, at which one of `paths` takes two edges in a row of one quad and goes straight on.

    X (n,3) with the vertices of the paths on their curves, faces (f,4).  An isoline of a map never turns inside of a
    quad; such a path was found where the map does not follow the curve, as at the end of a crease that fades out.  All
    three vertices on the curve would leave that quad a corner of 180 degrees.
    """
    edges, curve = _keyed_edges(paths, len(X))
    if len(edges) == 0:
        return np.zeros(0, np.int64)
    before, after = np.roll(faces, 1, axis=1), np.roll(faces, -1, axis=1)
    incoming, outgoing = (_curve_of(edges, curve, _key(faces, other, len(X))) for other in (before, after))
    quad, corner = np.nonzero((incoming >= 0) & (incoming == outgoing))
    here, back, on = (ends[quad, corner] for ends in (faces, before, after))
    sides = X[back] - X[here], X[on] - X[here]
    lengths = np.maximum(np.linalg.norm(sides[0], axis=1) * np.linalg.norm(sides[1], axis=1), 1e-300)
    cosine = np.einsum("nd,nd->n", *sides) / lengths
    return np.unique(here[cosine < np.cos(np.radians(STRAIGHT_DEG))])


def _keyed_edges(paths: list[Ints], size: int) -> tuple[Ints, Ints]:
    """Keys (e,), sorted, of the edges of all paths, and the index of each one's path."""
    keys = [_key(path[:-1], path[1:], size) for path in paths]
    key = np.concatenate([*keys, np.zeros(0, np.int64)])
    index = np.repeat(np.arange(len(paths)), [len(k) for k in keys])
    order = np.argsort(key, kind="stable")
    return key[order], index[order]


def _key(a: Ints, b: Ints, size: int) -> Ints:
    return np.asarray(np.minimum(a, b) * size + np.maximum(a, b))


def _curve_of(edges: Ints, curve: Ints, key: Ints) -> Ints:
    """The path that the edge with each key is on, -1 for none."""
    place = np.minimum(np.searchsorted(edges, key), len(edges) - 1)
    return np.where(edges[place] == key, curve[place], -1)

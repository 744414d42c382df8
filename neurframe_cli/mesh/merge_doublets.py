"""Doublets: two quads that share two edges in a row."""

from __future__ import annotations

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints


def merge_doublets(V: Floats, Q: Ints) -> tuple[Floats, Ints, int]:
    """V (n,3) and Q (q,4) with each doublet as one quad, and how many were merged.

    At an inner vertex with two quads, one of them has a corner of at least 180 degrees wherever the vertex is put: a
    singularity of index 1/2 in the cross field has no better place.  Without it both quads are one.  Open boundaries
    have two quads at a vertex by right and are left alone.
    """
    merged = 0
    while (found := _first_doublets(Q)) is not None:
        keep, drop, quads = found
        Q = np.concatenate([np.delete(Q, np.concatenate([keep, drop]), axis=0), quads])
        merged += len(quads)
    if not merged:
        return V, Q, 0
    used, Q = np.unique(Q, return_inverse=True)
    return V[used], Q.reshape(-1, 4), merged


def _first_doublets(Q: Ints) -> tuple[Ints, Ints, Ints] | None:
    """Pairs of quads that no other pair touches, and the quad each pair becomes; None where there are none."""
    corners = Q.ravel()
    order = np.argsort(corners, kind="stable")
    valence = np.bincount(corners)
    starts = np.cumsum(valence) - valence
    taken, pairs = set[int](), []
    for vertex in np.flatnonzero(valence == 2):
        a, b = (int(order[starts[vertex] + k]) for k in range(2))
        first, second = a // 4, b // 4
        one, other = np.roll(Q[first], -(a % 4)), np.roll(Q[second], -(b % 4))
        # (v, p, q, r) and (v, r, s, p): the merged quad is (p, q, r, s)
        inner = one[1] == other[3] and one[3] == other[1]
        if inner and one[2] != other[2] and not {first, second} & taken:
            taken |= {first, second}
            pairs.append((first, second, [one[1], one[2], one[3], other[2]]))
    if not pairs:
        return None
    keep, drop, quads = zip(*pairs, strict=True)
    return np.array(keep), np.array(drop), np.array(quads, dtype=Q.dtype)

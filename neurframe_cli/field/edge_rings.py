"""The tets round each interior edge, in order."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from neurframe_cli.mesh.arrays import Bools, Ints
from neurframe_cli.mesh.tet_adjacency import TetAdjacency

TET_EDGES = np.array([[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]], np.int64)


def _turning_vertices() -> Ints:
    """(4,4): for an edge from local vertex u to v of a positive tet, the p for which (u, v, p, q) is even.

    Seen with the edge pointing at the viewer, the tet then reaches counter-clockwise from p to q.
    """
    table = np.full((4, 4), -1, np.int64)
    for u, v, p in ((u, v, p) for u in range(4) for v in range(4) for p in range(4)):
        if len({u, v, p}) == 3:
            order = (u, v, p, 6 - u - v - p)
            if np.linalg.det(np.eye(4)[list(order)]) > 0:
                table[u, v] = p
    return table


_TURNING = _turning_vertices()


@dataclass(frozen=True)
class EdgeRings:
    """Tets round interior edges.

    edges (k,2) int64, smaller vertex first, sorted; offsets (k+1,): the ring of edge e is the slice
    offsets[e]:offsets[e+1] of the two others; tets (r,): counter-clockwise, seen with the edge, from the smaller
    to the greater vertex, pointing at the viewer, from the tet of lowest number; faces (r,): the local face
    through which the ring goes on to its next tet.
    """

    edges: Ints
    offsets: Ints
    tets: Ints
    faces: Ints


def edge_rings(T: Ints, adjacency: TetAdjacency) -> EdgeRings:
    """Rings of all edges of T (m,4), positive tets, that no boundary face has.

    Raises ValueError where the tets round an edge are not one closed ring.
    """
    n = int(T.max(initial=-1)) + 1
    keys, first, counts = np.unique(_edge_keys(T[:, TET_EDGES], n), return_index=True, return_counts=True)
    interior = ~_contains(
        np.unique(_edge_keys(adjacency.boundary_faces[:, [[0, 1], [1, 2], [2, 0]]], n)), keys
    )
    keys, counts = keys[interior], counts[interior]
    edges = np.stack([keys // n, keys % n], axis=1) if n else np.zeros((0, 2), np.int64)
    offsets = np.concatenate([[0], np.cumsum(counts)])
    tets, faces = _walk(T, adjacency.neighbors, edges, offsets, first[interior] // 6)
    return EdgeRings(edges, offsets, tets, faces)


def _edge_keys(pairs: Ints, n: int) -> Ints:
    pairs = np.sort(pairs.reshape(-1, 2), axis=1)
    return np.asarray(pairs[:, 0] * n + pairs[:, 1])


def _contains(ordered: Ints, keys: Ints) -> Bools:
    """Which keys are among the ordered ones."""
    if not len(ordered):
        return np.zeros(len(keys), bool)
    place = np.minimum(np.searchsorted(ordered, keys), len(ordered) - 1)
    return np.asarray(ordered[place] == keys)


def _walk(T: Ints, neighbors: Ints, edges: Ints, offsets: Ints, start: Ints) -> tuple[Ints, Ints]:
    """All rings at once, one tet further in each round; rings that are full drop out."""
    tets, faces = np.empty(offsets[-1], np.int64), np.empty(offsets[-1], np.int64)
    left, here = np.arange(len(edges)), start
    step = 0
    while len(left):
        u = (T[here] == edges[left, :1]).argmax(axis=1)
        v = (T[here] == edges[left, 1:]).argmax(axis=1)
        place = offsets[left] + step
        tets[place], faces[place] = here, _TURNING[u, v]
        here = neighbors[here, faces[place]]
        step += 1
        full = offsets[left] + step == offsets[left + 1]
        _check_ring(edges, left, bad=(here < 0) | (full != (here == start[left])))
        left, here = left[~full], here[~full]
    return tets, faces


def _check_ring(edges: Ints, rings: Ints, bad: Bools) -> None:
    if bad.any():
        u, v = edges[rings[bad][0]]
        raise ValueError(f"the tets round edge ({u}, {v}) are not one closed ring")

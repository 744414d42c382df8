"""Splits of tets that keep the mesh conforming."""

from __future__ import annotations

import numpy as np

from neurframe_cli.mesh.arrays import Bools, Floats, Ints, TetMesh, as_tets


def split_edges(mesh: TetMesh, edges: Ints) -> tuple[TetMesh, Bools]:
    """Splits edges (k,2) at their midpoints, all tets round an edge with it; which (k,) were split.

    Of edges that share a tet at most the first is split, the others are left for another call.  New vertices come after
    the old ones in the order of the split edges.
    """
    pairs = _edges_in_tets(mesh.T, edges)
    done = _independent(pairs, len(edges))
    owner = np.full(len(mesh.T), -1, np.int64)
    pairs = pairs[done[pairs[:, 1]]]
    owner[pairs[:, 0]] = pairs[:, 1]
    midpoint = np.full(len(edges), -1, np.int64)
    midpoint[done] = len(mesh.V) + np.arange(int(done.sum()))
    V = np.concatenate([mesh.V, mesh.V[edges[done]].mean(axis=1)])
    cut = owner >= 0
    halves = [_replaced(mesh.T[cut], edges[owner[cut], side], midpoint[owner[cut]]) for side in (0, 1)]
    return as_tets(V, np.concatenate([mesh.T[~cut], *halves])), done


def split_at_points(mesh: TetMesh, tets: Ints, points: Floats) -> TetMesh:
    """Each of `tets` (k,) becomes four round its interior point (k,3)."""
    new = len(mesh.V) + np.arange(len(tets))
    children = [_replaced_at(mesh.T[tets], i, new) for i in range(4)]
    kept = np.ones(len(mesh.T), np.bool_)
    kept[tets] = False
    return as_tets(np.concatenate([mesh.V, points]), np.concatenate([mesh.T[kept], *children]))


def _edges_in_tets(T: Ints, edges: Ints) -> Ints:
    """(h,2) pairs (tet, edge number) of all hits, sorted by tet, then by edge."""
    local = np.sort(T[:, [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]], axis=2)
    size = 1 + int(T.max(initial=0))
    wanted = np.sort(edges, axis=1)
    keys = wanted[:, 0] * size + wanted[:, 1]
    order = np.argsort(keys)
    flat = (local[..., 0] * size + local[..., 1]).ravel()
    slot = np.minimum(np.searchsorted(keys[order], flat), max(len(keys) - 1, 0))
    hit = np.flatnonzero(keys[order][slot] == flat) if len(keys) else np.zeros(0, np.int64)
    pairs = np.column_stack([hit // 6, order[slot[hit]]]) if len(hit) else np.zeros((0, 2), np.int64)
    return pairs[np.lexsort(pairs.T[::-1])]


def _independent(pairs: Ints, count: int) -> Bools:
    """(count,) edges whose tets no lower edge has as well; the lowest edge of all is always among them."""
    tets, first = np.unique(pairs[:, 0], return_index=True)
    lowest = pairs[first, 1][np.searchsorted(tets, pairs[:, 0])]
    done = np.ones(count, np.bool_)
    done[pairs[lowest != pairs[:, 1], 1]] = False
    return done


def _replaced(T: Ints, old: Ints, new: Ints) -> Ints:
    return np.where(old[:, None] == T, new[:, None], T)


def _replaced_at(T: Ints, position: int, new: Ints) -> Ints:
    T = T.copy()
    T[:, position] = new
    return T

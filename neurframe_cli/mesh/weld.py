"""Vertices that are one point get one number."""

from __future__ import annotations

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints


def weld(V: Floats, F: Ints, tolerance: float) -> tuple[Floats, Ints]:
    """V (n,3) without doubles and F (m,3) over it; vertices keep the order in which they first appear.

    tolerance 0: equal coordinates; else all that a chain of steps no longer than `tolerance` connects.
    """
    group = _equal(V) if tolerance == 0.0 else _near(V, tolerance)
    _, first, number = np.unique(group, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty(len(order), np.int64)
    rank[order] = np.arange(len(order))
    return V[first[order]], rank[number.reshape(-1)][F]


def _equal(V: Floats) -> Ints:
    # adding zero makes -0.0 and 0.0 the same bytes
    _, group = np.unique(V + 0.0, axis=0, return_inverse=True)
    return np.asarray(group.reshape(-1), np.int64)


def _near(V: Floats, tolerance: float) -> Ints:
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    pairs = cKDTree(V).query_pairs(tolerance, output_type="ndarray")
    graph = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(V), len(V)))
    return np.asarray(connected_components(graph, directed=False)[1], np.int64)

"""Feature lines that are long enough to be meant."""

from __future__ import annotations

import numpy as np

from neurframe_cli.mesh.arrays import Features, Floats
from neurframe_cli.mesh.features import features_from_edges


def lasting_features(V: Floats, features: Features, shortest: float) -> Features:
    """The features without the connected lines over V (n,3) that are in all shorter than `shortest`.

    Scans bend by more than any feature angle here and there; a corner of such a crease, where the quads have none,
    holds a vertex in a place where its quads cannot become convex.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    a, b = features.edges.T
    graph = coo_matrix((np.ones(len(a)), (a, b)), shape=(len(V), len(V)))
    line = connected_components(graph, directed=False)[1]
    length = np.bincount(line[a], np.linalg.norm(V[a] - V[b], axis=1), minlength=len(V))
    kept = length[line[a]] >= shortest
    return features if kept.all() else features_from_edges(V, features.edges[kept], features.corners)

"""Point location by nearest centroids: enough for a picture."""

from __future__ import annotations

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints

CANDIDATES = 64


def containing_tets(V: Floats, T: Ints, points: Floats) -> Ints:
    """The tet (n,) that holds each point (n,3), -1 where none of the CANDIDATES with nearest centroids does."""
    from scipy.spatial import cKDTree

    near = cKDTree(V[T].mean(axis=1)).query(points, k=min(CANDIDATES, len(T)))[1].reshape(len(points), -1)
    edges = V[T[:, 1:]] - V[T[:, :1]]
    solid = np.abs(np.linalg.det(edges)) > 0
    inverse = np.zeros_like(edges)
    inverse[solid] = np.linalg.inv(edges[solid])
    local = np.einsum("nki,nkij->nkj", points[:, None] - V[T[near, 0]], inverse[near])
    weights = np.concatenate([local, 1.0 - local.sum(axis=2, keepdims=True)], axis=2)
    inside = (weights.min(axis=2) >= -1e-9) & solid[near]
    found = near[np.arange(len(points)), inside.argmax(axis=1)]
    return np.where(inside.any(axis=1), found, -1)

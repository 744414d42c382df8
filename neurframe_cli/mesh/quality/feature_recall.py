"""How much of the input's sharp edges the edges of a mesh follow."""

from __future__ import annotations

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints


def feature_recall(
    V: Floats, features: Ints, mesh_V: Floats, mesh_edges: Ints, tolerance: float
) -> float | None:
    """Share of the length of `features` (k,2 vertex pairs of V) within `tolerance` of `mesh_edges`; None without any.

    Both sides are sampled at half the tolerance.
    """
    if len(features) == 0:
        return None
    from scipy.spatial import cKDTree

    queries, weights = sample_segments(V[features[:, 0]], V[features[:, 1]], tolerance / 2)
    targets, _ = sample_segments(mesh_V[mesh_edges[:, 0]], mesh_V[mesh_edges[:, 1]], tolerance / 2)
    near = cKDTree(targets).query(queries, distance_upper_bound=2 * tolerance)[0] <= tolerance
    return float(weights[near].sum() / weights.sum())


def sample_segments(A: Floats, B: Floats, step: float) -> tuple[Floats, Floats]:
    """Points (n,3) at most `step` apart along the segments A-B, and the length (n,) that each stands for."""
    lengths = np.linalg.norm(B - A, axis=1)
    counts = np.maximum(1, np.ceil(lengths / step)).astype(np.int64)
    owner = np.repeat(np.arange(len(A)), counts)
    first = np.concatenate([[0], np.cumsum(counts)[:-1]])
    t = (np.arange(len(owner)) - first[owner] + 0.5) / counts[owner]
    points = A[owner] + t[:, None] * (B - A)[owner]
    return points, (lengths / counts)[owner]

"""What of a surface's features elements of a given size can follow: long curves, and tips that are no feature."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from neurframe_cli.mesh.arrays import Features, Ints, Surface
from neurframe_cli.mesh.features import features_from_edges
from neurframe_cli.mesh.optimize.simplex_tree import SimplexTree

LEAST_CURVE = 1.5  # lengths of an element; no edge needs to follow a shorter one
BINS = 8  # of a length
# Gaussian curvature within an element's length; a half ball has 2 pi, the corner of a cube pi / 2
POINTED = 0.75 * np.pi


def followed_features(surface: Surface, features: Features, length: float) -> Features:
    """The feature curves that are not too short for elements of `length`, and as corners of their own the tips that are
    farther than that from them."""
    steps = [surface.V[chain[1:]] - surface.V[chain[:-1]] for chain in features.chains]
    long = [
        chain
        for chain, step in zip(features.chains, steps, strict=True)
        if np.linalg.norm(step, axis=1).sum() >= LEAST_CURVE * length
    ]
    edges = [np.stack([chain[1:], chain[:-1]], axis=1) for chain in long]
    kept = features_from_edges(
        surface.V, np.concatenate([*edges, np.zeros((0, 2), np.int64)]), features.corners
    )
    tips = surface_tips(surface, length)
    if len(tips) and len(kept.edges):
        tips = tips[SimplexTree(surface.V, kept.edges).distances(surface.V[tips]) > length]
    return replace(kept, corners=np.union1d(kept.corners, tips).astype(np.int64))


def surface_tips(surface: Surface, length: float) -> Ints:
    """Vertices (k,) of the surface, at least twice `length` apart, round which the Gaussian curvature within `length`
    is more than POINTED, the most pointed of their surroundings.  Both to an eighth of `length`: vertices closer
    together are one place, however fine the surface is."""
    import igl
    from scipy.spatial import cKDTree

    used = np.unique(surface.F)
    P, curvature = surface.V[used], np.asarray(igl.gaussian_curvature(surface.V, surface.F))[used]
    bins = np.floor((P - P.min(axis=0)) * (BINS / length)).astype(np.int64)
    place = np.unique(bins, axis=0, return_inverse=True)[1].reshape(-1)
    many = np.bincount(place)
    centres = np.stack([np.bincount(place, P[:, d]) / many for d in range(3)], axis=1)
    mass = np.bincount(place, curvature)
    tree = cKDTree(centres)
    within = np.array([mass[near].sum() for near in tree.query_ball_point(centres, length)])
    free, tips = np.ones(len(centres), bool), []
    for i in np.argsort(-within, kind="stable"):
        if within[i] <= POINTED:
            break
        if free[i]:
            members = np.flatnonzero(place == i)
            tips.append(int(used[members[curvature[members].argmax()]]))
            free[tree.query_ball_point(centres[i], 2 * length)] = False
    return np.array(sorted(tips), np.int64)

"""Where the planes of a grid lie: through flat parts and straight edges of the surface, evenly in between."""

from __future__ import annotations

import itertools

import numpy as np

from neurframe_cli.mesh.arrays import Features, Floats, Surface

FLAT = np.cos(
    np.radians(5.0)
)  # least cosine between an axis and the normal of a triangle in a plane of the grid
IN_PLANE = np.sin(np.radians(5.0))  # largest sine between the plane and an edge in it
LEAST_GAP = 0.3  # edge lengths between two planes
WORTH = 2.0  # squares of the edge length that a plane has to carry
BESIDE = 0.5  # edge lengths of the strip that an edge of the surface counts for


def grid_planes(
    surface: Surface, features: Features, axes: Floats, edge_length: float
) -> tuple[Floats, Floats, Floats]:
    """Places (k,) of the planes along each of the axes (3,3), from one end of the surface to the other.

    Those that carry most of the surface come first: flat parts count with their area, feature edges with a strip along
    them.  Planes nearer than LEAST_GAP to one of these are left out, and what is left between is divided evenly.
    """
    planes = [_planes(surface, features, axis, edge_length) for axis in axes]
    return planes[0], planes[1], planes[2]


def _planes(surface: Surface, features: Features, axis: Floats, edge_length: float) -> Floats:
    """Those along one axis."""
    ends = surface.V[np.unique(surface.F)] @ axis
    lower, upper = float(ends.min()), float(ends.max())
    places, weights = _carried(surface, features, axis, edge_length)
    gap = LEAST_GAP * edge_length
    kept = [lower, upper]
    for place, weight in _peaks(places, weights, gap):
        if weight < WORTH * edge_length**2:
            break
        if min(abs(place - other) for other in kept) >= gap:
            kept.append(place)
    kept.sort()
    parts = [
        np.linspace(a, b, max(1, round((b - a) / edge_length)) + 1)[:-1] for a, b in itertools.pairwise(kept)
    ]
    return np.append(np.concatenate(parts), upper)


def _carried(surface: Surface, features: Features, axis: Floats, edge_length: float) -> tuple[Floats, Floats]:
    """Places (k,) along the axis of triangles and feature edges across it, and their areas (k,)."""
    A, B, C = (surface.V[surface.F[:, i]] for i in range(3))
    normal = np.cross(B - A, C - A)
    twice = np.linalg.norm(normal, axis=1)
    flat = np.abs(normal @ axis) > FLAT * np.maximum(twice, np.finfo(float).tiny)
    ends = surface.V[features.edges]
    edge = ends[:, 1] - ends[:, 0]
    length = np.linalg.norm(edge, axis=1)
    within = np.abs(edge @ axis) < IN_PLANE * length
    places = np.concatenate([((A + B + C) @ axis)[flat] / 3.0, (ends.mean(axis=1) @ axis)[within]])
    return places, np.concatenate([twice[flat] / 2.0, BESIDE * edge_length * length[within]])


def _peaks(places: Floats, weights: Floats, gap: float) -> list[tuple[float, float]]:
    """Centres and weights of what lies together within a tenth of `gap`, the heaviest first."""
    order = np.argsort(places, kind="stable")
    places, weights = places[order], weights[order]
    starts = np.flatnonzero(np.diff(places, prepend=-np.inf) > 0.1 * gap)
    if len(starts) == 0:
        return []
    total = np.add.reduceat(weights, starts)
    centres = np.add.reduceat(places * weights, starts) / np.maximum(total, np.finfo(float).tiny)
    return sorted(zip(centres.tolist(), total.tolist(), strict=True), key=lambda peak: -peak[1])

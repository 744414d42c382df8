"""Smaller quads where the surface bends: a factor on the edge length per vertex."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from neurframe_cli.errors import UsageError
from neurframe_cli.mesh.arrays import Features, Floats, Ints, Surface
from neurframe_cli.mesh.measure import box_diagonal
from neurframe_cli.mesh.optimize.patches import components_cut_by
from neurframe_cli.mesh.surface_edges import surface_edges

FLATTEST = 1e-3  # curvature times bounding-box diagonal below which a surface counts as flat
BALANCING_ROUNDS = 20


@dataclass(frozen=True)
class SizingOptions:
    """strength: 0 gives equal quads, 1 the same chord error everywhere; range: the factors lie within
    [1 / range^strength, range^strength]; gradation: growth of the edge length per unit of length."""

    strength: float = 0.5
    range: float = 3.0
    gradation: float = 0.2


def curvature_sizing(
    surface: Surface, features: Features, edge_length: float, options: SizingOptions
) -> Floats:
    """Factors (n,) on `edge_length` at the vertices of a surface.

    A chord of length h is off an arc of curvature k by k h² / 8, so that the same error everywhere asks for
    h ~ 1 / sqrt(k).  The factors are scaled to leave the number of quads, the integral of 1 / h², as it would be
    without them, as far as their range allows.  Raises UsageError for a strength outside [0, 1].
    """
    if not 0.0 <= options.strength <= 1.0:
        raise UsageError(f"the strength of --adaptive is {options.strength:g}, it must be from 0 to 1")
    diagonal = box_diagonal(surface.V)
    curvature = np.maximum(largest_curvature(surface, features), FLATTEST / diagonal)
    wanted = curvature ** (-options.strength / 2)
    widest = options.range**options.strength
    weight = vertex_areas(surface)
    wanted /= np.sqrt(weight.sum() / np.sum(weight / wanted**2))
    scale = 1.0
    for _ in range(BALANCING_ROUNDS):
        factors = _graded(
            surface, np.clip(scale * wanted, 1 / widest, widest), options.gradation / edge_length
        )
        scale *= float(np.sqrt(np.sum(weight / factors**2) / weight.sum()))
    return factors


def largest_curvature(surface: Surface, features: Features) -> Floats:
    """Larger magnitude (n,) of the two principal curvatures at each vertex, in 1 / length.

    Quadrics are fitted (Panozzo, Puppo, Rocca 2010, as libigl does) to each part between the features by itself: a
    sharp edge is no curvature that smaller quads could follow.
    """
    import igl

    part = components_cut_by(surface.F, features.edges)
    result = np.zeros(len(surface.V))
    for p in range(int(part.max()) + 1):
        used, F = np.unique(surface.F[part == p], return_inverse=True)
        if len(used) < 6:
            continue  # fewer than the coefficients of a quadric
        F = np.ascontiguousarray(F.reshape(-1, 3), np.int64)
        _, _, k1, k2, _ = igl.principal_curvature(np.ascontiguousarray(surface.V[used]), F)
        found = np.nan_to_num(np.maximum(np.abs(k1), np.abs(k2)).reshape(-1), posinf=0.0)
        result[used] = np.maximum(result[used], found)
    return result


def vertex_areas(surface: Surface) -> Floats:
    """A third of the area (n,) of the triangles at each vertex."""
    A, B, C = (surface.V[surface.F[:, i]] for i in range(3))
    area = np.linalg.norm(np.cross(B - A, C - A), axis=1) / 6
    return np.asarray(np.bincount(surface.F.ravel(), np.repeat(area, 3), minlength=len(surface.V)))


def _graded(surface: Surface, factors: Floats, slope: float) -> Floats:
    """The largest factors (n,) below the given ones that grow by at most `slope` per length along the edges."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import dijkstra

    n = len(surface.V)
    a, b = surface_edges(surface.V, surface.F).edges.T
    step = slope * np.linalg.norm(surface.V[a] - surface.V[b], axis=1)
    # the shortest way from one more node, whose edges are as long as the factors
    rows: Ints = np.concatenate([a, np.full(n, n)])
    columns: Ints = np.concatenate([b, np.arange(n)])
    graph = coo_matrix((np.concatenate([step, factors]), (rows, columns)), shape=(n + 1, n + 1))
    return np.asarray(dijkstra(graph.tocsr(), directed=False, indices=n)[:n])

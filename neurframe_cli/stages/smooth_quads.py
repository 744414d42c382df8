"""Smoothing of a quad mesh on the surface that it was made from."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from neurframe_cli.mesh.arrays import Features, Floats, Ints, Progress, Surface, silent
from neurframe_cli.mesh.features import features_from_edges
from neurframe_cli.mesh.optimize.cell_kind import QUADS
from neurframe_cli.mesh.optimize.lasting_features import lasting_features
from neurframe_cli.mesh.optimize.smooth import SmoothedMesh, SmoothOptions, smooth_cells
from neurframe_cli.mesh.quality.polygons import unique_edges
from neurframe_cli.mesh.quality.scaled_jacobian import quad_scaled_jacobians

# a mesh is valid up to 0.01, but samples do not see all of a distance
QUAD_OPTIONS = SmoothOptions(hausdorff_limit=0.006)
RELEASE = 3.0  # edges of the quads round a folded one
SHORTEST_LINE = 4.0  # edges of the quads; neurframe-miq leaves shorter feature lines out, too


def smooth_quads(
    V: Floats,
    Q: Ints,
    surface: Surface,
    features: Features,
    options: SmoothOptions,
    progress: Progress = silent,
) -> SmoothedMesh:
    """New positions of the vertices V (n,3) of quads Q (q,4), counter-clockwise seen from outside.

    Vertices stay on the surface, those on feature curves and open boundaries on these, those at corners in place; no
    quad becomes worse than the worst one was, and none that faced outward turns over.  Feature lines shorter than
    SHORTEST_LINE do not count.  Curves let go of vertices around quads that stay poor, and where some stay folded, the
    feature edges around them are released: a mesh that cuts a corner is of more use than one that is folded there.
    """
    followed = lasting_features(surface.V, features, SHORTEST_LINE * _median_edge(V, Q))
    smoothed = smooth_cells(V, Q, QUADS, Q, surface, followed, options, progress)
    if smoothed.report.after.inverted == 0:
        return smoothed
    released = _released(smoothed.V, Q, surface, followed)
    return _better(smoothed, smooth_cells(smoothed.V, Q, QUADS, Q, surface, released, options, silent))


def _better(first: SmoothedMesh, second: SmoothedMesh) -> SmoothedMesh:
    """The one with fewer inverted quads, then with the better worst one; `second` began where `first` ended."""
    one, other = first.report.after, second.report.after
    if (-other.inverted, other.min_scaled_jacobian) <= (-one.inverted, one.min_scaled_jacobian):
        return first
    return SmoothedMesh(second.V, replace(second.report, before=first.report.before))


def _released(V: Floats, Q: Ints, surface: Surface, features: Features) -> Features:
    """`features` without the edges that come within RELEASE quad edges of a folded quad."""
    from scipy.spatial import cKDTree

    folded = V[Q[quad_scaled_jacobians(V, Q).min(axis=1) <= 0]]
    if len(folded) == 0 or len(features.edges) == 0:
        return features
    middles = surface.V[features.edges].mean(axis=1)
    away = cKDTree(folded.reshape(-1, 3)).query(middles)[0]
    kept = features.edges[away > RELEASE * _median_edge(V, Q)]
    return features_from_edges(surface.V, kept, np.intersect1d(features.corners, kept))


def _median_edge(V: Floats, Q: Ints) -> float:
    edges, _ = unique_edges(Q)
    lengths = np.linalg.norm(V[edges[:, 0]] - V[edges[:, 1]], axis=1)
    return float(np.median(lengths)) if len(lengths) else 0.0

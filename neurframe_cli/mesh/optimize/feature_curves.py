"""Feature edges and open boundaries of a surface as curves between corners."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from neurframe_cli.mesh.arrays import Bools, Features, Ints, Surface
from neurframe_cli.mesh.features import features_from_edges
from neurframe_cli.mesh.quality.polygons import unique_edges


@dataclass(frozen=True)
class FeatureCurves:
    """curves: vertex sequences that cover every edge once and have corners at their ends only (closed curves without
    a corner repeat their first vertex); on_boundary (k,) which of them lie on open boundaries; corners (c,) int64
    vertices that must not move; corners_on_boundary (c,)."""

    curves: tuple[Ints, ...]
    on_boundary: Bools
    corners: Ints
    corners_on_boundary: Bools


def feature_curves(surface: Surface, features: Features) -> FeatureCurves:
    """Curves over the feature edges and the boundary edges of the surface."""
    edges, use = unique_edges(surface.F)
    rim_edges = edges[use == 1]
    graph = features_from_edges(surface.V, np.concatenate([features.edges, rim_edges]), features.corners)
    rim = set(map(tuple, rim_edges.tolist()))
    on_boundary = [(min(c[0], c[1]), max(c[0], c[1])) in rim for c in graph.chains]
    corners = np.union1d(graph.corners, features.corners).astype(np.int64)  # some may lie on no curve
    return FeatureCurves(graph.chains, np.array(on_boundary, bool), corners, np.isin(corners, rim_edges))

"""Smoothing of a quad mesh on the surface that it was made from."""

from __future__ import annotations

import numpy as np

from neurframe_cli.mesh.arrays import Features, Floats, Ints, Progress, Surface, silent
from neurframe_cli.mesh.optimize.cell_kind import QUADS
from neurframe_cli.mesh.optimize.lasting_features import lasting_features
from neurframe_cli.mesh.optimize.smooth import SmoothedMesh, SmoothOptions, smooth_cells
from neurframe_cli.mesh.quality.polygons import unique_edges

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
    SHORTEST_LINE do not count.
    """
    edges, _ = unique_edges(Q)
    lengths = np.linalg.norm(V[edges[:, 0]] - V[edges[:, 1]], axis=1)
    shortest = SHORTEST_LINE * float(np.median(lengths)) if len(lengths) else 0.0
    followed = lasting_features(surface.V, features, shortest)
    return smooth_cells(V, Q, QUADS, Q, surface, followed, options, progress)

"""Smoothing of a quad mesh on the surface that it was made from."""

from __future__ import annotations

from neurframe_cli.mesh.arrays import Features, Floats, Ints, Progress, Surface, silent
from neurframe_cli.mesh.optimize.cell_kind import QUADS
from neurframe_cli.mesh.optimize.smooth import SmoothedMesh, SmoothOptions, smooth_cells


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
    quad becomes worse than the worst one was, and none that faced outward turns over.
    """
    return smooth_cells(V, Q, QUADS, Q, surface, features, options, progress)

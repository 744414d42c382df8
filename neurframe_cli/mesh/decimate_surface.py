"""Fewer triangles for the same surface."""

from __future__ import annotations

import numpy as np

from neurframe_cli.mesh.arrays import Surface, as_surface
from neurframe_cli.mesh.measure import box_diagonal
from neurframe_cli.mesh.surface_distance import distances, sample_surface

FEWEST_TRIANGLES = 200
KEPT = 0.7  # of the triangles, from one try to the next
FINEST_SPACING = 0.005  # of the bounding-box diagonal: where distances are measured besides at the vertices


def decimated_surface(surface: Surface, tolerance: float) -> Surface:
    """`surface` with 70 % of its triangles, 49 %, ... as long as both stay within `tolerance` of each other.

    Edges are collapsed by quadric error (Garland and Heckbert, "Surface simplification using quadric error metrics",
    SIGGRAPH 1997; libigl's qslim), which keeps the topology.  The surface must be manifold; tolerance is in its
    units.  Where nothing can be left out, `surface` itself is returned.
    """
    import igl

    best = surface
    while len(best.F) > FEWEST_TRIANGLES:
        V, F, _, _ = igl.qslim(best.V, best.F.astype(np.int32), int(KEPT * len(best.F)))
        fewer = as_surface(V, F)
        if len(fewer.F) == len(best.F) or deviation(fewer, surface) > tolerance:
            break
        best = fewer
    return best


def deviation(a: Surface, b: Surface) -> float:
    """The larger of the two one-sided distances between the surfaces, at samples."""
    spacing = FINEST_SPACING * box_diagonal(b.V)
    there, back = (distances(sample_surface(p.V, p.F, spacing), q.V, q.F).max() for p, q in ((a, b), (b, a)))
    return float(max(there, back))

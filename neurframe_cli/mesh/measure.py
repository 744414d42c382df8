"""Area, volume and size of triangle meshes."""

from __future__ import annotations

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints


def box_diagonal(points: Floats) -> float:
    """Length of the diagonal of the bounding box of points (n,3)."""
    return float(np.linalg.norm(np.ptp(points, axis=0)))


def triangle_areas(V: Floats, F: Ints) -> Floats:
    """Area (m,) of each triangle."""
    import igl

    return np.asarray(igl.doublearea(V, F), np.float64) / 2


def surface_area(V: Floats, F: Ints) -> float:
    """Area of all triangles."""
    return float(triangle_areas(V, F).sum())


def enclosed_volume(V: Floats, F: Ints) -> float:
    """Signed volume of a closed surface, positive when its triangles are counter-clockwise seen from outside.

    About a corner of the model, so that one far from the origin does not cancel.
    """
    A, B, C = ((V - V[F[0, 0]])[F[:, i]] for i in range(3))
    return float(np.einsum("ij,ij->", np.cross(A, B), C) / 6)

"""Which triangles carry the cross field: the input's, or the boundary of the tets."""

from __future__ import annotations

from typing import Literal

import numpy as np

from neurframe_cli.errors import UsageError
from neurframe_cli.mesh.arrays import Floats, Ints, Surface, TetMesh
from neurframe_cli.mesh.manifold_boundary import boundary_surface
from neurframe_cli.mesh.surface_edges import surface_edges

Choice = Literal["auto", "input", "tets"]
# A cross is sampled once a triangle and a parametrisation is linear on it, so the input's triangles must be no
# larger than the tets' and no needles; CAD tessellations are both.
LARGEST_EDGE = 2.0  # in mean edges of the tets' boundary
SMALLEST_ANGLE_DEG = 5.0


def choose_cross_surface(surface: Surface, tets: TetMesh, choice: Choice) -> tuple[Surface, str]:
    """The surface for the crosses, and why it was chosen; raises UsageError for an unknown choice."""
    boundary = Surface(*boundary_surface(tets))
    if choice == "input":
        return surface, "the input surface, as asked"
    if choice == "tets":
        return boundary, "the boundary of the tets, as asked"
    if choice != "auto":
        raise UsageError(f"surface {choice!r} is not one of auto, input, tets")
    reason = _objection(surface, boundary)
    return (boundary, f"the boundary of the tets: {reason}") if reason else (surface, "the input surface")


def _objection(surface: Surface, boundary: Surface) -> str | None:
    """What speaks against the input surface, None where nothing does."""
    if (surface_edges(surface.V, surface.F).face_count != 2).any():
        return "the input is open or not manifold"
    longest = edge_lengths(surface.V, surface.F).max() / edge_lengths(boundary.V, boundary.F).mean()
    if longest > LARGEST_EDGE:
        return f"an input triangle has an edge of {longest:.1f} edges of the tets"
    smallest = float(corner_angles_deg(surface.V, surface.F).min())
    if smallest < SMALLEST_ANGLE_DEG:
        return f"an input triangle has an angle of {smallest:.1f} degrees"
    return None


def edge_lengths(V: Floats, F: Ints) -> Floats:
    """(m,3) lengths of the edges opposite each corner."""
    return np.asarray(np.linalg.norm(V[F[:, [1, 2, 0]]] - V[F[:, [2, 0, 1]]], axis=2))


def corner_angles_deg(V: Floats, F: Ints) -> Floats:
    """(m,3) angles in degrees; a triangle without area has a zero among them."""
    P = V[F]
    ahead, behind = P[:, [1, 2, 0]] - P, P[:, [2, 0, 1]] - P
    sine = np.linalg.norm(np.cross(ahead, behind), axis=2)
    return np.asarray(np.degrees(np.arctan2(sine, np.einsum("nci,nci->nc", ahead, behind))))

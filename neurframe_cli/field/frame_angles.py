"""How far frames are from the directions that they should follow: normals on the boundary, feature edges."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from neurframe_cli.field.edge_rings import TET_EDGES
from neurframe_cli.mesh.arrays import Floats, Ints
from neurframe_cli.mesh.surface_edges import face_normals
from neurframe_cli.mesh.tet_adjacency import TetAdjacency


@dataclass(frozen=True)
class Deviation:
    """Mean and largest of some angles in degrees, and how many there were; zeros for none."""

    mean_deg: float
    max_deg: float
    count: int


def deviation(angles_deg: Floats) -> Deviation:
    """Mean and maximum of angles (n,)."""
    if not len(angles_deg):
        return Deviation(0.0, 0.0, 0)
    return Deviation(float(angles_deg.mean()), float(angles_deg.max()), len(angles_deg))


def axis_angles_deg(frames: Floats, directions: Floats) -> Floats:
    """Angles in degrees between directions (n,3), any length, and the nearest axes of frames (n,3,3): (n,)."""
    inner = np.abs(np.einsum("nij,ni->nj", frames, directions))
    nearest = np.take_along_axis(frames, inner.argmax(axis=1)[:, None, None], axis=2)[..., 0]
    across = np.linalg.norm(np.cross(directions, nearest), axis=1)
    return np.asarray(np.degrees(np.arctan2(across, inner.max(axis=1))))


def normal_angles_deg(V: Floats, adjacency: TetAdjacency, frames: Floats) -> Floats:
    """Angles between the normal of each boundary face and the frame of its tet: (b,)."""
    return axis_angles_deg(frames[adjacency.boundary_tets], face_normals(V, adjacency.boundary_faces))


def feature_angles_deg(V: Floats, T: Ints, edges: Ints, frames: Floats) -> Floats:
    """Angles between feature edges (k,2) and the frames of all tets that have them, one per such pair."""
    n = len(V)
    tet_edges = np.sort(T[:, TET_EDGES].reshape(-1, 2), axis=1)
    wanted = np.sort(edges.reshape(-1, 2), axis=1)
    have = np.flatnonzero(np.isin(tet_edges @ [n, 1], wanted @ [n, 1]))
    pairs = tet_edges[have]
    return axis_angles_deg(frames[have // 6], V[pairs[:, 1]] - V[pairs[:, 0]])

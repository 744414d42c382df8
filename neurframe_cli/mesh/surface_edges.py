"""Edges of a triangle mesh with what meets there."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints


@dataclass(frozen=True)
class SurfaceEdges:
    """edges (e,2) int64, smaller vertex first, sorted; face_count (e,) how many triangles meet at each;
    angles_deg (e,) the angle between the normals of its two triangles, 180 where other than two meet."""

    edges: Ints
    face_count: Ints
    angles_deg: Floats


def face_normals(V: Floats, F: Ints) -> Floats:
    """(m,3) unit normals, zero for triangles without area."""
    normals = np.cross(V[F[:, 1]] - V[F[:, 0]], V[F[:, 2]] - V[F[:, 0]])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.asarray(np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0))


def directed_edges(F: Ints) -> Ints:
    """(3m,2) the three edges of each triangle in its direction, triangle after triangle."""
    return F[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)


def surface_edges(V: Floats, F: Ints) -> SurfaceEdges:
    """Edges of V (n,3), F (m,3).

    Where two triangles run along their edge in the same direction one of them is turned for the angle; a triangle
    without area has no direction and makes no angle.
    """
    directed = directed_edges(F)
    edges, edge_of, face_count = np.unique(
        np.sort(directed, axis=1), axis=0, return_inverse=True, return_counts=True
    )
    edge_of = edge_of.reshape(-1)
    order = np.argsort(edge_of, kind="stable")
    first = order[(np.cumsum(face_count) - face_count)[face_count == 2]]
    second = order[(np.cumsum(face_count) - face_count)[face_count == 2] + 1]
    normals = face_normals(V, F)
    one, two = normals[first // 3], normals[second // 3]
    two = np.where((directed[first, 0] == directed[second, 0])[:, None], -two, two)
    angles = np.full(len(edges), 180.0)
    sine = np.linalg.norm(np.cross(one, two), axis=1)
    angles[face_count == 2] = np.degrees(np.arctan2(sine, np.einsum("ij,ij->i", one, two)))
    return SurfaceEdges(edges, face_count, angles)

"""Closest points on a set of triangles or of segments, with a direction field that is continuous over them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints

SMALLEST = 1e-300  # keeps the direction of a degenerate simplex finite


@dataclass(frozen=True)
class FootPoints:
    """Closest points (k,3), the simplex of each (k,), its barycentric weights (k,2 or 3), unit directions (k,3)."""

    points: Floats
    simplices: Ints
    weights: Floats
    directions: Floats


class SimplexTree:
    """Bounding-box tree over the simplices S (m,2) segments or (m,3) triangles of V (n,3).

    The direction at a point interpolates vertex normals (triangles) or vertex tangents (segments), so that it does not
    jump from facet to facet: a vertex that lies exactly on an edge of the input has one tangent plane, whatever
    rounding makes of the tie between the two facets.
    """

    def __init__(self, V: Floats, S: Ints) -> None:
        import igl

        used, local = np.unique(S, return_inverse=True)
        self.V: Floats = np.ascontiguousarray(V[used])
        self.S: Ints = np.ascontiguousarray(local.reshape(S.shape))
        self._tree = igl.AABB()
        self._tree.init(self.V, self.S)

    @cached_property
    def directions(self) -> Floats:
        """Unit normals or tangents (n,3) at the vertices."""
        return _vertex_normals(self.V, self.S) if self.S.shape[1] == 3 else _vertex_tangents(self.V, self.S)

    def distances(self, P: Floats) -> Floats:
        """Exact distances (k,) of P (k,3)."""
        return self.nearest(P)[0]

    def nearest(self, P: Floats) -> tuple[Floats, Ints]:
        """Exact distances (k,) of P (k,3) and the closest simplices (k,)."""
        squared, simplices, _ = self._tree.squared_distance(self.V, self.S, np.ascontiguousarray(P))
        return np.asarray(np.sqrt(np.maximum(squared.reshape(-1), 0.0))), simplices.reshape(-1)

    def closest(self, P: Floats) -> FootPoints:
        """Exact closest points of P (k,3)."""
        _, simplices, points = self._tree.squared_distance(self.V, self.S, np.ascontiguousarray(P))
        simplices, points = (
            simplices.reshape(-1),
            points.reshape(-1, 3),
        )  # igl drops the axis of a single query
        corners = self.S[simplices]
        weights = _barycentric(points, self.V[corners])
        directions = _unit(np.einsum("kc,kcd->kd", weights, self.directions[corners]))
        return FootPoints(points, simplices, weights, directions)


def _unit(vectors: Floats) -> Floats:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), SMALLEST))


def _vertex_tangents(V: Floats, S: Ints) -> Floats:
    """Mean direction of the segments at each vertex (n,3); segments are oriented along the curve."""
    tangents = np.zeros_like(V)
    along = _unit(V[S[:, 1]] - V[S[:, 0]])
    np.add.at(tangents, S, along[:, None, :])
    return _unit(tangents)


def _vertex_normals(V: Floats, S: Ints) -> Floats:
    """Mean normal (n,3) of the triangles at each vertex, weighted by their angles there (Thürmer & Wüthrich 1998)."""
    P = V[S]
    face = _unit(np.cross(P[:, 1] - P[:, 0], P[:, 2] - P[:, 0]))
    ahead, behind = _unit(np.roll(P, -1, axis=1) - P), _unit(np.roll(P, 1, axis=1) - P)
    angles = np.arccos(np.clip(np.einsum("mcd,mcd->mc", ahead, behind), -1.0, 1.0))
    normals = np.zeros_like(V)
    np.add.at(normals, S, angles[:, :, None] * face[:, None, :])
    return _unit(normals)


def _barycentric(points: Floats, corners: Floats) -> Floats:
    """Weights (k,c) of points on simplices with corners (k,c,3); the last corner of a degenerate simplex gets 1."""
    edges = corners[:, :-1] - corners[:, -1:]
    gram = np.einsum("kid,kjd->kij", edges, edges)
    right = np.einsum("kid,kd->ki", edges, points - corners[:, -1])
    if edges.shape[1] == 1:
        first = right / np.maximum(gram[:, 0], SMALLEST)
    else:
        determinant = gram[:, 0, 0] * gram[:, 1, 1] - gram[:, 0, 1] ** 2
        first = (
            np.stack(
                [
                    gram[:, 1, 1] * right[:, 0] - gram[:, 0, 1] * right[:, 1],
                    gram[:, 0, 0] * right[:, 1] - gram[:, 0, 1] * right[:, 0],
                ],
                axis=1,
            )
            / np.maximum(determinant, SMALLEST)[:, None]
        )
    weights = np.clip(np.concatenate([first, 1.0 - first.sum(axis=1, keepdims=True)], axis=1), 0.0, 1.0)
    return np.asarray(weights / weights.sum(axis=1, keepdims=True))

"""Pyramids on the quads that face a void."""

from __future__ import annotations

import numpy as np

from neurframe_cli.mesh.arrays import Bools, Floats, Ints

HEIGHT = 0.4  # of the edge length of the quad, where there is room
CLEARANCE = (
    1.5  # heights between an apex and the next face: two that face each other take 4/5 of the gap at most
)
HALVINGS = 4
LEAST_JACOBIAN = 0.03  # at the base; a square base with an apex as high as 1/20 of its side has 0.07


def pyramid_apexes(V: Floats, quads: Ints, others: Ints) -> tuple[Floats, Bools]:
    """Apexes (q,3) of pyramids on quads (q,4), in front of them, and for which (q,) there is room.

    others (t,3): triangles that bound the void beside the quads; V (n,3) are the vertices of both.
    """
    P = V[quads]
    size = np.linalg.norm(P - np.roll(P, -1, axis=1), axis=2).mean(axis=1)
    normal = np.cross(P[:, 2] - P[:, 0], P[:, 3] - P[:, 1])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    centre, height = P.mean(axis=1), HEIGHT * size
    obstacles = _Obstacles(V, quads, others)
    room = np.zeros(len(quads), bool)
    for _ in range(HALVINGS):
        apex = centre + height[:, None] * normal
        for q in np.flatnonzero(~room).tolist():
            room[q] = obstacles.are_farther(apex[q], CLEARANCE * height[q], q)
        height[~room] *= 0.5
    apex = centre + np.where(room, height, 2.0 * height)[:, None] * normal
    return apex, room & (base_jacobians(V, quads, apex) > LEAST_JACOBIAN).all(axis=1)


class _Obstacles:
    """The triangles that bound a void, two to a quad."""

    def __init__(self, V: Floats, quads: Ints, others: Ints) -> None:
        self.V = V
        halves = [quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]
        self.triangles = np.concatenate([*halves, others.reshape(-1, 3)])
        self.of_quad = np.concatenate([np.tile(np.arange(len(quads)), 2), np.full(len(others), -1)])
        corners = V[self.triangles]
        self.centre = corners.mean(axis=1)
        self.radius = np.linalg.norm(corners - self.centre[:, None], axis=2).max(axis=1)

    def are_farther(self, point: Floats, distance: float, quad: int) -> bool:
        """Whether every triangle but those of the quad is farther than `distance` from the point."""
        import igl

        near = np.linalg.norm(self.centre - point, axis=1) < self.radius + distance
        near &= self.of_quad != quad
        if not near.any():
            return True
        squared = igl.point_mesh_squared_distance(point[None], self.V, self.triangles[near])[0]
        return bool(np.sqrt(max(float(np.ravel(squared)[0]), 0.0)) > distance)


def base_jacobians(V: Floats, quads: Ints, apex: Floats) -> Floats:
    """Volume (q,4) of the edges at the corners of the base, of unit vectors; positive in a valid pyramid."""
    P = V[quads]
    edges = np.stack([np.roll(P, -1, axis=1) - P, np.roll(P, 1, axis=1) - P, apex[:, None, :] - P], axis=2)
    edges /= np.maximum(np.linalg.norm(edges, axis=-1, keepdims=True), 1e-300)
    return np.asarray(np.linalg.det(edges))


def side_triangles(quads: Ints, apex: Ints) -> Ints:
    """The four triangles (4q,3) on each base (q,4) with the vertex `apex` (q,), seen from inside the pyramid."""
    following = np.roll(quads, -1, axis=1)
    return np.stack([following.ravel(), quads.ravel(), np.repeat(apex, 4)], axis=1).astype(np.int64)

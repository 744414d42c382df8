"""One step of many streamlines at once: through a volume, or on a surface."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from neurframe_cli.field.rotations import exponential
from neurframe_cli.mesh.arrays import Bools, Floats, Ints, Surface
from neurframe_cli.mesh.inside import depth_in_surface
from neurframe_cli.mesh.surface_edges import face_normals
from neurframe_cli.stages.discretize import Query, sample_frames

# A point that steps over a sharp edge is pulled this much of a step inwards before it is put back on the surface:
# so it comes down on the far side of the edge instead of on the edge itself
_INWARDS = 0.25


@dataclass(frozen=True)
class Heads:
    """Where streamlines are and where they go: points (n,3), unit directions (n,3), and on a surface the normals
    (n,3) of the triangles that they are on."""

    points: Floats
    directions: Floats
    normals: Floats

    def __getitem__(self, which: Bools | Ints) -> Heads:
        return Heads(self.points[which], self.directions[which], self.normals[which])


# heads -> heads a step further, and which of them are still in the domain
Step = Callable[[Heads], tuple[Heads, Bools]]


def step_in_volume(query: Query, boundary: Surface, length: float) -> Step:
    """Midpoint steps along the frame axis nearest to the direction; a line ends where it leaves the body."""

    def step(heads: Heads) -> tuple[Heads, Bools]:
        half_way = nearest_axes(query, heads.points, heads.directions)
        middle = heads.points + 0.5 * length * half_way
        directions = nearest_axes(query, middle, half_way)
        points = heads.points + length * directions
        return Heads(points, directions, heads.normals), depth_in_surface(points, boundary) > 0

    return step


def step_on_surface(query: Query, surface: Surface, length: float) -> Step:
    """Steps along the tangent axis nearest to the direction, each put back on the surface.

    The direction is carried from triangle to triangle by the smallest rotation of their normals.  A line ends
    where it gets nowhere.
    """

    def step(heads: Heads) -> tuple[Heads, Bools]:
        directions = nearest_axes(query, heads.points, heads.directions, heads.normals)
        ahead = heads.points + length * (directions - _INWARDS * heads.normals)
        points, normals = closest_on_surface(surface, ahead)
        moved = np.linalg.norm(points - heads.points, axis=1) > 0.1 * length
        return Heads(points, transported(directions, heads.normals, normals), normals), moved

    return step


def nearest_axes(query: Query, points: Floats, directions: Floats, normals: Floats | None = None) -> Floats:
    """Unit frame axes (n,3) at the points, signed, nearest to the directions.

    With normals (n,3) the axis nearest to each normal is left out and the chosen one made tangent.
    """
    frames = sample_frames(query, points).frames
    rows = np.arange(len(points))
    cosines = np.einsum("nij,ni->nj", frames, directions)
    choice = np.abs(cosines)
    if normals is not None:
        choice[rows, np.abs(np.einsum("nij,ni->nj", frames, normals)).argmax(axis=1)] = -1.0
    chosen = choice.argmax(axis=1)
    axes = frames[rows, :, chosen] * np.where(cosines[rows, chosen] < 0, -1.0, 1.0)[:, None]
    if normals is not None:
        axes -= np.einsum("ni,ni->n", axes, normals)[:, None] * normals
    return np.asarray(axes / np.linalg.norm(axes, axis=1, keepdims=True))


def closest_on_surface(surface: Surface, points: Floats) -> tuple[Floats, Floats]:
    """Closest points (n,3) and the normals of their triangles."""
    import igl

    _, faces, closest = igl.point_mesh_squared_distance(points, surface.V, surface.F)
    return np.asarray(closest), face_normals(surface.V, surface.F[faces])


def transported(directions: Floats, before: Floats, after: Floats) -> Floats:
    """Tangent directions (n,3) turned by the smallest rotation that takes the normals before to those after."""
    axis = np.cross(before, after)
    sine = np.linalg.norm(axis, axis=1)
    angle = np.arctan2(sine, np.einsum("ni,ni->n", before, after))
    rotations = exponential(axis * np.divide(angle, sine, out=np.zeros_like(sine), where=sine > 0)[:, None])
    return np.asarray(np.einsum("nij,nj->ni", rotations, directions))

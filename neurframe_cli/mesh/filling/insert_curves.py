"""Points and straight pieces put into a surface as vertices and edges, its shape unchanged but for the points."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

from neurframe_cli.mesh.arrays import Floats, Ints
from neurframe_cli.mesh.filling.editable_surface import Edge, EditableSurface, sorted_edge
from neurframe_cli.mesh.filling.vectors import Vector, along, cross, distance, dot, minus, plus, unit

SNAP = 0.1  # hex edges: a point takes the place of a vertex, or splits an edge, that is so near
NEAR_END = 0.1  # share of an edge: what crosses it nearer to an end goes through that end
MOST_STEPS = 500  # of a path; one hex edge crosses a few triangles
LEAST_ADVANCE = 0.05  # cosine between a step of a path and its direction


class Blocked(Exception):
    """There is no path on the surface from one vertex to the other that crosses no other path."""


def insert_points(surface: EditableSurface, points: Floats, triangles: Ints, scale: Floats) -> list[int]:
    """The vertices that were moved to `points` (k,3), one each; triangles (k,): of the input, the closest to each.

    scale (k,): edge length of the hexes there.
    """
    taken: list[int] = []
    for place, triangle, h in zip(points.tolist(), triangles.tolist(), scale.tolist(), strict=True):
        point: Vector = tuple(place)
        v = _vertex_for(surface, point, triangle, SNAP * h, taken)
        surface.points[v] = point
        taken.append(v)
    return taken


def _vertex_for(surface: EditableSurface, point: Vector, triangle: int, snap: float, taken: list[int]) -> int:
    """A vertex nearby that is not taken, or a new one on the nearest edge or in the nearest face."""
    faces = sorted(surface.children[triangle])
    corners = {v for face in faces for v in surface.faces[face]} - set(taken)
    nearest = min(corners, key=lambda v: distance(surface.points[v], point), default=None)
    if nearest is not None and distance(surface.points[nearest], point) < snap:
        return nearest
    edges = sorted({sorted_edge(a, b) for face in faces for a, b in _sides(surface, face)})
    # a sharp edge first: the rim of the hexes runs along it
    edges.sort(key=lambda e: (e not in surface.sharp, _edge_distance(surface, e, point)))
    for edge in edges:
        if _edge_distance(surface, edge, point) < snap:
            return surface.split_edge(*edge, point)
    inside = min(faces, key=lambda face: _outside_by(surface, face, point))
    return surface.split_face(inside, point)


def _sides(surface: EditableSurface, face: int) -> list[Edge]:
    a, b, c = surface.faces[face]
    return [(a, b), (b, c), (c, a)]


def _edge_distance(surface: EditableSurface, edge: Edge, point: Vector) -> float:
    a, b = (surface.points[v] for v in edge)
    ab = minus(b, a)
    t = dot(minus(point, a), ab) / max(dot(ab, ab), 1e-300)
    return distance(point, along(a, b, min(max(t, 0.0), 1.0)))


def _outside_by(surface: EditableSurface, face: int, point: Vector) -> float:
    """How far outside its worst side the point lies, negative inside."""
    normal = unit(surface.normal(face))
    worst = -float("inf")
    for a, b in _sides(surface, face):
        outward = cross(minus(surface.points[b], surface.points[a]), normal)
        worst = max(worst, dot(unit(outward), minus(point, surface.points[a])))
    return worst


@dataclass(frozen=True)
class _Cut:
    """A plane through `origin` with the unit normal `side`; vertices that the path may not pass, edges that it may not
    cross."""

    origin: Vector
    side: Vector
    closed: set[int]
    locked: set[Edge]


# where a path goes next: to a vertex, or to a point of an edge
_Step = int | tuple[Edge, Vector]


def connect(surface: EditableSurface, start: int, end: int, closed: set[int], locked: set[Edge]) -> list[int]:
    """Vertices of a path of edges from start to end in the plane that stands on the surface; raises Blocked.

    It crosses no edge of `locked` and passes none of the vertices `closed`; its own edges become locked.
    """
    a, b = surface.points[start], surface.points[end]
    side = unit(cross(minus(b, a), _normal_between(surface, start, end)))
    path = [start]
    while not surface.has_edge(path[-1], end):
        if len(path) > MOST_STEPS:
            raise Blocked
        step = _next_step(surface, path[-1], end, _Cut(a, side, closed | set(path), locked))
        path.append(step if isinstance(step, int) else surface.split_edge(*step[0], step[1]))
    path.append(end)
    locked |= {sorted_edge(v, w) for v, w in itertools.pairwise(path)}
    return path


def _normal_between(surface: EditableSurface, start: int, end: int) -> Vector:
    total = (0.0, 0.0, 0.0)
    for v in (start, end):
        for face in surface.around[v]:
            total = plus(total, surface.normal(face))
    return total


def _next_step(surface: EditableSurface, here: int, end: int, cut: _Cut) -> _Step:
    """The step from `here` that leads best to the end; raises Blocked where none does."""
    p = surface.points[here]
    goal = unit(minus(surface.points[end], p))
    best, most = None, LEAST_ADVANCE
    for face in sorted(surface.around[here]):
        step = _through(surface, face, here, cut)
        if step is None:
            continue
        point = surface.points[step] if isinstance(step, int) else step[1]
        advance = dot(unit(minus(point, p)), goal)
        if advance > most:
            best, most = step, advance
    if best is None:
        raise Blocked
    return best


def _through(surface: EditableSurface, face: int, here: int, cut: _Cut) -> _Step | None:
    """Where the plane leaves the face opposite to its corner `here`: an end of that side, or a point on it."""
    corners = surface.faces[face]
    at = corners.index(here)
    x, y = corners[(at + 1) % 3], corners[(at + 2) % 3]
    sx, sy = (dot(minus(surface.points[v], cut.origin), cut.side) for v in (x, y))
    if sx * sy > 0.0 or sx == sy:
        return None
    t = sx / (sx - sy)
    if t < NEAR_END and x not in cut.closed:
        return x
    if t > 1.0 - NEAR_END and y not in cut.closed:
        return y
    if sorted_edge(x, y) in cut.locked:
        return None
    return (x, y), along(surface.points[x], surface.points[y], t)

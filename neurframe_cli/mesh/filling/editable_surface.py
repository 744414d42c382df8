"""A triangle mesh under local operations: splits of edges and faces, flips, collapses."""

from __future__ import annotations

import numpy as np

from neurframe_cli.errors import InvalidMesh
from neurframe_cli.mesh.arrays import Floats, Ints
from neurframe_cli.mesh.filling.vectors import Vector, along, cross, minus

Edge = tuple[int, int]
Face = tuple[int, int, int]


def sorted_edge(a: int, b: int) -> Edge:
    """The edge without its direction."""
    return (a, b) if a < b else (b, a)


class EditableSurface:
    """points: positions by vertex; faces: corners by face; half: face on the left of each directed edge; around: faces
    at each vertex; sharp: feature edges; parent, children: which triangle of the input a face is a part of, and back.

    Splits keep the shape exactly; sharp edges stay sharp in all operations.
    """

    def __init__(self, V: Floats, F: Ints, sharp: Ints) -> None:
        """V (n,3), F (m,3), sharp (k,2); raises InvalidMesh where two triangles have one directed edge."""
        self.points: list[Vector] = [tuple(p) for p in V.tolist()]
        self.faces: dict[int, Face] = {}
        self.half: dict[Edge, int] = {}
        self.around: dict[int, set[int]] = {}
        self.parent: dict[int, int] = {}
        self.children: dict[int, set[int]] = {}
        self.sharp = {sorted_edge(a, b) for a, b in sharp.tolist()}
        self._next = 0
        for number, corners in enumerate(F.tolist()):
            self._add(tuple(corners), number)

    def neighbors(self, v: int) -> set[int]:
        """Vertices that share an edge with v."""
        return {w for face in self.around[v] for w in self.faces[face]} - {v}

    def has_edge(self, a: int, b: int) -> bool:
        return (a, b) in self.half or (b, a) in self.half

    def opposite(self, a: int, b: int) -> int | None:
        """The third corner of the face on the left of a -> b."""
        face = self.half.get((a, b))
        return None if face is None else next(v for v in self.faces[face] if v not in (a, b))

    def opposites(self, a: int, b: int) -> set[int]:
        """The third corners of the one or two faces at the edge."""
        return {v for v in (self.opposite(a, b), self.opposite(b, a)) if v is not None}

    def is_boundary(self, a: int, b: int) -> bool:
        """Whether only one face has the edge."""
        return ((a, b) in self.half) != ((b, a) in self.half)

    def sharp_neighbors(self, v: int) -> list[int]:
        return [w for w in sorted(self.neighbors(v)) if sorted_edge(v, w) in self.sharp]

    def normal(self, face: int) -> Vector:
        """Twice the area as a vector."""
        return corner_normal(*(self.points[v] for v in self.faces[face]))

    def add_point(self, point: Vector) -> int:
        self.points.append(point)
        return len(self.points) - 1

    def split_edge(self, a: int, b: int, point: Vector) -> int:
        """A new vertex on the edge, which halves its faces."""
        v = self.add_point(point)
        for x, y in ((a, b), (b, a)):
            if (x, y) in self.half:
                z, parent = self._opposite(x, y), self._remove(self.half[x, y])
                self._add((x, v, z), parent)
                self._add((v, y, z), parent)
        if sorted_edge(a, b) in self.sharp:
            self.sharp -= {sorted_edge(a, b)}
            self.sharp |= {sorted_edge(a, v), sorted_edge(v, b)}
        return v

    def split_face(self, face: int, point: Vector) -> int:
        """A new vertex in the face, which becomes three."""
        v = self.add_point(point)
        a, b, c = self.faces[face]
        parent = self._remove(face)
        for corners in ((a, b, v), (b, c, v), (c, a, v)):
            self._add(corners, parent)
        return v

    def halve_edge(self, a: int, b: int) -> int:
        """A new vertex in the middle of the edge."""
        return self.split_edge(a, b, along(self.points[a], self.points[b], 0.5))

    def flip(self, a: int, b: int) -> None:
        """The other diagonal of the two faces at the edge, which must be no edge yet."""
        c, d = self._opposite(a, b), self._opposite(b, a)
        parent = self._remove(self.half[a, b])
        self._remove(self.half[b, a])
        self._add((a, d, c), parent)
        self._add((d, b, c), parent)

    def can_collapse(self, v: int, w: int) -> bool:
        """Whether the surface stays a manifold: the link condition (Dey et al. 1999)."""
        common = self.neighbors(v) & self.neighbors(w)
        return common == self.opposites(v, w) and len(self.neighbors(v) | self.neighbors(w)) > 4

    def collapse(self, v: int, w: int) -> None:
        """v becomes w; can_collapse(v, w) must hold."""
        for other in self.neighbors(v):
            if sorted_edge(v, other) in self.sharp:
                self.sharp -= {sorted_edge(v, other)}
                self.sharp |= {sorted_edge(w, other)} if other != w else set()
        moved = [(self.faces[face], self._remove(face)) for face in sorted(self.around[v])]
        for corners, parent in moved:
            if w not in corners:
                a, b, c = (w if corner == v else corner for corner in corners)
                self._add((a, b, c), parent)

    def arrays(self) -> tuple[Floats, Ints, Ints]:
        """V (n,3) of all vertices ever made, F (m,3), sharp edges (k,2)."""
        V = np.array(self.points, np.float64).reshape(-1, 3)
        F = np.array(list(self.faces.values()), np.int64).reshape(-1, 3)
        return V, F, np.array(sorted(self.sharp), np.int64).reshape(-1, 2)

    def _opposite(self, a: int, b: int) -> int:
        v = self.opposite(a, b)
        assert v is not None, "there is no face at this edge"
        return v

    def _add(self, corners: Face, parent: int) -> None:
        a, b, c = corners
        for edge in ((a, b), (b, c), (c, a)):
            if edge in self.half:
                raise InvalidMesh(f"the surface is not manifold: two triangles with the edge {edge}")
            self.half[edge] = self._next
        for v in corners:
            self.around.setdefault(v, set()).add(self._next)
        self.faces[self._next], self.parent[self._next] = corners, parent
        self.children.setdefault(parent, set()).add(self._next)
        self._next += 1

    def _remove(self, face: int) -> int:
        """Removes a face; returns its parent."""
        a, b, c = self.faces.pop(face)
        for edge in ((a, b), (b, c), (c, a)):
            del self.half[edge]
        for v in (a, b, c):
            self.around[v].discard(face)
        parent = self.parent.pop(face)
        self.children[parent].discard(face)
        return parent


def corner_normal(a: Vector, b: Vector, c: Vector) -> Vector:
    """Twice the area of a triangle as a vector."""
    return cross(minus(b, a), minus(c, a))

"""Distance between a quad mesh and the surface that it was made from, with the faces that are to blame for it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from neurframe_cli.mesh.arrays import Bools, Floats, Ints, Surface
from neurframe_cli.mesh.measure import surface_area
from neurframe_cli.mesh.optimize.simplex_tree import SimplexTree
from neurframe_cli.mesh.quality.distance import sample_surface
from neurframe_cli.mesh.quality.polygons import triangulated
from neurframe_cli.mesh.surface_edges import surface_edges

SHARP_DEG = 30.0  # an edge that bends by more gets samples of its own


@dataclass(frozen=True)
class Distances:
    """Of a mesh with its vertices at x (n,3): `there` (f,) the largest distance of the samples of each face to the
    surface; `back` (k,) those of the surface's samples to the mesh, and `nearest` (k,) the face closest to each."""

    x: Floats
    there: Floats
    back: Floats
    nearest: Ints

    @cached_property
    def by_face(self) -> Floats:
        """Largest distance (f,) of the samples of each face, and of the surface's samples closest to it."""
        result = self.there.copy()
        np.maximum.at(result, self.nearest, self.back)
        return result


class DistanceProbe:
    """The same samples each time: `points`, which are `samples` random points, the vertices of the surface and places
    along its sharp edges, where a mesh that does not follow them is farthest away, against the triangulated faces
    (f,4); their corners, edge midpoints and centroids against the surface."""

    def __init__(self, faces: Ints, surface: Surface, samples: int, rng: np.random.Generator) -> None:
        self.faces, self.triangles = faces, triangulated(faces)
        spread = sample_surface(surface, samples, rng)
        self.points = np.concatenate(
            [surface.V[np.unique(surface.F)], _on_sharp_edges(surface, samples), spread]
        )
        self.tree = SimplexTree(surface.V, surface.F)

    def measure(self, x: Floats, known: Distances | None = None) -> Distances:
        """Distances with the vertices at x (n,3); what has not changed since `known` is not measured again."""
        if known is None:
            everything = np.ones(len(self.faces), bool)
            return Distances(x, self._there(x, everything), *self._back(x, self.points, everything))
        changed = (x != known.x).any(axis=1)[self.faces].any(axis=1)
        if not changed.any():
            return known
        there = known.there.copy()
        there[changed] = self._there(x, changed)
        return Distances(x, there, *self._back_again(x, changed, known))

    def _back_again(self, x: Floats, changed: Bools, known: Distances) -> tuple[Floats, Ints]:
        """Distances and faces of the surface's samples: their closest face is a changed one or that in `known`, unless
        that one has changed."""
        back, nearest = self._back(x, self.points, changed)
        kept = ~changed[known.nearest] & (known.back <= back)
        back[kept], nearest[kept] = known.back[kept], known.nearest[kept]
        lost = changed[known.nearest]
        if lost.any():
            back[lost], nearest[lost] = self._back(x, self.points[lost], np.ones(len(self.faces), bool))
        return back, nearest

    def _there(self, x: Floats, chosen: Bools) -> Floats:
        """Largest distance of the samples of each of the `chosen` faces (f,)."""
        T = self.triangles[np.tile(chosen, 2)]
        vertices, at_vertices = np.unique(T[:, :2], return_inverse=True)
        sides = np.sort(np.stack([T[:, :2], T[:, 1:]], axis=1), axis=2)
        _, first, at_sides = np.unique(
            sides[..., 0] * len(x) + sides[..., 1], return_index=True, return_inverse=True
        )
        middles = x[sides.reshape(-1, 2)[first]].mean(axis=1)
        distances = self.tree.distances(np.concatenate([x[vertices], middles, x[T].mean(axis=1)]))
        by_vertex, by_side, by_triangle = np.split(distances, [len(vertices), len(vertices) + len(middles)])
        of_triangles = np.concatenate(
            [by_vertex[at_vertices.reshape(-1, 2)], by_side[at_sides.reshape(-1, 2)], by_triangle[:, None]],
            axis=1,
        ).max(axis=1)
        return np.asarray(of_triangles.reshape(2, -1).max(axis=0))

    def _back(self, x: Floats, points: Floats, chosen: Bools) -> tuple[Floats, Ints]:
        """Distance (k,) of points (k,3) to the `chosen` faces (f,), and the closest of these (k,)."""
        members = np.flatnonzero(chosen)
        tree = SimplexTree(x, self.triangles[np.tile(chosen, 2)])
        distance, triangle = tree.nearest(points)
        return distance, members[triangle % len(members)]


def _on_sharp_edges(surface: Surface, samples: int) -> Floats:
    """Points (k,3) along edges that bend by SHARP_DEG, a quarter as far from each other as `samples` on the surface."""
    found = surface_edges(surface.V, surface.F)
    edges = found.edges[found.angles_deg > SHARP_DEG]
    a, b = surface.V[edges[:, 0]], surface.V[edges[:, 1]]
    spacing = 0.25 * np.sqrt(surface_area(surface.V, surface.F) / samples)
    count = np.ceil(np.linalg.norm(b - a, axis=1) / spacing).astype(np.int64)
    edge = np.repeat(np.arange(len(edges)), count)
    along = (np.arange(len(edge)) - np.repeat(np.cumsum(count) - count, count) + 0.5) / count[edge]
    return np.asarray(a[edge] + along[:, None] * (b - a)[edge])


class BothDiagonals(DistanceProbe):
    """The same for quads that may be bent: whichever of their two triangulations is farther away."""

    def __init__(self, faces: Ints, surface: Surface, samples: int, rng: np.random.Generator) -> None:
        super().__init__(faces, surface, samples, rng)
        self.other = DistanceProbe(np.roll(faces, 1, axis=1), surface, samples, rng)

    def measure(self, x: Floats, known: Distances | None = None) -> Distances:
        """Distances with the vertices at x (n,3), all measured again."""
        one, other = super().measure(x), self.other.measure(x)
        back = np.concatenate([one.back, other.back])
        nearest = np.concatenate([one.nearest, other.nearest])
        return Distances(x, np.maximum(one.there, other.there), back, nearest)

"""Distance between a quad mesh and the surface that it was made from, with the faces that are to blame for it."""

from __future__ import annotations

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints, Surface
from neurframe_cli.mesh.optimize.simplex_tree import SimplexTree
from neurframe_cli.mesh.quality.distance import sample_surface
from neurframe_cli.mesh.quality.polygons import triangulated


class DistanceProbe:
    """The same samples each time: `samples` random points and the vertices of the surface against the triangulated
    faces (f,4); their corners, edge midpoints and centroids against the surface."""

    def __init__(self, faces: Ints, surface: Surface, samples: int, rng: np.random.Generator) -> None:
        self.faces, self.triangles = faces, triangulated(faces)
        self._tree = SimplexTree(surface.V, surface.F)
        self._points = np.concatenate(
            [surface.V[np.unique(surface.F)], sample_surface(surface, samples, rng)]
        )

    def worst_by_face(self, x: Floats) -> Floats:
        """Largest distance (f,) of the samples of each face, and of the surface's samples closest to it."""
        count = len(self.faces)
        P = x[self.triangles]
        there = np.stack([P[:, 0], P[:, 1], (P[:, 0] + P[:, 1]) / 2, (P[:, 1] + P[:, 2]) / 2, P.mean(axis=1)])
        distances = self._tree.distances(there.reshape(-1, 3)).reshape(-1, 2, count).max(axis=(0, 1))
        back, face, _ = self.surface_samples(x)
        np.maximum.at(distances, face, back)
        return np.asarray(distances)

    def surface_samples(self, x: Floats) -> tuple[Floats, Ints, Floats]:
        """Of the surface's samples: distance (k,) to the faces, the closest face (k,), position (k,3)."""
        foot = SimplexTree(x, self.triangles).closest(self._points)
        distance = np.linalg.norm(foot.points - self._points, axis=1)
        return np.asarray(distance), foot.simplices % len(self.faces), self._points

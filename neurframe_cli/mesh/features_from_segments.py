"""Feature curves that someone drew, as edges of a triangle mesh that runs nearby."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from neurframe_cli.mesh.arrays import Features, Floats, Ints
from neurframe_cli.mesh.features import features_from_edges
from neurframe_cli.mesh.measure import box_diagonal
from neurframe_cli.mesh.surface_distance import distances
from neurframe_cli.mesh.surface_edges import directed_edges
from neurframe_cli.mesh.weld import weld

# an edge this part of the mean edge length off the curve counts as twice as long
TOLERATED = 0.1


def features_from_segments(V: Floats, F: Ints, segments: Floats) -> tuple[Features, list[str]]:
    """Features on the mesh V (n,3), F (m,3) along the curves that `segments` (k,2,3) form, and warnings.

    Segments are joined where their ends are equal.  Each curve between two corners becomes the path over edges of
    the mesh that is short and stays near it; corners go to the nearest vertex.
    """
    points, joined = weld(segments.reshape(-1, 3), np.arange(2 * len(segments)).reshape(-1, 2), 0.0)
    curves = features_from_edges(points, joined)
    graph = _EdgeGraph(V, np.unique(np.sort(directed_edges(F), axis=1), axis=0))
    paths = [graph.path_along(points[chain]) for chain in curves.chains]
    edges = np.concatenate([np.stack([p[:-1], p[1:]], axis=1) for p in paths] or [np.zeros((0, 2), np.int64)])
    features = features_from_edges(V, edges, graph.nearest(points[curves.corners]))
    return features, _warnings(V, features, points, curves.edges)


def _warnings(V: Floats, features: Features, points: Floats, edges: Ints) -> list[str]:
    if len(features.edges) == 0:
        return []
    away = distances(V[np.unique(features.edges)], points, edges).max()
    diagonal = box_diagonal(V)
    if away < 5e-3 * diagonal:
        return []
    return [
        f"given features: the edges of the mesh run up to {away / diagonal:.2%} of the diagonal beside them"
    ]


@dataclass(frozen=True)
class _EdgeGraph:
    """The edges (e,2) of a mesh with vertices V (n,3), for shortest paths."""

    V: Floats
    edges: Ints

    def nearest(self, points: Floats) -> Ints:
        """(p,) vertex of the mesh nearest to each point."""
        from scipy.spatial import cKDTree

        used = np.unique(self.edges)
        return np.asarray(used[cKDTree(self.V[used]).query(points)[1]], np.int64)

    def path_along(self, curve: Floats) -> Ints:
        """Vertices of the path along a polyline (k,3); a closed polyline is walked in three parts."""
        stops = [0, len(curve) - 1]
        if (curve[0] == curve[-1]).all():
            stops = [0, len(curve) // 3, 2 * len(curve) // 3, len(curve) - 1]
        weighted = self._weighted(curve)
        ends = self.nearest(curve[stops])
        parts = [_shortest_path(weighted, int(a), int(b)) for a, b in pairwise(ends)]
        return np.concatenate([parts[0][:1], *(part[1:] for part in parts)])

    def _weighted(self, curve: Floats) -> Any:
        from scipy.sparse import csr_matrix

        lengths = np.linalg.norm(self.V[self.edges[:, 0]] - self.V[self.edges[:, 1]], axis=1)
        line = np.stack([np.arange(len(curve) - 1), np.arange(1, len(curve))], axis=1)
        middle = self.V[self.edges].mean(axis=1)
        away = np.max([distances(p, curve, line) for p in (middle, *self.V[self.edges.T])], axis=0)
        weight = lengths * (1 + (away / (TOLERATED * lengths.mean())) ** 2)
        a, b = self.edges.T
        return csr_matrix(
            (np.tile(weight, 2), (np.concatenate([a, b]), np.concatenate([b, a]))), shape=(len(self.V),) * 2
        )


def _shortest_path(graph: Any, start: int, end: int) -> Ints:
    """Vertices from start to end; just the start where end cannot be reached."""
    from scipy.sparse.csgraph import dijkstra

    before = dijkstra(graph, directed=False, indices=start, return_predecessors=True)[1]
    path = [end]
    while before[path[-1]] >= 0:
        path.append(int(before[path[-1]]))
    return np.array(path[::-1] if path[-1] == start else [start], np.int64)

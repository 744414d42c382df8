"""Paths of mesh edges along one curve of the input's features."""

from __future__ import annotations

import itertools

import numpy as np

from neurframe_cli.mesh.arrays import Bools, Floats, Ints
from neurframe_cli.mesh.optimize.simplex_tree import SMALLEST, SimplexTree
from neurframe_cli.mesh.quality.polygons import unique_edges

LENGTH_COST = 1e-3  # of an edge that lies on the curve: the shorter of two good paths is taken
FARTHEST = 1.5  # edge lengths between a curve and the vertices of its path
FASTEST_PROGRESS = 3.0  # arc length gained in an edge length; more is a jump across a hairpin
FARTHEST_END = 2.0  # edge lengths between the end of a curve and that of a path that cannot begin there
WAYPOINTS = 3  # in a closed curve without a corner
LEAST_PART = 2.0  # edge lengths that a path along a part of a curve covers


class MeshGraph:
    """Mesh edges with what the paths need to know about them."""

    def __init__(self, X: Floats, faces: Ints) -> None:
        from scipy.sparse import coo_matrix
        from scipy.spatial import cKDTree

        edges, use = unique_edges(faces)
        self.X, self.edges = X, edges
        # an edge without length, where an extraction joined two places, is merely dear
        self.lengths = np.maximum(np.linalg.norm(X[edges[:, 1]] - X[edges[:, 0]], axis=1), SMALLEST)
        ends, twice = edges.ravel(), np.repeat(self.lengths, 2)
        count = np.maximum(np.bincount(ends, minlength=len(X)), 1)
        self.reach = np.bincount(ends, twice, minlength=len(X)) / count  # mean edge length at each vertex
        self.vertices = np.unique(edges)
        self.tree = cKDTree(X[self.vertices])
        index = np.concatenate([np.arange(len(edges))] * 2) + 1
        both = np.concatenate([edges, edges[:, ::-1]])
        self.edge_at = coo_matrix((index, (both[:, 0], both[:, 1])), shape=(len(X), len(X))).tocsr()
        self.free = np.ones(len(X), bool)  # no path that is settled runs there
        self.dear = np.zeros(len(X))  # edge lengths off the curve that a path accepts to go round a vertex
        self.open_edge: Bools = use == 1
        self.rim = np.zeros(len(X), bool)  # on the boundary of the mesh
        self.rim[edges[self.open_edge]] = True


class Stretch:
    """The part of the mesh that is near one curve, with distance and arc length at its vertices."""

    def __init__(self, points: Floats, graph: MeshGraph, on_rim: bool) -> None:
        n = len(points)
        self.points, self.graph, self.on_rim = points, graph, on_rim
        self.closed = bool((points[0] == points[-1]).all())
        self.knots = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
        self.tree = SimplexTree(points, np.stack([np.arange(n - 1), np.arange(1, n)], axis=1))
        self.vertices, self.distance, self.arc = self._near_vertices()
        self.place = {int(v): i for i, v in enumerate(self.vertices)}

    def _near_vertices(self) -> tuple[Ints, Floats, Floats]:
        reach = FARTHEST * float(self.graph.reach.max())
        middles, radii = (self.points[1:] + self.points[:-1]) / 2, np.diff(self.knots) / 2 + reach
        found = self.graph.tree.query_ball_point(middles, radii)
        vertices = self.graph.vertices[np.unique(np.concatenate([np.asarray(f, np.int64) for f in found]))]
        distance, arc = self._locate(self.graph.X[vertices])
        near = (distance < FARTHEST * self.graph.reach[vertices]) & (
            self.graph.rim[vertices] | (not self.on_rim)
        )
        return vertices[near], distance[near], arc[near]

    def _locate(self, P: Floats) -> tuple[Floats, Floats]:
        """Distance and arc length of the closest points on the curve."""
        if len(P) == 0:
            return np.zeros(0), np.zeros(0)
        foot = self.tree.closest(P)
        arc = self.knots[foot.simplices] + foot.weights[:, 1] * np.diff(self.knots)[foot.simplices]
        return np.linalg.norm(foot.points - P, axis=1), arc

    def waypoints(self) -> list[int]:
        """A free vertex near each third of the curve, the one closest to the curve; fewer where there is none."""
        chosen: list[int] = []
        for k in range(WAYPOINTS):
            offset = self._gain(np.full(len(self.arc), self.knots[-1] * k / WAYPOINTS), self.arc)
            near = (np.abs(offset) < self.graph.reach[self.vertices]) & self.graph.free[self.vertices]
            if near.any():
                dear = self.graph.dear[self.vertices] * self.graph.reach[self.vertices]
                rank = np.where(near, self.distance + 0.1 * np.abs(offset) + dear, np.inf)
                chosen.append(int(self.vertices[int(rank.argmin())]))
        return chosen if len(set(chosen)) == WAYPOINTS else []

    def near_ends(self) -> list[int]:
        """The free vertices closest to the ends of an open curve, less than FARTHEST_END edge lengths along it."""
        found: list[int] = []
        for along in (self.arc, self.knots[-1] - self.arc):
            reach = self.graph.reach[self.vertices]
            near = (along < FARTHEST_END * reach) & self.graph.free[self.vertices] & (not self.closed)
            if near.any():
                rank = np.where(near, self.distance + along, np.inf)
                found.append(int(self.vertices[int(rank.argmin())]))
        return found if len(set(found)) == 2 else []

    def stray(self, path: Ints | None) -> float:
        """Mean distance of a path's edges from the curve in mean edge lengths there; inf without a path."""
        if path is None:
            return np.inf
        X, reach = self.graph.X[path], self.graph.reach[path]
        places = np.concatenate([X, (X[1:] + X[:-1]) / 2])
        return float(self._locate(places)[0].mean() / reach.mean())

    def path_through(self, stops: list[int]) -> Ints | None:
        """Cheapest path that visits the stops in order, or None."""
        if not stops or any(v not in self.place for v in stops):
            return None
        pieces = [np.array(stops[:1], np.int64)]
        for start, end in itertools.pairwise(stops):
            blocked = np.concatenate([p[:-1] for p in pieces] + [np.array(stops, np.int64)])
            piece = self._shortest(start, end, blocked)
            if piece is None:
                return None
            pieces.append(piece[1:])
        return np.concatenate(pieces)

    def _shortest(self, start: int, end: int, blocked: Ints) -> Ints | None:
        usable = self.graph.free[self.vertices] & ~np.isin(self.vertices, blocked)
        usable &= self._between(start, end)
        usable[[self.place[start], self.place[end]]] = True
        local = np.flatnonzero(usable)
        first, last = (int(np.searchsorted(local, self.place[v])) for v in (start, end))
        distance, before = self._distances(local, first)
        return self._walked(local, before, first, last) if np.isfinite(distance[last]) else None

    def part_from(self, start: int, beyond: float) -> Ints | None:
        """The cheapest path from a vertex at an end of an open curve to where free vertices lead farthest along it,
        beyond that arc length; None if that is not worth it."""
        if self.closed or start not in self.place:
            return None
        usable = self.graph.free[self.vertices] & (self.arc >= beyond)
        usable[self.place[start]] = True
        local = np.flatnonzero(usable)
        first = int(np.searchsorted(local, self.place[start]))
        distance, before = self._distances(local, first)
        gain = np.abs(self.arc[local] - self.arc[self.place[start]])
        reached = np.isfinite(distance) & (gain >= LEAST_PART * self.graph.reach[self.vertices[local]])
        if not reached.any():
            return None
        last = int(np.where(reached, gain - self.distance[local], -np.inf).argmax())
        return self._walked(local, before, first, last)

    def arc_at(self, vertex: int) -> float:
        """Arc length of the place on the curve that is closest to a vertex near it."""
        return float(self.arc[self.place[vertex]])

    def _distances(self, local: Ints, first: int) -> tuple[Floats, Ints]:
        """Costs and predecessors of the cheapest paths from one of the vertices at `local` to all of them."""
        from scipy.sparse import coo_matrix
        from scipy.sparse.csgraph import dijkstra

        a, b, cost = self._edge_costs(local)
        weights = coo_matrix((cost, (a, b)), shape=(len(local), len(local))).tocsr()
        distance, before = dijkstra(weights, directed=False, indices=first, return_predecessors=True)
        return np.asarray(distance), np.asarray(before)

    def _walked(self, local: Ints, before: Ints, first: int, last: int) -> Ints:
        path = [last]
        while path[-1] != first:
            path.append(int(before[path[-1]]))
        return np.asarray(self.vertices[local[path[::-1]]])

    def _between(self, start: int, end: int) -> Bools:
        """Vertices whose arc length lies between two stops of a closed curve (all of them on an open one)."""
        if not self.closed:
            return np.ones(len(self.vertices), bool)
        length, margin = self.knots[-1], 0.5 * self.graph.reach[self.vertices]
        first, last = self.arc[self.place[start]], self.arc[self.place[end]]
        span = (last - first) % length or length
        ahead = (self.arc - first + margin) % length
        return np.asarray(ahead <= span + 2 * margin)

    def _gain(self, first: Floats, second: Floats) -> Floats:
        """Arc length from one place to another, the short way round on closed curves."""
        gain = second - first
        length = self.knots[-1]
        return gain - length * np.round(gain / length) if self.closed else gain

    def _edge_costs(self, local: Ints) -> tuple[Ints, Ints, Floats]:
        """Ends and costs of the mesh edges between the vertices at `local`: off the curve or across it is dear."""
        vertices = self.vertices[local]
        inside = self.graph.edge_at[vertices][:, vertices].tocoo()
        once = inside.row < inside.col
        a, b, edge = inside.row[once], inside.col[once], inside.data[once] - 1
        length = self.graph.lengths[edge]
        ends = self.vertices[local[a]], self.vertices[local[b]]
        middle, _ = self._locate((self.graph.X[ends[0]] + self.graph.X[ends[1]]) / 2)
        off = (self.distance[local[a]] + 2 * middle + self.distance[local[b]]) / (4 * length)
        progress = np.abs(self._gain(self.arc[local[a]], self.arc[local[b]])) / length
        dear = (self.graph.dear[ends[0]] + self.graph.dear[ends[1]]) / 2
        cost = length * (LENGTH_COST + off + dear + np.maximum(0.0, 1.0 - progress))
        walkable = (progress < FASTEST_PROGRESS) & (self.graph.open_edge[edge] | (not self.on_rim))
        return a[walkable], b[walkable], cost[walkable]

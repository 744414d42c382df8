"""Which mesh vertices and edges stand for which feature corners and curves of the input.

An integer-grid map puts feature edges on isolines, so paths of mesh edges run along them.  Each curve is matched as a
whole, by the cheapest path of mesh edges between the vertices of its end corners: nearest-vertex tests would leave gaps
and branches wherever two curves are closer to each other than an edge is long.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from neurframe_cli.mesh.arrays import Bools, Floats, Ints
from neurframe_cli.mesh.optimize.feature_curves import FeatureCurves
from neurframe_cli.mesh.optimize.simplex_tree import SMALLEST, SimplexTree
from neurframe_cli.mesh.quality.polygons import unique_edges

LENGTH_COST = 1e-3  # of an edge that lies on the curve: the shorter of two good paths is taken
FASTEST_PROGRESS = 3.0  # arc length gained in an edge length; more is a jump across a hairpin
FARTHEST_END = 2.0  # edge lengths between the end of a curve and that of a path that cannot begin there
WAYPOINTS = 3  # in a closed curve without a corner


@dataclass(frozen=True)
class MatchedCurve:
    """curve: index in FeatureCurves.curves; path (k,) mesh vertices along it, closed curves repeat the first; whether
    the path covers all of the curve, or ends near its ends because no edge was left there."""

    curve: int
    path: Ints
    whole: bool = True


@dataclass(frozen=True)
class MatchedFeatures:
    """corners (k,2): index in FeatureCurves.corners, mesh vertex; curves: those for which a path exists."""

    corners: Ints
    curves: tuple[MatchedCurve, ...]


class _Graph:
    """Mesh edges with what the paths need to know about them."""

    def __init__(self, X: Floats, edges: Ints, use: Ints) -> None:
        from scipy.sparse import coo_matrix
        from scipy.spatial import cKDTree

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
        self.free = np.ones(len(X), bool)  # not yet on a path
        self.open_edge: Bools = use == 1
        self.rim = np.zeros(len(X), bool)  # on the boundary of the mesh
        self.rim[edges[self.open_edge]] = True


def match_features(V: Floats, features: FeatureCurves, X: Floats, faces: Ints) -> MatchedFeatures:
    """Match corners one to one with vertices nearer than an edge length, then curves with disjoint edge paths.

    V (n,3) positions that `features` index; X (k,3), faces (f,4) the mesh, or the boundary of a hex mesh.  A curve on
    the boundary of the surface takes boundary edges of the mesh only.
    """
    graph = _Graph(X, *unique_edges(faces))
    on_rim = features.corners_on_boundary
    corners = _match_corners(V[features.corners], on_rim, graph)
    vertex_of = {int(features.corners[c]): int(v) for c, v in corners}
    graph.free[corners[:, 1]] = False
    stretches = [
        _Stretch(V[curve], graph, bool(on_rim))
        for curve, on_rim in zip(features.curves, features.on_boundary, strict=True)
    ]
    stops = [_stops(s, c, vertex_of) for s, c in zip(stretches, features.curves, strict=True)]
    matched = []
    left = []
    for i in _best_fit_first(stretches, stops):
        path = stretches[i].path_through(stops[i])
        if path is None:
            left.append(i)
        else:
            graph.free[path] = False
            matched.append(MatchedCurve(i, path))
    for i in left:
        path = stretches[i].path_through(stretches[i].near_ends())
        if path is not None:
            graph.free[path] = False
            matched.append(MatchedCurve(i, path, whole=False))
    return MatchedFeatures(corners, tuple(matched))


def _best_fit_first(stretches: list[_Stretch], stops: list[list[int]]) -> list[int]:
    """Curves in the order of how far their paths would stray if each were alone: a vertex with fewer edges than curves
    gives them to those that run along them.  Where two are as good, the shorter one is first."""
    strays = [s.stray(s.path_through(at)) for s, at in zip(stretches, stops, strict=True)]
    return sorted(range(len(strays)), key=lambda i: (round(strays[i], 3), stretches[i].knots[-1]))


def _match_corners(points: Floats, on_rim: Bools, graph: _Graph) -> Ints:
    """Greedy by distance: every corner one vertex, every vertex one corner; corners on the rim take rim vertices."""
    candidates = min(8, len(graph.vertices))
    distance, nearest = graph.tree.query(points, k=np.arange(1, candidates + 1))
    vertices = graph.vertices[nearest]
    near = (distance < graph.reach[vertices]) & (graph.rim[vertices] | ~on_rim[:, None])
    pairs = np.argwhere(near)[np.argsort(distance[near], kind="stable")]
    corner_vertex: dict[int, int] = {}
    taken: set[int] = set()
    for corner, rank in pairs.tolist():
        vertex = int(vertices[corner, rank])
        if corner not in corner_vertex and vertex not in taken:
            corner_vertex[corner] = vertex
            taken.add(vertex)
    return np.array(sorted(corner_vertex.items()), np.int64).reshape(-1, 2)


def _stops(stretch: _Stretch, curve: Ints, vertex_of: dict[int, int]) -> list[int]:
    """Vertices that the path of a curve must visit in order; none if an end has no vertex."""
    first, last = (vertex_of.get(int(curve[i])) for i in (0, -1))
    if not stretch.closed:
        return [] if first is None or last is None else [first, last]
    between = stretch.waypoints()
    if first is not None and between:
        between[0] = first  # a loop from a corner to itself
    return [*between, *between[:1]]


class _Stretch:
    """The part of the mesh that is near one curve, with distance and arc length at its vertices."""

    def __init__(self, points: Floats, graph: _Graph, on_rim: bool) -> None:
        n = len(points)
        self.points, self.graph, self.on_rim = points, graph, on_rim
        self.closed = bool((points[0] == points[-1]).all())
        self.knots = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
        self.tree = SimplexTree(points, np.stack([np.arange(n - 1), np.arange(1, n)], axis=1))
        self.vertices, self.distance, self.arc = self._near_vertices()
        self.place = {int(v): i for i, v in enumerate(self.vertices)}

    def _near_vertices(self) -> tuple[Ints, Floats, Floats]:
        reach = float(self.graph.reach.max())
        middles, radii = (self.points[1:] + self.points[:-1]) / 2, np.diff(self.knots) / 2 + reach
        found = self.graph.tree.query_ball_point(middles, radii)
        vertices = self.graph.vertices[np.unique(np.concatenate([np.asarray(f, np.int64) for f in found]))]
        distance, arc = self._locate(self.graph.X[vertices])
        near = (distance < self.graph.reach[vertices]) & (self.graph.rim[vertices] | (not self.on_rim))
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
                rank = np.where(near, self.distance + 0.1 * np.abs(offset), np.inf)
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
        from scipy.sparse import coo_matrix
        from scipy.sparse.csgraph import dijkstra

        usable = self.graph.free[self.vertices] & ~np.isin(self.vertices, blocked)
        usable &= self._between(start, end)
        usable[[self.place[start], self.place[end]]] = True
        local = np.flatnonzero(usable)
        a, b, cost = self._edge_costs(local)
        weights = coo_matrix((cost, (a, b)), shape=(len(local), len(local))).tocsr()
        first, last = (int(np.searchsorted(local, self.place[v])) for v in (start, end))
        distance, before = dijkstra(weights, directed=False, indices=first, return_predecessors=True)
        if not np.isfinite(distance[last]):
            return None
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
        cost = length * (LENGTH_COST + off + np.maximum(0.0, 1.0 - progress))
        walkable = (progress < FASTEST_PROGRESS) & (self.graph.open_edge[edge] | (not self.on_rim))
        return a[walkable], b[walkable], cost[walkable]

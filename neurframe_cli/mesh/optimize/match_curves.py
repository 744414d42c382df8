"""Which mesh vertices and edges stand for which feature corners and curves of the input.

An integer-grid map puts feature edges on isolines, so paths of mesh edges run along them.  Each curve is matched as a
whole, by the cheapest path of mesh edges between the vertices of its end corners: nearest-vertex tests would leave gaps
and branches wherever two curves are closer to each other than an edge is long.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from neurframe_cli.mesh.arrays import Bools, Floats, Ints
from neurframe_cli.mesh.optimize.curve_paths import MeshGraph, Stretch
from neurframe_cli.mesh.optimize.disjoint_paths import disjoint_paths
from neurframe_cli.mesh.optimize.feature_curves import FeatureCurves


@dataclass(frozen=True)
class MatchedCurve:
    """curve: index in FeatureCurves.curves; path (k,) mesh vertices along it, closed curves repeat the first; whether
    the path covers all of the curve, or a part of it because no edge was left elsewhere."""

    curve: int
    path: Ints
    whole: bool = True


@dataclass(frozen=True)
class MatchedFeatures:
    """corners (k,2): index in FeatureCurves.corners, mesh vertex; curves: those for which a path exists."""

    corners: Ints
    curves: tuple[MatchedCurve, ...]


def match_features(V: Floats, features: FeatureCurves, X: Floats, faces: Ints) -> MatchedFeatures:
    """Match corners one to one with vertices nearer than an edge length, then curves with disjoint edge paths.

    V (n,3) positions that `features` index; X (k,3), faces (f,4) the mesh, or the boundary of a hex mesh.  A curve on
    the boundary of the surface takes boundary edges of the mesh only.
    """
    graph = MeshGraph(X, faces)
    on_rim = features.corners_on_boundary
    corners = _match_corners(V[features.corners], on_rim, graph)
    vertex_of = {int(features.corners[c]): int(v) for c, v in corners}
    graph.free[corners[:, 1]] = False
    stretches = [
        Stretch(V[curve], graph, bool(on_rim))
        for curve, on_rim in zip(features.curves, features.on_boundary, strict=True)
    ]

    def stops(i: int) -> list[int]:
        return _stops(stretches[i], features.curves[i], vertex_of)

    matched, left = [], []
    for i, path in enumerate(disjoint_paths(graph, stretches, stops)):
        if path is None:
            left.append(i)
        else:
            matched.append(MatchedCurve(i, path))
    for i in left:
        matched += [MatchedCurve(i, path, whole=False) for path in _parts(graph, stretches[i], stops(i))]
    return MatchedFeatures(corners, tuple(matched))


def _parts(graph: MeshGraph, stretch: Stretch, stops: list[int]) -> list[Ints]:
    """Paths along parts of a curve that no path covers whole, which then are not free: from its ends as far as they
    lead, or between two vertices near them."""
    found: list[Ints] = []
    if stops and not stretch.closed:
        first = stretch.part_from(stops[0], beyond=0.0)
        found += _taken(graph, first)
        last = stretch.part_from(stops[-1], beyond=0.0 if first is None else stretch.arc_at(int(first[-1])))
        found += _taken(graph, None if last is None else last[::-1])
    return found or _taken(graph, stretch.path_through(stretch.near_ends()))


def _taken(graph: MeshGraph, path: Ints | None) -> list[Ints]:
    if path is None:
        return []
    graph.free[path] = False
    return [path]


def _match_corners(points: Floats, on_rim: Bools, graph: MeshGraph) -> Ints:
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


def _stops(stretch: Stretch, curve: Ints, vertex_of: dict[int, int]) -> list[int]:
    """Vertices that the path of a curve must visit in order; none if an end has no vertex."""
    first, last = (vertex_of.get(int(curve[i])) for i in (0, -1))
    if not stretch.closed:
        return [] if first is None or last is None else [first, last]
    between = stretch.waypoints()
    if first is not None and between:
        between[0] = first  # a loop from a corner to itself
    return [*between, *between[:1]]

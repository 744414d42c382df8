"""The constraints of a mesh, found from the input surface and its features."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from neurframe_cli.mesh.arrays import Bools, Features, Floats, Ints, Surface
from neurframe_cli.mesh.optimize.constraints import FREE, ON_CURVE, ON_SURFACE, PINNED, Constraints, Track
from neurframe_cli.mesh.optimize.feature_curves import FeatureCurves, feature_curves
from neurframe_cli.mesh.optimize.match_curves import MatchedFeatures, match_features
from neurframe_cli.mesh.optimize.patches import Patches, pair_patches
from neurframe_cli.mesh.optimize.simplex_tree import SMALLEST, SimplexTree
from neurframe_cli.mesh.quality.polygons import unique_edges

FARTHEST = 0.75  # edge lengths between a boundary vertex and the surface; what is farther belongs to a void
FLAT = 0.15  # sine of the angle of a quad; less is as good as flat
SMALLEST_GAP = 0.1  # share of the mean gap that neighbours on a curve are left


@dataclass(frozen=True)
class Classification:
    """Counts: corners and curves of the input and those found in the mesh; vertices by kind; `off_surface`: boundary
    vertices left where they are because the surface is farther away than half an edge."""

    corners: int
    matched_corners: int
    curves: int
    matched_curves: int
    on_curves: int
    on_surface: int
    free: int
    off_surface: int


@dataclass(frozen=True)
class Classified:
    """constraints; patches of the surface under the mesh; start (n,3): X with the vertices of each curve in order."""

    constraints: Constraints
    patches: Patches
    start: Floats
    found: Classification


def classify(
    X: Floats, faces: Ints, surface: Surface, features: Features, solid: bool, voids: bool = False
) -> Classified:
    """Constraints of vertices X (n,3); faces (f,4) are the quads, or the boundary quads of a hex mesh.

    Vertices of matched corners are pinned to them unless these are loose ends of a curve, those on matched curves
    slide on these, other vertices of `faces` slide on the part of the surface that the matched curves cut out and
    their part of the mesh lies on; the rest is free.  solid: of a hex mesh, whose corners are let go where their pins
    alone make a quad flat; voids: it may have voids, and the boundary of these stays.
    """
    curves = feature_curves(surface, features)
    matched = match_features(surface.V, curves, X, faces)
    patches = pair_patches(X, faces, surface, curves, matched)
    kind, pins, start = np.full(len(X), FREE, np.int64), X.copy(), X.copy()
    kind[patches.of_vertex >= 0] = ON_SURFACE
    edges, use = unique_edges(faces)
    kind[edges[use == 1]] = PINNED  # unless a boundary curve of the surface is found there
    off = (patches.distance > FARTHEST) & voids
    kind[off] = PINNED
    tracks = []
    for found in matched.curves:
        points = surface.V[curves.curves[found.curve]]
        start[found.path] = _in_order(points, X[found.path], found.whole)
        kind[found.path] = ON_CURVE
        tracks.append(Track(curve_tree(points), found.path))
    held = ~_loose_ends(curves)[matched.corners[:, 0]]
    kind[matched.corners[held, 1]] = PINNED
    pins[matched.corners[:, 1]] = surface.V[curves.corners[matched.corners[:, 0]]]
    if solid:
        kind[_flat_corners(X, pins, kind, faces)] = ON_SURFACE
    tracks = [Track(t.tree, np.unique(t.vertices[kind[t.vertices] == ON_CURVE])) for t in tracks]
    for t, tree in enumerate(patches.trees):
        tracks.append(Track(tree, np.flatnonzero((patches.of_vertex == t) & (kind == ON_SURFACE))))
    constraints = Constraints(kind, pins, [t for t in tracks if len(t.vertices)])
    return Classified(constraints, patches, start, _counts(curves, matched, kind, off))


def _flat_corners(X: Floats, pins: Floats, kind: Ints, faces: Ints) -> Ints:
    """Pinned vertices (k,) at which a quad of `faces` would be flat or folded between two others that are pinned, too:
    corners of the input closer to each other than the quads can follow."""
    P = X[faces]
    normal = np.cross(P[:, 2] - P[:, 0], P[:, 3] - P[:, 1])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), SMALLEST)
    ahead, behind = np.roll(faces, -1, axis=1), np.roll(faces, 1, axis=1)
    a, b = pins[ahead] - pins[faces], pins[behind] - pins[faces]
    lengths = np.linalg.norm(a, axis=2) * np.linalg.norm(b, axis=2)
    sine = np.einsum("fcd,fd->fc", np.cross(a, b), normal) / np.maximum(lengths, SMALLEST)
    fixed = (kind[faces] == PINNED) & (kind[ahead] == PINNED) & (kind[behind] == PINNED)
    return np.unique(faces[fixed & (sine < FLAT)])


def _loose_ends(curves: FeatureCurves) -> Bools:
    """Which corners (c,) are no more than the end of one curve: where a crease fades out no vertex need be."""
    ends = np.array([(c[0], c[-1]) for c in curves.curves], np.int64).reshape(-1)
    use = np.bincount(ends, minlength=int(curves.corners.max(initial=0)) + 1)
    return np.asarray(use[curves.corners] == 1)


def _counts(curves: FeatureCurves, matched: MatchedFeatures, kind: Ints, off: Bools) -> Classification:
    return Classification(
        corners=len(curves.corners),
        matched_corners=len(matched.corners),
        curves=len(curves.curves),
        matched_curves=len(matched.curves),
        on_curves=int((kind == ON_CURVE).sum()),
        on_surface=int((kind == ON_SURFACE).sum()),
        free=int((kind == FREE).sum()),
        off_surface=int(off.sum()),
    )


def curve_tree(points: Floats) -> SimplexTree:
    """Tree over the segments of a polyline (k,3); a closed one repeats its first point."""
    index = np.arange(len(points))
    if (points[0] == points[-1]).all():
        index[-1] = 0  # one vertex, so that the tangent is continuous there
    return SimplexTree(points, np.stack([index[:-1], index[1:]], axis=1))


def _in_order(points: Floats, path: Floats, whole: bool) -> Floats:
    """Positions (k,3) on the polyline for the vertices of a path along it, from end to end where it covers the `whole`
    of it: closest points, moved towards equal spacing as far as needed to keep their order with a least gap."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    knots = np.concatenate([[0.0], np.cumsum(steps)])
    foot = SimplexTree(points, np.stack([np.arange(len(steps)), np.arange(1, len(points))], axis=1)).closest(
        path
    )
    arc = knots[foot.simplices] + foot.weights[:, 1] * steps[foot.simplices]
    if (points[0] == points[-1]).all():
        origin = arc[0]
        arc = np.concatenate([(arc[:-1] - origin) % knots[-1], knots[-1:]])
    elif whole:
        origin, arc = 0.0, np.concatenate([[0.0], arc[1:-1], knots[-1:]])
    else:
        origin = 0.0
    even = np.linspace(arc[0], arc[-1], len(path))
    for share in (0.0, 0.25, 0.5, 0.75, 1.0):
        placed = (1.0 - share) * arc + share * even
        if np.diff(placed).min() >= SMALLEST_GAP * (even[1] - even[0]):
            break
    placed = (placed + origin) % knots[-1] if origin else placed
    return np.stack([np.interp(placed, knots, points[:, d]) for d in range(3)], axis=1)

"""The smooth patches of a mesh between its feature paths, and the patch of the input that each lies on.

A vertex slides on its own patch only: the closest point on the whole surface may be across a feature edge, or on the
other side of a thin wall.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints, Surface
from neurframe_cli.mesh.optimize.feature_curves import FeatureCurves
from neurframe_cli.mesh.optimize.match_curves import MatchedFeatures
from neurframe_cli.mesh.optimize.simplex_tree import SimplexTree
from neurframe_cli.mesh.quality.polygons import unique_edges

LEAST_SHARE = 0.5  # of the faces of a mesh patch that must vote for the patch of the input
FARTHER = 0.5  # edge lengths that the own patch may be farther away than the whole surface


@dataclass(frozen=True)
class Patches:
    """trees: over parts of the surface, the first over all of it; of_face (f,), of_vertex (n,): index in trees, -1 for
    vertices of no face; distance (n,) of each vertex to its tree in lengths of its edges, 0 where it has none."""

    trees: list[SimplexTree]
    of_face: Ints
    of_vertex: Ints
    distance: Floats


def pair_patches(
    X: Floats, faces: Ints, surface: Surface, curves: FeatureCurves, matched: MatchedFeatures
) -> Patches:
    """Pair the components of mesh and surface, cut along the curves that are matched whole, by a vote of the face
    centres."""
    whole = SimplexTree(surface.V, surface.F)
    cuts = [m for m in matched.curves if m.whole]
    mesh_part = components_cut_by(faces, path_edges([m.path for m in cuts]))
    input_part = components_cut_by(surface.F, path_edges([curves.curves[m.curve] for m in cuts]))
    closest = whole.nearest(X[faces].mean(axis=1))[1]
    winners = _vote(mesh_part, input_part[closest])
    parts = np.unique(winners[winners >= 0])
    trees = [whole, *(SimplexTree(surface.V, surface.F[input_part == p]) for p in parts)]
    of_face = np.where(winners >= 0, np.searchsorted(parts, winners) + 1, 0)[mesh_part]
    of_vertex = np.full(len(X), -1, np.int64)
    of_vertex[faces] = of_face[:, None]
    distance = _fall_back_to_whole(X, faces, trees, of_vertex)
    return Patches(trees, of_face, of_vertex, distance)


def _fall_back_to_whole(X: Floats, faces: Ints, trees: list[SimplexTree], of_vertex: Ints) -> Floats:
    """Give vertices that are far from their patch, but not from the surface, to the whole surface; distances (n,)."""
    edges, _ = unique_edges(faces)
    lengths = np.repeat(np.linalg.norm(X[edges[:, 1]] - X[edges[:, 0]], axis=1), 2)
    total = np.bincount(edges.ravel(), lengths, minlength=len(X))
    mean: Floats = total / np.maximum(np.bincount(edges.ravel(), minlength=len(X)), 1)
    distance = np.zeros(len(X))
    used = np.flatnonzero(of_vertex >= 0)
    to_whole = np.zeros(len(X))
    to_whole[used] = trees[0].distances(X[used])
    for t in np.unique(of_vertex[used]).tolist():
        here = np.flatnonzero(of_vertex == t)
        distance[here] = trees[t].distances(X[here])
    astray = distance > to_whole + FARTHER * mean
    of_vertex[astray], distance[astray] = 0, to_whole[astray]
    return np.asarray(distance / np.maximum(mean, 1e-300))


def outward_normals(quads: Ints, patches: Patches) -> Callable[[Floats, Ints], Floats]:
    """Function of positions (n,3) and chosen quads (k,): normals (k,3) of the input under their centres, each on its
    own patch; patches.of_face is that of `quads` (q,4)."""

    def normals(x: Floats, chosen: Ints) -> Floats:
        centres, patch = x[quads[chosen]].mean(axis=1), patches.of_face[chosen]
        result: Floats = np.zeros_like(centres)
        for t in np.unique(patch).tolist():
            members = patch == t
            result[members] = patches.trees[t].closest(centres[members]).directions
        return result

    return normals


def components_cut_by(faces: Ints, cut: Ints) -> Ints:
    """Component (n,) of each polygon (n,k) when neighbours across the edges `cut` (c,2) do not count."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    size = int(faces.max()) + 1
    ends = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    key, owner = ends[:, 0] * size + ends[:, 1], np.repeat(np.arange(len(faces)), faces.shape[1])
    order = np.argsort(key, kind="stable")
    same = key[order][1:] == key[order][:-1]
    same &= ~np.isin(key[order][1:], cut[:, 0] * size + cut[:, 1])
    one, other = owner[order][1:][same], owner[order][:-1][same]
    graph = coo_matrix((np.ones(len(one)), (one, other)), shape=(len(faces), len(faces)))
    return np.asarray(connected_components(graph, directed=False)[1], np.int64)


def path_edges(paths: list[Ints]) -> Ints:
    """Edges (e,2) of vertex sequences, smaller vertex first."""
    pairs = [np.stack([p[:-1], p[1:]], axis=1) for p in paths]
    return np.sort(np.concatenate([*pairs, np.zeros((0, 2), np.int64)]), axis=1)


def _vote(ballots: Ints, choices: Ints) -> Ints:
    """For each ballot 0, 1, ... the most frequent of its choices, or -1 if its share is below LEAST_SHARE."""
    pairs, votes = np.unique(np.stack([ballots, choices], axis=1), axis=0, return_counts=True)
    order = np.argsort(votes, kind="stable")
    winners, best = np.full((2, int(ballots.max()) + 1), -1, np.int64)
    winners[pairs[order, 0]] = pairs[order, 1]  # the last one written is the most frequent
    best[pairs[order, 0]] = votes[order]
    winners[best < LEAST_SHARE * np.bincount(ballots)] = -1
    return np.asarray(winners)

"""Padding: a layer of hexes along the boundary, so that no hex has two faces on one smooth part of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from neurframe_cli.mesh.arrays import Features, Floats, Ints, Progress, Surface, silent
from neurframe_cli.mesh.hex_shell import HEX_EDGES, hex_shell
from neurframe_cli.mesh.optimize.improve import quad_normals
from neurframe_cli.mesh.optimize.near_surface import GOOD_ENOUGH
from neurframe_cli.mesh.optimize.smooth import MeshNumbers, SmoothedMesh, SmoothOptions
from neurframe_cli.stages.smooth_hexes import smooth_hexes

LAYER = 0.4  # share of the hexes at the boundary that the layer takes before smoothing
SMOOTH = 0.7  # least cosine between the normals of two quads on one side although a single hex has both


@dataclass(frozen=True)
class PaddedMesh:
    """Positions and report as of smoothing; cells (n,8): the padded ones, or those given where `kept` is False."""

    smoothed: SmoothedMesh
    cells: Ints
    kept: bool
    padded: MeshNumbers


def padded_hexes(
    before: SmoothedMesh,
    H: Ints,
    surface: Surface,
    features: Features,
    options: SmoothOptions,
    progress: Progress = silent,
    voids: bool = True,
) -> PaddedMesh:
    """The smoothed hexes H (n,8) with a layer along their boundary, smoothed again, or as they were if that is worse.

    Not worse: no more inverted hexes, a worst scaled Jacobian that is no lower or at least 0.3, and a Hausdorff
    distance that is no larger or within the limit of `options`.  `voids`: hexes may be missing.
    """
    V, padded = pad_hexes(before.V, H)
    after = smooth_hexes(V, padded, surface, features, options, progress, voids)
    kept = _no_worse(after.report.after, before.report.after, options.hausdorff_limit)
    chosen, cells = (after, padded) if kept else (before, H)
    return PaddedMesh(chosen, cells, kept, after.report.after)


def _no_worse(new: MeshNumbers, old: MeshNumbers, hausdorff_limit: float) -> bool:
    return (
        new.inverted <= old.inverted
        and new.min_scaled_jacobian >= min(old.min_scaled_jacobian, GOOD_ENOUGH)
        and new.hausdorff <= max(old.hausdorff, hausdorff_limit)
    )


def pad_hexes(V: Floats, H: Ints) -> tuple[Floats, Ints]:
    """Positions (m,3) and hexes (k,8), H (n,8) first: one more layer under each side of the boundary.

    A side ends at sharp edges of a single hex: there the layers of two sides cross, as in a grid, instead of meeting
    in wedges of 45 degrees (pillowing, Mitchell and Tautges 1995, side by side).  A hex with two faces on one smooth
    side gets two hexes before it.  Outer vertices are where the old ones were; these move inward.
    """
    quads = hex_shell(H).quads
    side = _sides(V, H, quads)
    for number in range(int(side.max()) + 1):
        V, H, quads, side = _pad_side(V, H, quads, side, number)
    return V, H


def pillow_hexes(V: Floats, H: Ints) -> tuple[Floats, Ints]:
    """Positions (m,3) and hexes (k,8), H (n,8) first: one more layer under the boundary as a whole, whatever its edges
    (pillowing, Mitchell and Tautges 1995); outer vertices are the last ones."""
    quads = hex_shell(H).quads
    return _pad_side(V, H, quads, np.zeros(len(quads), np.int64), 0)[:2]


def _sides(V: Floats, H: Ints, quads: Ints) -> Ints:
    """Side (f,) of each shell quad (f,4): linked across edges of more than one hex, and across smooth ones."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    size = int(H.max()) + 1
    all_edges, hexes = np.unique(_keys(H[:, HEX_EDGES].reshape(-1, 2), size), return_counts=True)
    keys = _keys(np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2), size)
    order = np.argsort(keys, kind="stable")
    paired = keys[order][1:] == keys[order][:-1]
    one, other = order[:-1] // 4, order[1:] // 4
    normal = quad_normals(V, quads)
    smooth = np.einsum("ed,ed->e", normal[one], normal[other]) > SMOOTH
    linked = paired & ((hexes[np.searchsorted(all_edges, keys[order][1:])] > 1) | smooth)
    one, other = one[linked], other[linked]
    links = coo_matrix((np.ones(len(one)), (one, other)), shape=(len(quads), len(quads)))
    return np.asarray(connected_components(links, directed=False)[1], np.int64)


def _keys(edges: Ints, size: int) -> Ints:
    return np.asarray(np.sort(edges, axis=1) @ np.array([size, 1]))


def _pad_side(V: Floats, H: Ints, quads: Ints, side: Ints, number: int) -> tuple[Floats, Ints, Ints, Ints]:
    """One layer under the quads of one side: V, H, and the shell's quads with their sides, anew."""
    group = quads[side == number]
    vertices, local = np.unique(group, return_inverse=True)
    top = (len(V) + local).reshape(group.shape)
    border, beyond = _border(quads, side, number)
    outer_of = np.full(len(V), -1)
    outer_of[vertices] = len(V) + np.arange(len(vertices))
    a, b = border.T
    walls = np.stack([a, b, outer_of[b], outer_of[a]], axis=1)
    points = np.concatenate([V, V[vertices]])
    points[vertices] = _moved_inward(V, H, group, vertices)
    return (
        points,
        np.concatenate([H, np.concatenate([group, top], axis=1)]),
        np.concatenate([quads[side != number], top, walls]),
        np.concatenate([side[side != number], np.full(len(top), number), beyond]),
    )


def _border(quads: Ints, side: Ints, number: int) -> tuple[Ints, Ints]:
    """Directed edges (e,2) of a side's quads beyond which another side (e,) begins."""
    ends = np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2)
    owner = np.repeat(side, 4)
    size = int(quads.max()) + 1
    forward, backward = ends @ np.array([size, 1]), ends @ np.array([1, size])
    others = np.flatnonzero(owner != number)
    others = others[np.argsort(backward[others], kind="stable")]
    mine = np.flatnonzero(owner == number)
    at = np.searchsorted(backward[others], forward[mine])
    met = backward[others][np.minimum(at, len(others) - 1)] == forward[mine] if len(others) else at < 0
    return ends[mine[met]], owner[others[at[met]]] if len(others) else owner[:0]


def _moved_inward(V: Floats, H: Ints, group: Ints, vertices: Ints) -> Floats:
    """Where the vertices (k,) of a side's quads go: towards the ends of those edges that leave it, on average; where
    none does, towards the centres of the hexes."""
    size = len(V)
    edges = np.unique(np.sort(H[:, HEX_EDGES].reshape(-1, 2), axis=1), axis=0)
    within = np.stack([group, np.roll(group, -1, axis=1)], axis=2).reshape(-1, 2)
    leaving = edges[~np.isin(_keys(edges, size), _keys(within, size))]
    ends = np.concatenate([leaving, leaving[:, ::-1]])
    total, count = np.zeros((size, 3)), np.bincount(ends[:, 0], minlength=size)
    np.add.at(total, ends[:, 0], V[ends[:, 1]])
    centres, hexes = np.zeros((size, 3)), np.bincount(H.ravel(), minlength=size)
    np.add.at(centres, H.ravel(), np.repeat(V[H].mean(axis=1), 8, axis=0))
    goal = np.where(
        count[:, None] > 0,
        total / np.maximum(count, 1)[:, None],
        centres / np.maximum(hexes, 1)[:, None],
    )
    return np.asarray(V[vertices] + LAYER * (goal - V)[vertices])

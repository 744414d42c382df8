"""No tet with more than one boundary face.

A frame is constant on a tet and one of its axes follows the normal of a boundary face; two faces that are not
at right angles ask for what no frame can give, and an integer-grid map makes such a tet flat.
"""

from __future__ import annotations

import numpy as np

from neurframe_cli.mesh.arrays import Bools, Floats, Ints, TetMesh
from neurframe_cli.mesh.split_tets import split_at_points, split_edges
from neurframe_cli.mesh.tet_adjacency import tet_adjacency
from neurframe_cli.mesh.tet_quality import mean_ratio


def subdivide_boundary_tets(mesh: TetMesh, marked_edges: Ints) -> tuple[TetMesh, Ints, int]:
    """The mesh with at most one boundary face per tet, the marked edges (k,2) in it, how many tets were divided.

    A tet with two boundary faces is cut through the edge opposite to the one in which they meet, together with
    its neighbours round that edge, or at its centroid, whichever leaves the better worst tet; one with three or
    four is cut at its centroid.  Old vertices keep their numbers; every marked edge that is cut becomes its two halves.
    """
    divided = 0
    while True:
        on_boundary = tet_adjacency(mesh.T).neighbors < 0
        bad = np.flatnonzero(on_boundary.sum(axis=1) > 1)
        if len(bad) == 0:
            return mesh, marked_edges, divided
        edges = np.sort(_opposite_edges(mesh.T[bad], on_boundary[bad]), axis=1)
        by_edge = _edge_is_better(mesh, bad, edges, on_boundary.sum(axis=1))
        chosen = np.unique(edges[by_edge], axis=0)
        mesh = split_at_points(mesh, bad[~by_edge], mesh.V[mesh.T[bad[~by_edge]]].mean(axis=1))
        first_midpoint = len(mesh.V)
        mesh, done = split_edges(mesh, chosen)
        marked_edges = _halved(marked_edges, chosen[done], first_midpoint)
        divided += int((~by_edge).sum() + done.sum())


def _opposite_edges(T: Ints, on_boundary: Bools) -> Ints:
    """(k,2) edge between the vertices opposite to the first two boundary faces of each tet.

    Face i lies opposite vertex i, so faces i and j meet in the other two vertices.
    """
    order = np.argsort(~on_boundary, axis=1, kind="stable")[:, :2]
    return np.take_along_axis(T, order, axis=1)


def _edge_is_better(mesh: TetMesh, bad: Ints, edges: Ints, face_count: Ints) -> Bools:
    """(k,) whether splitting the edge leaves a better worst tet than splitting at the centroid.

    Never for tets with three boundary faces or more, nor where a neighbour round the edge would become two tets
    with two boundary faces each: so every round leaves fewer bad tets than the one before.
    """
    tets_at, start = _tets_at_vertices(mesh)
    better = np.zeros(len(bad), np.bool_)
    centroid_worst = _worst_at_centroid(mesh, bad)
    # the edge through which each tet wants to be cut; (-1, -1): none
    wanted = np.full((len(mesh.T), 2), -1, np.int64)
    wanted[bad] = np.where((face_count[bad] == 2)[:, None], edges, -2)
    for i in np.flatnonzero(face_count[bad] == 2):
        a, b = edges[i]
        at_a, at_b = tets_at[start[a] : start[a + 1]], tets_at[start[b] : start[b + 1]]
        ring = np.intersect1d(at_a, at_b, assume_unique=True)
        if ((wanted[ring] == edges[i]) | (wanted[ring] == -1)).all():
            better[i] = _worst_at_midpoint(mesh, mesh.T[ring], int(a), int(b)) >= centroid_worst[i]
    return better


def _tets_at_vertices(mesh: TetMesh) -> tuple[Ints, Ints]:
    """Tets sorted by vertex, and where each vertex's begin."""
    order = np.argsort(mesh.T.ravel(), kind="stable")
    start = np.concatenate([[0], np.cumsum(np.bincount(mesh.T.ravel(), minlength=len(mesh.V)))])
    return order // 4, start


def _worst_at_midpoint(mesh: TetMesh, ring: Ints, a: int, b: int) -> float:
    """Worst quality round the edge (a, b) after its split."""
    corners = mesh.V[ring]
    midpoint = (mesh.V[a] + mesh.V[b]) / 2
    halves = [np.where((ring == end)[..., None], midpoint, corners) for end in (a, b)]
    soup = np.concatenate(halves)
    return float(mean_ratio(soup.reshape(-1, 3), np.arange(4 * len(soup)).reshape(-1, 4)).min())


def _worst_at_centroid(mesh: TetMesh, tets: Ints) -> Floats:
    """(k,) worst quality of the four parts of each tet."""
    corners = mesh.V[mesh.T[tets]]
    centroid = corners.mean(axis=1)
    qualities = []
    for i in range(4):
        part = corners.copy()
        part[:, i] = centroid
        qualities.append(mean_ratio(part.reshape(-1, 3), np.arange(4 * len(tets)).reshape(-1, 4)))
    return np.asarray(np.min(qualities, axis=0))


def _halved(marked: Ints, split: Ints, first_midpoint: int) -> Ints:
    """`marked` (k,2) with each edge of `split` (s,2) replaced by its halves at vertices first_midpoint + i."""
    if len(marked) == 0 or len(split) == 0:
        return marked
    size = 1 + max(int(marked.max()), int(split.max()))
    marked = np.sort(marked, axis=1)
    keys, wanted = marked[:, 0] * size + marked[:, 1], split[:, 0] * size + split[:, 1]
    cut = np.isin(keys, wanted)
    order = np.argsort(wanted)
    midpoint = first_midpoint + order[np.searchsorted(wanted[order], keys[cut])]
    halves = [np.column_stack([marked[cut, side], midpoint]) for side in (0, 1)]
    return np.concatenate([marked[~cut], *halves])

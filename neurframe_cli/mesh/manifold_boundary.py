"""Makes the boundary of a tet mesh a manifold by taking apart what only touches."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from neurframe_cli.mesh.arrays import Bools, Floats, Ints, TetMesh, as_tets
from neurframe_cli.mesh.split_tets import split_edges
from neurframe_cli.mesh.surface_edges import directed_edges
from neurframe_cli.mesh.tet_adjacency import TetAdjacency, tet_adjacency
from neurframe_cli.mesh.tet_quality import TET_EDGES

# a cut leaves new vertices; on the models at hand none of them was pinched again
ROUNDS = 4


@dataclass(frozen=True)
class ManifoldReport:
    """What was taken apart, and what could not be.

    halved_edges: boundary edges of four or more boundary triangles; copied_vertices: vertices doubled because their
    tets hung together in no face; cut_vertices: those where the surface touched itself from two sides of a connected
    star, cut off with half of the star; pinched_vertices: those of them that are left.
    """

    halved_edges: int
    copied_vertices: int
    cut_vertices: int
    pinched_vertices: int

    @property
    def unchanged(self) -> bool:
        return not (self.halved_edges or self.copied_vertices or self.cut_vertices)


def make_boundary_manifold(mesh: TetMesh) -> tuple[TetMesh, ManifoldReport]:
    """The same solid, apart from what only touches.

    Tets that share a vertex or an edge and are not connected there by faces get copies of it.  Where they are
    connected, two parts of the outside meet in the vertex: its surroundings are cut away, which joins these parts.
    """
    mesh, halved, copied = _take_apart(mesh)
    pinched = _pinched_vertices(tet_adjacency(mesh.T).boundary_faces)
    cut = 0
    for _ in range(ROUNDS):
        if len(pinched) == 0:
            break
        cut += len(pinched)
        mesh, more_halved, more_copied = _take_apart(_cut_off(mesh, pinched))
        halved, copied = halved + more_halved, copied + more_copied
        pinched = _pinched_vertices(tet_adjacency(mesh.T).boundary_faces)
    return mesh, ManifoldReport(halved, copied, cut, len(pinched))


def _take_apart(mesh: TetMesh) -> tuple[TetMesh, int, int]:
    """Copies of vertices and edges where tets are connected by no face; how many edges and vertices.

    An edge with four boundary triangles may have connected ends: it is split at its midpoint, where its tets fall
    into two fans.
    """
    count = len(mesh.V)
    mesh = _copy_vertices(mesh, tet_adjacency(mesh.T))
    crowded = _crowded_edges(tet_adjacency(mesh.T).boundary_faces)
    halved = 0
    while len(crowded):
        mesh, done = split_edges(mesh, crowded)
        halved += int(done.sum())
        mesh = _copy_vertices(mesh, tet_adjacency(mesh.T))
        crowded = _crowded_edges(tet_adjacency(mesh.T).boundary_faces)
    return mesh, halved, len(mesh.V) - count - halved


def _cut_off(mesh: TetMesh, vertices: Ints) -> TetMesh:
    """The mesh without the inner halves of the stars of `vertices` (k,)."""
    count = len(mesh.V)
    chosen = np.zeros(count, np.bool_)
    chosen[vertices] = True
    edges = _edges_to_cut(mesh, chosen)
    while len(edges):
        mesh, _ = split_edges(mesh, edges)
        chosen = np.concatenate([chosen, np.zeros(len(mesh.V) - len(chosen), np.bool_)])
        edges = _edges_to_cut(mesh, chosen)
        edges = edges[(edges < count).all(axis=1)]
    kept = mesh.T[~chosen[mesh.T].any(axis=1)]
    used, renumbered = np.unique(kept, return_inverse=True)
    return as_tets(mesh.V[used], renumbered.reshape(-1, 4))


def _edges_to_cut(mesh: TetMesh, chosen: Bools) -> Ints:
    """(k,2) edges that leave a chosen vertex."""
    edges = mesh.T[chosen[mesh.T].any(axis=1)][:, TET_EDGES].reshape(-1, 2)
    return np.unique(np.sort(edges[chosen[edges].any(axis=1)], axis=1), axis=0)


def _copy_vertices(mesh: TetMesh, adjacency: TetAdjacency) -> TetMesh:
    """One vertex for each set of tet corners that are connected through shared faces."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    corners = mesh.T.size
    one, two = (_corner_of(mesh.T, tets, adjacency.dual_faces).ravel() for tets in adjacency.dual_edges.T)
    graph = coo_matrix((np.ones(len(one), np.int8), (one, two)), shape=(corners, corners))
    count, part = connected_components(graph, directed=False)
    if count == len(np.unique(mesh.T)):
        return mesh
    original = np.empty(count, np.int64)
    original[part] = mesh.T.ravel()
    order = np.argsort(original, kind="stable")  # copies next to each other, the rest in the old order
    rank = np.empty(count, np.int64)
    rank[order] = np.arange(count)
    return as_tets(mesh.V[original[order]], rank[part].reshape(-1, 4))


def _corner_of(T: Ints, tets: Ints, faces: Ints) -> Ints:
    """(e,3) number 4 t + i of each vertex of `faces` (e,3) in its tet t."""
    local = (T[tets][:, None, :] == faces[:, :, None]).argmax(axis=2)
    return np.asarray(4 * tets[:, None] + local, np.int64)


def _crowded_edges(F: Ints) -> Ints:
    """(k,2) edges of more than two triangles."""
    edges, counts = np.unique(np.sort(directed_edges(F), axis=1), axis=0, return_counts=True)
    return edges[counts > 2]


def _pinched_vertices(F: Ints) -> Ints:
    """Vertices whose triangles form more than one fan."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    directed = directed_edges(F)
    # across each edge, the corner that it leaves and the corner of the other triangle at the same vertex
    arriving = np.arange(F.size).reshape(-1, 3)[:, [1, 2, 0]].ravel()
    one = np.lexsort(directed.T[::-1])
    two = arriving[np.lexsort(directed[:, ::-1].T[::-1])]
    graph = coo_matrix((np.ones(F.size, np.int8), (one, two)), shape=(F.size, F.size))
    fans = connected_components(graph, directed=False)[1]
    vertex, count = np.unique(np.unique(np.column_stack([F.ravel(), fans]), axis=0)[:, 0], return_counts=True)
    return np.asarray(vertex[count > 1], np.int64)


def boundary_surface(mesh: TetMesh) -> tuple[Floats, Ints]:
    """Positions and triangles of the boundary alone, vertices renumbered in their old order."""
    faces = tet_adjacency(mesh.T).boundary_faces
    used, renumbered = np.unique(faces, return_inverse=True)
    return mesh.V[used], renumbered.reshape(-1, 3)

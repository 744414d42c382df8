"""Splits keep the volume, the boundary and the conformity of a tet mesh."""

from __future__ import annotations

import numpy as np
import pytest

from neurframe_cli.mesh.arrays import Floats, TetMesh, as_tets
from neurframe_cli.mesh.check_tets import checked_tets, tet_volumes
from neurframe_cli.mesh.manifold_boundary import boundary_surface, make_boundary_manifold
from neurframe_cli.mesh.split_tets import split_edges
from neurframe_cli.mesh.subdivide_boundary_tets import subdivide_boundary_tets
from neurframe_cli.mesh.surface_distance import distances
from neurframe_cli.mesh.tet_adjacency import tet_adjacency
from neurframe_cli.mesh.tet_quality import mean_ratio

REGULAR = np.array([[1, 1, 1], [-1, 1, -1], [1, -1, -1], [-1, -1, 1.0]])
UNIT = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])


def grid_tets(n: int) -> TetMesh:
    """The unit cube as n^3 cells of six tets round a diagonal (Kuhn)."""
    axis = np.linspace(0, 1, n + 1)
    V = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)
    i, j, k = (a.ravel() for a in np.meshgrid(*3 * [np.arange(n)], indexing="ij"))
    number = [((i + a) * (n + 1) + j + b) * (n + 1) + k + c for a in (0, 1) for b in (0, 1) for c in (0, 1)]
    paths = [[0, 4, 6, 7], [0, 6, 2, 7], [0, 2, 3, 7], [0, 3, 1, 7], [0, 1, 5, 7], [0, 5, 4, 7]]
    T = np.concatenate([np.column_stack([number[corner] for corner in path]) for path in paths])
    return checked_tets(V, T)[0]


def volume(mesh: TetMesh) -> float:
    return float(tet_volumes(mesh.V, mesh.T).sum())


def area(V: Floats, F: np.ndarray) -> float:
    return float(np.linalg.norm(np.cross(V[F[:, 1]] - V[F[:, 0]], V[F[:, 2]] - V[F[:, 0]]), axis=1).sum() / 2)


def test_quality_of_known_tets() -> None:
    assert mean_ratio(REGULAR, np.array([[0, 1, 2, 3]]))[0] == pytest.approx(1.0)
    assert mean_ratio(REGULAR, np.array([[1, 0, 2, 3]]))[0] == pytest.approx(-1.0)
    # volume 1/6, squared edges 3 * 1 + 3 * 2: 12 * (1/2)^(2/3) / 9
    assert mean_ratio(UNIT, np.array([[0, 1, 2, 3]]))[0] == pytest.approx(12 * 0.5 ** (2 / 3) / 9)


def test_split_of_an_inner_edge() -> None:
    mesh = grid_tets(2)
    diagonal = np.array([[0, 13]])  # corner to centre: all six tets of a cell
    cut, done = split_edges(mesh, diagonal)
    assert done.all()
    assert len(cut.T) == len(mesh.T) + 6
    checked_tets(cut.V, cut.T)
    assert volume(cut) == pytest.approx(1.0)


def test_of_edges_in_one_tet_only_the_first_is_split() -> None:
    mesh = as_tets(REGULAR, [[0, 1, 2, 3]])
    cut, done = split_edges(mesh, np.array([[2, 3], [0, 1]]))
    assert done.tolist() == [True, False]
    assert len(cut.T) == 2


@pytest.mark.parametrize("mesh", [as_tets(UNIT, [[0, 1, 2, 3]]), grid_tets(1), grid_tets(3)])
def test_no_tet_keeps_two_boundary_faces(mesh: TetMesh) -> None:
    cut, _, divided = subdivide_boundary_tets(mesh, np.zeros((0, 2), np.int64))
    adjacency = tet_adjacency(cut.T)
    assert (adjacency.neighbors < 0).sum(axis=1).max() == 1
    assert divided > 0
    checked_tets(cut.V, cut.T)
    assert volume(cut) == pytest.approx(volume(mesh))
    assert np.array_equal(cut.V[: len(mesh.V)], mesh.V)
    old, new = boundary_surface(mesh), boundary_surface(cut)
    assert area(*new) == pytest.approx(area(*old))
    assert distances(new[0], *old).max() < 1e-12
    assert mean_ratio(cut.V, cut.T).min() > 0.25 * mean_ratio(mesh.V, mesh.T).min()


def test_marked_edges_follow_the_cuts() -> None:
    """The twelve edges of the cube stay twelve lines of length one."""
    mesh = grid_tets(3)
    V, F = mesh.V, tet_adjacency(mesh.T).boundary_faces
    pairs = np.unique(np.sort(F[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
    cut, edges, _ = subdivide_boundary_tets(mesh, pairs)
    after = tet_adjacency(cut.T).boundary_faces
    existing = set(map(tuple, np.sort(after[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1).tolist()))
    assert set(map(tuple, np.sort(edges, axis=1).tolist())) <= existing
    before_length = np.linalg.norm(V[pairs[:, 0]] - V[pairs[:, 1]], axis=1).sum()
    assert np.linalg.norm(cut.V[edges[:, 0]] - cut.V[edges[:, 1]], axis=1).sum() == pytest.approx(
        before_length
    )


def test_tets_that_touch_in_a_vertex_or_an_edge_are_taken_apart() -> None:
    in_vertex = as_tets(np.concatenate([UNIT, -UNIT[1:]]), [[0, 1, 2, 3], [0, 4, 6, 5]])
    in_edge = as_tets(np.concatenate([UNIT, [[0, -1, 0], [0, 0, -1.0]]]), [[0, 1, 2, 3], [0, 1, 4, 5]])
    for mesh, copies in ((in_vertex, 1), (in_edge, 2)):
        apart, report = make_boundary_manifold(checked_tets(mesh.V, mesh.T)[0])
        assert report.copied_vertices == copies
        assert report.halved_edges == report.cut_vertices == report.pinched_vertices == 0
        assert len(apart.V) == len(mesh.V) + copies
        assert volume(apart) == pytest.approx(volume(mesh))


def test_an_edge_where_a_ring_touches_itself_is_halved() -> None:
    """Two cells that share an edge only, each joined to a layer below and to one above."""
    mesh = grid_tets(3)
    x, y, z = np.floor(3 * mesh.V[mesh.T].mean(axis=1)).T
    ring, _ = checked_tets(mesh.V, mesh.T[(z != 1) | ((x == y) & (x < 2))])
    apart, report = make_boundary_manifold(ring)
    assert report.halved_edges == 1
    _, F = boundary_surface(apart)
    edges = np.sort(F[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()
    assert volume(apart) == pytest.approx(volume(ring))


def test_a_tunnel_that_is_pinched_in_a_vertex_is_opened() -> None:
    """Two pits from opposite sides of a block that meet in its centre: the star of the centre is connected."""
    mesh = grid_tets(4)
    x, y, z = np.floor(4 * mesh.V[mesh.T].mean(axis=1)).T
    pits = ((x == 1) & (y == 1) & (z >= 2)) | ((x == 2) & (y == 2) & (z < 2))
    block, _ = checked_tets(mesh.V, mesh.T[~pits])
    opened, report = make_boundary_manifold(block)
    assert report.cut_vertices == 1
    assert report.pinched_vertices == report.copied_vertices == 0
    checked_tets(opened.V, opened.T)
    V, F = boundary_surface(opened)
    edges = np.unique(
        np.sort(F[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0, return_counts=True
    )
    assert (edges[1] == 2).all()
    # the two pits are one tunnel now: a torus
    assert len(V) - len(edges[0]) + len(F) == 0
    assert volume(block) - 0.01 < volume(opened) < volume(block)

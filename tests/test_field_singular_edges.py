"""Matchings, edge rings and singular edges on fields whose singular lines are known in closed form."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from field_shapes import box_tets, cylinder_tets, four_line_frames, polar_angle, turned_about
from scipy.spatial.transform import Rotation

from neurframe_cli.field.edge_rings import edge_rings
from neurframe_cli.field.fra import read_frames
from neurframe_cli.field.matching import best_matchings, matchings_by_face
from neurframe_cli.field.octahedral_group import GROUP, Turn
from neurframe_cli.field.singular_edges import singular_edges
from neurframe_cli.mesh.read_tets import read_medit
from neurframe_cli.mesh.tet_adjacency import tet_adjacency

MODELS = Path(os.environ.get("NEURFRAME_MODELS", Path(__file__).parents[2] / "shared" / "meshes"))


def rotation(seed: int) -> np.ndarray:
    return Rotation.random(random_state=seed).as_matrix()


def randomly_named(frames: np.ndarray, seed: int = 0) -> np.ndarray:
    """The same field with the axes of each frame named and signed at random."""
    return frames @ GROUP[np.random.default_rng(seed).integers(24, size=len(frames))]


def axis_edges(V: np.ndarray, cells: int) -> set[tuple[int, int]]:
    on_axis = np.flatnonzero((np.abs(V[:, :2]) < 1e-12).all(axis=1))
    assert len(on_axis) == cells + 1
    return set(zip(on_axis[:-1].tolist(), on_axis[1:].tolist(), strict=True))


def test_matchings_undo_any_naming_of_the_axes():
    _, T = box_tets((2, 3, 2))
    adjacency = tet_adjacency(T)
    frames = np.broadcast_to(rotation(1), (len(T), 3, 3))
    names = np.random.default_rng(2).integers(24, size=len(T))
    matchings = best_matchings(frames @ GROUP[names], adjacency)
    assert matchings.angle.max() < 1e-7
    by_face = matchings_by_face(matchings.index, adjacency)
    for t in range(len(T)):
        for i, there in enumerate(adjacency.neighbors[t]):
            if there < 0:
                assert by_face[t, i] == -1
            else:
                assert (GROUP[names[t]] == GROUP[names[there]] @ GROUP[by_face[t, i]]).all()


def test_matching_angle_is_the_rotation_that_is_left():
    _, T = box_tets((1, 1, 1))
    adjacency = tet_adjacency(T)
    frames = turned_about((1, 2, 3), 0.1 * np.arange(len(T)))
    a, b = adjacency.dual_edges.T
    assert best_matchings(randomly_named(frames), adjacency).angle == pytest.approx(0.1 * np.abs(a - b))


def test_rings_go_once_round_counter_clockwise():
    V, T = box_tets((3, 2, 2))
    V = V + 0.1 * np.random.default_rng(3).uniform(-1, 1, V.shape) / 3
    adjacency = tet_adjacency(T)
    rings = edge_rings(T, adjacency)
    every = {tuple(sorted((int(t[i]), int(t[j])))) for t in T for i in range(4) for j in range(i)}
    outer = {
        tuple(sorted((int(f[i]), int(f[j]))))
        for f in adjacency.boundary_faces
        for i in range(3)
        for j in range(i)
    }
    assert {tuple(e) for e in rings.edges.tolist()} == every - outer
    for e, (u, v) in enumerate(rings.edges):
        ring = rings.tets[rings.offsets[e] : rings.offsets[e + 1]]
        assert sorted(ring) == sorted(np.flatnonzero(np.isin(T, (u, v)).sum(1) == 2))
        along = (V[v] - V[u]) / np.linalg.norm(V[v] - V[u])
        out = V[T[ring]].mean(axis=1) - V[u]
        out -= np.outer(out @ along, along)
        out /= np.linalg.norm(out, axis=1, keepdims=True)
        following = np.roll(out, -1, axis=0)
        turn = np.arctan2(np.cross(out, following) @ along, (out * following).sum(1))
        assert (turn > 0).all()
        assert turn.sum() == pytest.approx(2 * np.pi)


def test_an_open_ring_is_refused():
    _, T = box_tets((2, 2, 2))
    adjacency = tet_adjacency(T)
    inner = int(np.flatnonzero((adjacency.neighbors >= 0).all(axis=1))[0])
    adjacency.neighbors[inner, 0] = -1
    with pytest.raises(ValueError, match="not one closed ring"):
        edge_rings(T, adjacency)


def test_a_constant_field_in_a_turned_box_has_no_singular_edge():
    V, T = box_tets((4, 4, 4))
    R = rotation(4)
    frames = randomly_named(np.broadcast_to(R, (len(T), 3, 3)))
    found = singular_edges(V @ R.T, T, frames)
    assert len(found.edges) == 0
    assert set(found.summary().values()) == {0}


@pytest.mark.parametrize(
    ("axis", "turns", "quarters", "turn"),
    [
        ((0, 0, 1), 1 / 4, 1, Turn.QUARTER),
        ((0, 0, 1), -1 / 4, -1, Turn.QUARTER),
        ((0, 0, 1), 1 / 2, 2, Turn.HALF),
        ((1, 1, 1), 1 / 3, 0, Turn.COMPOUND),
        ((1, 1, 0), 1 / 2, 0, Turn.COMPOUND),
    ],
)
def test_a_field_that_turns_round_the_z_axis_is_singular_exactly_there(axis, turns, quarters, turn):
    cells = 6
    V, T = box_tets((cells, cells, cells))
    frames = turned_about(axis, turns * polar_angle(V[T].mean(axis=1)))
    R = rotation(5)
    found = singular_edges(V @ R.T, T, randomly_named(R @ frames))
    assert {tuple(e) for e in found.edges.tolist()} == axis_edges(V, cells)
    assert (found.quarters == quarters).all()
    assert (found.turn == turn).all()
    length = 2 / np.linalg.norm(np.ptp(V @ R.T, axis=0))
    assert found.total_length == pytest.approx(length)
    assert found.compound_length == pytest.approx(0 if quarters else length)
    expected_angle = np.nan if turn == Turn.COMPOUND else 0.0
    assert found.axis_angle_deg == pytest.approx(np.full(cells, expected_angle), abs=1e-6, nan_ok=True)


def test_singular_edges_do_not_depend_on_the_numbering():
    V, T = cylinder_tets(10, 4)
    frames = four_line_frames(V[T].mean(axis=1))
    rng = np.random.default_rng(6)
    vertex, tet = rng.permutation(len(V)), rng.permutation(len(T))
    renamed_V = np.empty_like(V)
    renamed_V[vertex] = V
    even = np.array([[0, 1, 2, 3], [1, 2, 0, 3], [3, 0, 2, 1]])[rng.integers(3, size=len(T))]
    renamed_T = np.take_along_axis(vertex[T], even, axis=1)[tet]
    plain, renamed = (
        singular_edges(V, T, frames),
        singular_edges(renamed_V, renamed_T, randomly_named(frames[tet])),
    )
    expected = {
        (*sorted(vertex[e].tolist()), q) for e, q in zip(plain.edges, plain.quarters.tolist(), strict=True)
    }
    assert {
        (*e, q) for e, q in zip(renamed.edges.tolist(), renamed.quarters.tolist(), strict=True)
    } == expected


def test_the_cylinder_has_four_lines_of_three_hexes_from_bottom_to_top():
    V, T = cylinder_tets(14, 6)
    found = singular_edges(V, T, four_line_frames(V[T].mean(axis=1)))
    assert (found.quarters == 1).all()
    ends = V[found.edges].reshape(-1, 3)
    lines = 0.5 * np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])
    distance = np.linalg.norm(ends[:, None, :2] - lines, axis=2)
    assert distance.min(axis=1).max() < 2 * 2 / 14  # within two edges of a line that no mesh edge lies on
    nearest = distance.argmin(axis=1)
    for line in range(4):
        vertices, degree = np.unique(found.edges.reshape(-1)[nearest == line], return_counts=True)
        heights = V[vertices[degree == 1], 2]
        assert sorted(heights) == [-1.0, 1.0]  # one path
        assert degree.max() == 2


@pytest.mark.skipif(not MODELS.is_dir(), reason="the models are not part of the repository")
@pytest.mark.parametrize("name", ["cubecover_tetrahedron_100", "cubecover_disk_3480_tets_gl3"])
def test_agrees_with_the_independent_yardstick(name):
    mesh, fra = MODELS / "tet" / f"{name}.mesh", MODELS / "tet" / f"{name}.fra"
    yardstick = MODELS.parent / "bench" / "check_field.py"
    said = subprocess.run(
        [sys.executable, yardstick, mesh, fra, "--json"], capture_output=True, check=True
    ).stdout
    report = json.loads(said)
    tets, _ = read_medit(mesh)
    found = singular_edges(tets.V, tets.T, read_frames(fra))
    assert len(found.edges) == report["singular_edges"]
    assert found.total_length == pytest.approx(report["singular_length"])
    assert (found.turn == Turn.COMPOUND).sum() == report["inadmissible_edges"]
    assert found.compound_length == pytest.approx(report["inadmissible_length"])

"""Singular points of closed-form fields lie on the known lines, with the known kind, all along them."""

from __future__ import annotations

import numpy as np
import pytest
from field_shapes import box_tets, cylinder_tets, four_line_frames, polar_angle, turned_about

from neurframe_cli.field.frame_loops import loop_holonomies
from neurframe_cli.field.frames import frame_to_band4
from neurframe_cli.field.octahedral_group import AXIS, GROUP, TURN, Turn
from neurframe_cli.mesh.arrays import Floats, TetMesh
from neurframe_cli.mesh.inside import depth_in_surface, random_points_in_tets
from neurframe_cli.stages.singularities import SingularitiesOptions, find_singularities

OPTIONS = SingularitiesOptions(samples=200, radius=0.15, tolerance=0.01)


def test_loops_follow_the_nearest_image_whatever_the_axes_are_called():
    angle = 2 * np.pi * np.arange(12) / 12
    loops = np.stack(
        [
            turned_about((0, 0, 1), angle / 4),
            turned_about((0, 0, 1), -angle / 4),
            turned_about((1, 1, 0), 0 * angle),
        ]
    )
    names = np.random.default_rng(0).integers(24, size=loops.shape[:2])
    named = loops @ GROUP[names]
    holonomy = loop_holonomies(named)
    assert TURN[holonomy].tolist() == [Turn.QUARTER, Turn.QUARTER, Turn.IDENTITY]
    axes = np.einsum("nij,nj->ni", named[:2, 0], AXIS[holonomy[:2]])
    assert axes == pytest.approx(np.array([[0, 0, 1], [0, 0, -1]]), abs=1e-12)


@pytest.mark.slow
def test_the_cylinder_has_points_on_its_four_lines_only_and_all_along_them():
    V, T = cylinder_tets(14, 6)
    options = SingularitiesOptions(samples=1500, tolerance=0.01)
    found = find_singularities(lambda p: frame_to_band4(four_line_frames(p)), TetMesh(V, T), options)
    assert (found.quarters == 1).all()
    assert np.abs(found.axis[:, 2]) == pytest.approx(np.ones(len(found.points)), abs=1e-9)
    lines = 0.5 * np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])
    distance = np.linalg.norm(found.points[:, None, :2] - lines, axis=2)
    diagonal = np.linalg.norm(np.ptp(V, axis=0))
    assert distance.min(axis=1).max() < options.tolerance * diagonal
    for line in range(4):
        heights = found.points[distance.argmin(axis=1) == line, 2]
        assert len(heights) > 8
        assert heights.min() < -0.7
        assert heights.max() > 0.7
        assert np.diff(np.sort(heights)).max() < 0.5


@pytest.mark.parametrize(
    ("axis", "turns", "turn", "quarters"),
    [
        ((0, 0, 1), -1 / 4, Turn.QUARTER, -1),
        ((0, 0, 1), 1 / 2, Turn.HALF, 2),
        ((1, 1, 1), 1 / 3, Turn.COMPOUND, 0),
    ],
)
def test_kinds_of_lines(axis, turns, turn, quarters):
    V, T = box_tets((3, 3, 3))

    def query(points: Floats) -> Floats:
        return frame_to_band4(turned_about(axis, turns * polar_angle(points)))

    found = find_singularities(query, TetMesh(V, T), OPTIONS)
    assert len(found.points) > 10
    assert (found.turn == turn).all()
    assert (found.quarters == quarters).all()
    assert np.linalg.norm(found.points[:, :2], axis=1).max() < OPTIONS.tolerance * np.sqrt(12)


def test_a_smooth_field_has_none_and_progress_never_falls():
    V, T = box_tets((2, 2, 2))
    seen: list[float] = []
    found = find_singularities(
        lambda p: frame_to_band4(turned_about((1, 2, 2), p[:, 0])),
        TetMesh(V, T),
        OPTIONS,
        lambda x, _: seen.append(x),
    )
    assert found.points.shape == (0, 3)
    assert seen == sorted(seen)


def test_the_same_seed_gives_the_same_points():
    V, T = cylinder_tets(6, 3)
    runs = [
        find_singularities(
            lambda p: frame_to_band4(four_line_frames(p)),
            TetMesh(V, T),
            SingularitiesOptions(samples=60, tolerance=0.02),
        )
        for _ in range(2)
    ]
    assert np.array_equal(runs[0].points, runs[1].points)


def test_random_points_are_uniform_and_inside():
    V, T = box_tets((1, 2, 3))
    points = random_points_in_tets(TetMesh(V, T), 20_000, np.random.default_rng(0))
    assert np.abs(points.mean(axis=0)).max() < 0.02
    assert points.var(axis=0) == pytest.approx(np.full(3, 1 / 3), abs=0.01)


def test_depth_is_the_signed_distance_to_the_box():
    from neurframe_cli.mesh.arrays import Surface
    from neurframe_cli.mesh.tet_adjacency import tet_adjacency

    V, T = box_tets((2, 2, 2))
    surface = Surface(V, tet_adjacency(T).boundary_faces)
    points = np.array([[0, 0, 0], [0.9, 0, 0], [1.5, 0, 0], [2, 2, 1.0]])
    assert depth_in_surface(points, surface) == pytest.approx(np.array([1, 0.1, -0.5, -np.sqrt(2)]))
    assert len(depth_in_surface(points[:0], surface)) == 0

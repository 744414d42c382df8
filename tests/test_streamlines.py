"""Streamlines of closed-form fields: straight lines, circles, and what happens at edges."""

from __future__ import annotations

import numpy as np
import pytest
from field_shapes import box_tets, cylinder_tets, turned_about
from scipy.spatial.transform import Rotation

from neurframe_cli.field.frames import frame_to_band4
from neurframe_cli.mesh.arrays import Floats, Surface, TetMesh
from neurframe_cli.mesh.tet_adjacency import tet_adjacency
from neurframe_cli.stages.streamline_steps import Heads, step_in_volume, step_on_surface, transported
from neurframe_cli.stages.streamlines import StreamlineOptions, trace, trace_streamlines


def surface_of(V: Floats, T: np.ndarray) -> Surface:
    return Surface(V, tet_adjacency(T).boundary_faces)


def constant(R: Floats):
    return lambda points: np.broadcast_to(frame_to_band4(R), (len(points), 9))


def polar(points: Floats) -> Floats:
    return frame_to_band4(turned_about((0, 0, 1), np.arctan2(points[:, 1], points[:, 0])))


def length(line: Floats) -> float:
    return float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())


def test_a_constant_field_in_a_box_gives_straight_lines_that_end_at_the_boundary():
    V, T = box_tets((2, 2, 2))
    R = Rotation.random(random_state=0).as_matrix()
    found = trace_streamlines(
        constant(R), TetMesh(V @ R.T, T), surface_of(V @ R.T, T), StreamlineOptions(samples=20, length=2.0)
    )
    assert len(found.volume) == len(found.surface) == 20
    for line in found.volume:
        extent = np.ptp(line @ R, axis=0)
        assert np.sort(extent)[:2] == pytest.approx([0, 0], abs=1e-9)
        assert extent.max() == pytest.approx(2, abs=2 * 0.01 * np.linalg.norm(np.ptp(V @ R.T, axis=0)))
        assert np.abs(line @ R).max() <= 1


def test_lines_on_a_box_go_round_it_over_the_sharp_edges():
    V, T = box_tets((2, 2, 2))
    options = StreamlineOptions(samples=20, length=1.5)
    found = trace_streamlines(constant(np.eye(3)), TetMesh(V, T), surface_of(V, T), options)
    for line in found.surface:
        assert np.abs(line).max(axis=1) == pytest.approx(np.ones(len(line)))  # on the surface
        across = np.ptp(line, axis=0).argmin()
        assert np.ptp(line[:, across]) < 1e-9  # in a plane
        assert (np.ptp(np.delete(line, across, axis=1), axis=0) > 1.9).all()  # over two edges at least
        assert length(line) > 0.9 * 2 * options.length * np.sqrt(12)


def test_circles_are_closed_by_midpoint_steps_to_second_order():
    V, T = cylinder_tets(24, 2)
    steps = 50
    heads = Heads(np.array([[0.5, 0, 0]]), np.array([[0.0, 1, 0]]), np.zeros((1, 3)))
    step = step_in_volume(polar, surface_of(V, T), np.pi / steps)
    for _ in range(steps):
        heads, inside = step(heads)
        assert inside.all()
    assert heads.points[0] == pytest.approx([0.5, 0, 0], abs=1e-2)


def test_on_a_cylinder_lines_run_up_or_round_and_cross_to_the_lids():
    V, T = cylinder_tets(32, 4)
    surface = surface_of(V, T)
    start = np.array([[1.0, 0.0, 0.03], [1.0, 0.0, 0.03]])
    heads = Heads(start, np.array([[0, 0, 1.0], [0, 1.0, 0]]), np.array([[1.0, 0, 0], [1.0, 0, 0]]))
    up, round_ = trace(step_on_surface(polar, surface, 0.02), heads, 60)
    assert np.abs(up[:, 1]).max() < 0.05
    assert np.ptp(up[:, 2]) == pytest.approx(2.0)
    assert np.abs(up[:, 0]).min() < 0.9  # on the lids
    assert np.ptp(round_[:, 2]) < 1e-9
    assert np.hypot(round_[:, 0], round_[:, 1]) == pytest.approx(np.ones(len(round_)), abs=0.005)
    assert length(round_) == pytest.approx(2 * 60 * 0.02, rel=0.02)


def test_directions_are_carried_over_an_edge_by_the_smallest_rotation():
    before, after = np.array([[0, 0, 1.0]] * 3), np.array([[1.0, 0, 0]] * 2 + [[0, 0, 1.0]])
    directions = np.array([[1.0, 0, 0], [0, 1, 0], [0.6, 0.8, 0]])
    expected = np.array([[0, 0, -1.0], [0, 1, 0], [0.6, 0.8, 0]])
    assert transported(directions, before, after) == pytest.approx(expected, abs=1e-15)


def test_progress_never_falls_and_the_seed_decides():
    V, T = box_tets((2, 2, 2))
    seen: list[float] = []
    options = StreamlineOptions(samples=5, length=0.1)
    runs = [
        trace_streamlines(polar, TetMesh(V, T), surface_of(V, T), options, lambda x, _: seen.append(x))
        for _ in range(2)
    ]
    half = len(seen) // 2
    assert seen[:half] == sorted(seen[:half])
    assert seen[half - 1] == 1.0
    for one, other in zip(runs[0].volume + runs[0].surface, runs[1].volume + runs[1].surface, strict=True):
        assert np.array_equal(one, other)

"""Crosses of frames and the angles between frames and given directions."""

from __future__ import annotations

import numpy as np
import pytest
from field_shapes import box_tets, cylinder_tets, four_line_frames, turned_about
from scipy.spatial.transform import Rotation

from neurframe_cli.field.cross_field import crosses_of_frames
from neurframe_cli.field.frame_angles import (
    axis_angles_deg,
    deviation,
    feature_angles_deg,
    normal_angles_deg,
)
from neurframe_cli.field.octahedral_group import GROUP
from neurframe_cli.mesh.tet_adjacency import tet_adjacency


def random_frames(n: int, seed: int) -> np.ndarray:
    return Rotation.random(n, random_state=seed).as_matrix()


def normals(n: int, seed: int) -> np.ndarray:
    v = np.random.default_rng(seed).normal(size=(n, 3))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def test_crosses_are_tangent_orthonormal_and_right_handed():
    n = normals(2000, 0)
    cross = crosses_of_frames(random_frames(2000, 1), n)
    gram = cross @ cross.transpose(0, 2, 1)
    assert gram == pytest.approx(np.broadcast_to(np.eye(2), gram.shape), abs=1e-13)
    assert np.einsum("nij,nj->ni", cross, n) == pytest.approx(np.zeros((2000, 2)), abs=1e-13)
    assert np.cross(cross[:, 0], cross[:, 1]) == pytest.approx(n, abs=1e-13)


def test_an_aligned_frame_keeps_its_other_two_axes():
    frames = random_frames(24, 2)
    for axis in range(3):
        for sign in (1, -1):
            cross = crosses_of_frames(frames, sign * frames[:, :, axis])
            kept = np.abs(np.einsum("nij,njk->nik", cross, frames))
            assert kept[:, :, axis] == pytest.approx(np.zeros((24, 2)), abs=1e-14)
            assert np.sort(kept, axis=2)[:, :, 2] == pytest.approx(np.ones((24, 2)))


def test_crosses_do_not_depend_on_the_names_of_the_axes():
    frames, n = random_frames(500, 3), normals(500, 4)
    cosines = np.sort(np.abs(np.einsum("nij,ni->nj", frames, n)), axis=1)
    clear = cosines[:, 2] - cosines[:, 1] > 1e-6  # else either of two axes may be dropped
    expected = crosses_of_frames(frames, n)[clear]
    for g in GROUP:
        found = crosses_of_frames(frames @ g, n)[clear]
        same = np.abs(np.einsum("nij,nkj->nik", found, expected))
        assert np.sort(same.reshape(-1, 4), axis=1)[:, 2:] == pytest.approx(np.ones((clear.sum(), 2)))


def test_the_cross_is_the_best_one_over_all_tangent_rotations():
    frames, n = random_frames(50, 5), normals(50, 6)
    cross = crosses_of_frames(frames, n)
    dropped = np.abs(np.einsum("nij,ni->nj", frames, n)).argmax(axis=1)
    for i in range(50):
        axes = np.delete(frames[i], dropped[i], axis=1).T

        def cost(c: np.ndarray, axes: np.ndarray = axes) -> float:
            return float((1 - np.abs(c @ axes.T).max(axis=0)).sum())

        best = cost(cross[i])
        for angle in np.linspace(0, np.pi / 2, 91):
            turned = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]]) @ cross[i]
            assert best <= cost(turned) + 1e-12


def test_a_triangle_without_area_still_gets_an_orthonormal_cross():
    cross = crosses_of_frames(random_frames(1, 9), np.zeros((1, 3)))[0]
    assert cross @ cross.T == pytest.approx(np.eye(2))


def test_axis_angles_see_any_axis_and_sign_and_small_angles():
    frames = random_frames(100, 7)
    angles = np.logspace(-9, np.log10(40), 100)
    for g in GROUP:
        tilted = np.einsum("nij,njk->nik", frames, turned_about((0, 0, 1), np.radians(angles)))
        assert axis_angles_deg(frames @ g, -3.0 * tilted[:, :, 0]) == pytest.approx(angles, rel=1e-6)


def test_normals_and_features_of_a_turned_box():
    V, T = box_tets((3, 3, 3))
    adjacency = tet_adjacency(T)
    R = Rotation.random(random_state=8).as_matrix()
    rows = np.flatnonzero((V[:, 0] == 1) & (V[:, 1] == 1))
    edges = np.stack([rows[:-1], rows[1:]], axis=1)
    tilt = turned_about((1, 0, 0), np.full(len(T), np.radians(5.0)))
    normal = normal_angles_deg(V @ R.T, adjacency, R @ tilt)
    sides = np.abs(V[adjacency.boundary_faces].mean(axis=1))[:, 0] > 0.999
    assert normal == pytest.approx(np.where(sides, 0.0, 5.0), abs=1e-6)
    feature = deviation(feature_angles_deg(V @ R.T, T, edges[:, ::-1], R @ tilt))
    holders = sum(int((np.isin(T, edge).sum(1) == 2).sum()) for edge in edges)
    assert (feature.mean_deg, feature.max_deg, feature.count) == (pytest.approx(5), pytest.approx(5), holders)
    assert deviation(feature_angles_deg(V, T, edges[:0], tilt)).count == 0


def test_the_harmonic_field_of_the_cylinder_is_normal_to_its_side():
    V, T = cylinder_tets(24, 4)
    adjacency = tet_adjacency(T)
    angles = normal_angles_deg(V, adjacency, four_line_frames(V[T].mean(axis=1)))
    assert deviation(angles).mean_deg < 1.5
    assert deviation(angles).max_deg < 360 / 96 * 2  # the facets and centroids of 96 sides

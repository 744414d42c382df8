"""Frames against the paper's F(s), and the projection against exact frames, symmetry and brute force."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from neurframe_cli.field.frames import frame_to_band4, nearest_frames
from neurframe_cli.field.octahedral_group import GROUP
from neurframe_cli.field.rotations import angle_between, cross_matrix, exponential
from neurframe_cli.field.spherical_harmonics import ALIGNED, alignment_vector, band4, rotation_band4


def rotations(n: int, seed: int = 0) -> np.ndarray:
    return Rotation.random(n, random_state=seed).as_matrix()


def unit_rows(n: int, width: int, seed: int) -> np.ndarray:
    v = np.random.default_rng(seed).normal(size=(n, width))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def angle_modulo_group(A: np.ndarray, B: np.ndarray) -> np.ndarray:
    return np.min([angle_between(A, B @ g) for g in GROUP], axis=0)


def test_exponential_is_scipys():
    w = np.random.default_rng(1).normal(size=(100, 3)) * np.logspace(-12, 1, 100)[:, None]
    assert exponential(w) == pytest.approx(Rotation.from_rotvec(w).as_matrix(), abs=1e-14)
    assert cross_matrix(w)[7] @ w[3] == pytest.approx(np.cross(w[7], w[3]))


def test_coefficients_are_those_of_the_papers_function_up_to_constants():
    """F(s) = c0 + c1 q.Y4(s) with c1 < 0, by quadrature on a grid that integrates degree 8 exactly."""
    heights, weights = np.polynomial.legendre.leggauss(8)
    phi = 2 * np.pi * np.arange(16) / 16
    s = np.array(
        [[np.sqrt(1 - z * z) * np.cos(t), np.sqrt(1 - z * z) * np.sin(t), z] for z in heights for t in phi]
    )
    w = np.repeat(weights, 16) * 2 * np.pi / 16
    for R in rotations(5):
        squares = (s @ R) ** 2
        F = squares[:, 0] * squares[:, 1] + squares[:, 1] * squares[:, 2] + squares[:, 2] * squares[:, 0]
        projected = band4(s).T @ (w * F)
        q = frame_to_band4(R)
        assert projected / np.linalg.norm(projected) == pytest.approx(-q, abs=1e-14)
        mean = w @ F / (4 * np.pi)
        assert mean + band4(s) @ projected == pytest.approx(F, abs=1e-14)  # bands 0 and 4 hold all of F


def test_coefficients_of_the_standard_frame_and_their_rotation():
    q0 = np.zeros(9)
    q0[4], q0[8] = ALIGNED, np.sqrt(5 / 12)
    R = rotations(40)
    assert frame_to_band4(np.eye(3)) == pytest.approx(q0, abs=1e-15)
    assert frame_to_band4(R) == pytest.approx(rotation_band4(R) @ q0, abs=1e-14)
    for g in GROUP:
        assert frame_to_band4(R @ g) == pytest.approx(frame_to_band4(R), abs=1e-14)
    for axis in range(3):
        aligned = (alignment_vector(R[:, :, axis]) * frame_to_band4(R)).sum(1)
        assert aligned == pytest.approx(ALIGNED, abs=1e-14)


def test_projection_returns_frames_exactly():
    R = rotations(5000, 2)
    projection = nearest_frames(3.7 * frame_to_band4(R))
    assert projection.converged.all()
    assert angle_modulo_group(projection.frames, R).max() < 1e-11
    assert projection.distance == pytest.approx(2.7)
    gram = projection.frames.transpose(0, 2, 1) @ projection.frames
    assert gram == pytest.approx(np.broadcast_to(np.eye(3), gram.shape), abs=1e-13)
    assert np.linalg.det(projection.frames) == pytest.approx(1.0)


def test_projection_turns_with_its_argument():
    q, R = unit_rows(300, 9, 3), rotations(300, 4)
    straight = nearest_frames(q)
    turned = nearest_frames(np.einsum("nij,nj->ni", rotation_band4(R), q))
    assert turned.distance == pytest.approx(straight.distance, abs=1e-9)
    # ties are not expected among random vectors, so the frames turn as well
    assert np.percentile(angle_modulo_group(turned.frames, R @ straight.frames), 99) < 1e-6


def test_projection_is_global_on_random_vectors_against_brute_force():
    """50,000 random frames, of which the best is 0.001 worse on average, never beat the projection."""
    q = unit_rows(2000, 9, 5)
    projection = nearest_frames(q)
    assert projection.converged.all()
    value = np.einsum("ni,ni->n", q, frame_to_band4(projection.frames))
    dense = frame_to_band4(rotations(50_000, 6))
    best = np.concatenate([(part @ dense.T).max(axis=1) for part in np.array_split(q, 10)])
    assert (value - best).min() > -1e-12
    assert (value - best).mean() < 0.01
    assert projection.distance**2 == pytest.approx(2 - 2 * value, abs=1e-12)


def test_degenerate_vectors():
    zonal = np.eye(9)[4]  # every frame with a vertical axis is nearest
    projection = nearest_frames(np.stack([zonal, np.zeros(9), np.full(9, np.nan)]))
    assert projection.converged.tolist() == [True, False, False]
    assert np.abs(projection.frames[0][2]).max() == pytest.approx(1.0, abs=1e-9)
    assert projection.distance[0] ** 2 == pytest.approx(2 - 2 * ALIGNED)
    assert np.isfinite(projection.frames).all()
    assert nearest_frames(np.zeros((0, 9))).frames.shape == (0, 3, 3)


def test_no_frame_depends_on_the_other_rows_or_on_the_threads_of_a_blas():
    rng = np.random.default_rng(5)
    # about one axis: many starts are equally good, and the last bits decide
    q = frame_to_band4(exponential(rng.uniform(-1.0, 1.0, (100, 1)) * [0.0, 0.0, 1.0]))
    together = nearest_frames(q).frames
    alone = np.concatenate([nearest_frames(row).frames for row in q])
    assert np.array_equal(alone, together)

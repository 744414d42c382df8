"""Band 4 against scipy, rotations against the rotated function, the alignment term against its 9x9 form."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.spatial.transform import Rotation
from scipy.special import factorial, lpmv

from neurframe_cli.field import spherical_harmonics as sh


def unit_vectors(n: int, seed: int = 0) -> np.ndarray:
    v = np.random.default_rng(seed).normal(size=(n, 3))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def rotations(n: int, seed: int = 1) -> np.ndarray:
    return Rotation.random(n, random_state=seed).as_matrix()


def rotation_to_z(d: np.ndarray) -> np.ndarray:
    """A rotation that takes d to +z, about an axis orthogonal to both."""
    axis = np.cross(d, [0.0, 0.0, 1.0])
    angle = np.arctan2(np.linalg.norm(axis), d[2])
    return Rotation.from_rotvec(angle * axis / np.linalg.norm(axis)).as_matrix()


def test_band4_is_the_real_form_of_the_associated_legendre_functions():
    d = unit_vectors(200)
    phi = np.arctan2(d[:, 1], d[:, 0])
    expected = []
    for m in range(-4, 5):
        k = abs(m)
        norm = np.sqrt(9 / (4 * np.pi) * factorial(4 - k) / factorial(4 + k) * (1 if m == 0 else 2))
        # scipy's lpmv has the Condon-Shortley phase (-1)^m, the real convention has not
        polar = (-1) ** k * lpmv(k, 4, d[:, 2])
        expected.append(norm * polar * (np.sin(k * phi) if m < 0 else np.cos(k * phi)))
    assert sh.band4(d) == pytest.approx(np.stack(expected, axis=1), abs=1e-14)


def test_addition_theorem_gives_unit_alignment_vectors():
    d, e = unit_vectors(50, 2), unit_vectors(50, 3)
    legendre4 = np.polynomial.legendre.Legendre.basis(4)
    inner = (sh.alignment_vector(d) * sh.alignment_vector(e)).sum(1)
    assert inner == pytest.approx(legendre4((d * e).sum(1)), abs=1e-14)


def test_rotation_acts_as_the_rotated_function():
    q = np.random.default_rng(4).normal(size=(20, 9))
    R, s = rotations(20), unit_vectors(300, 5)
    rotated = np.einsum("nij,nj->ni", sh.rotation_band4(R), q)
    for i in range(20):
        assert sh.band4(s) @ rotated[i] == pytest.approx(sh.band4(s @ R[i]) @ q[i], abs=1e-13)


def test_rotations_form_an_orthogonal_representation():
    A, B = rotations(30, 6), rotations(30, 7)
    D = sh.rotation_band4(A)
    assert D @ D.transpose(0, 2, 1) == pytest.approx(np.broadcast_to(np.eye(9), D.shape), abs=1e-14)
    assert sh.rotation_band4(A @ B) == pytest.approx(D @ sh.rotation_band4(B), abs=1e-14)
    assert sh.rotation_band4(np.eye(3)) == pytest.approx(np.eye(9), abs=1e-15)


def test_generators_exponentiate_to_rotations_and_obey_so3():
    L = sh.generators()
    for w in np.random.default_rng(8).normal(size=(10, 3)) * 2:
        D = expm(np.tensordot(w, L, 1))
        assert sh.rotation_band4(Rotation.from_rotvec(w).as_matrix()) == pytest.approx(D, abs=1e-12)
    x, y, z = L
    assert x @ y - y @ x == pytest.approx(z, abs=1e-13)
    assert y @ z - z @ y == pytest.approx(x, abs=1e-13)
    assert -(x @ x + y @ y + z @ z) == pytest.approx(20 * np.eye(9), abs=1e-12)  # Casimir, l (l + 1)


def test_alignment_vector_equals_the_9x9_form_of_the_paper():
    q = np.random.default_rng(9).normal(size=(100, 9))
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    d = unit_vectors(100, 10)
    long_way = [sh.rotation_band4(rotation_to_z(di))[4] @ qi for di, qi in zip(d, q, strict=True)]
    assert (sh.alignment_vector(d) * q).sum(1) == pytest.approx(np.array(long_way), abs=1e-13)


def test_alignment_reaches_its_target_exactly_on_the_frames_about_z():
    theta = np.linspace(0, np.pi, 13)
    qz = np.zeros((13, 9))
    qz[:, 0] = np.sqrt(5 / 12) * np.sin(4 * theta)
    qz[:, 4] = sh.ALIGNED
    qz[:, 8] = np.sqrt(5 / 12) * np.cos(4 * theta)
    assert qz @ sh.alignment_vector(np.array([0.0, 0.0, 1.0])) == pytest.approx(sh.ALIGNED, abs=1e-15)
    turned = Rotation.from_rotvec(np.outer(theta, [0, 0, 1])).as_matrix()
    assert sh.rotation_band4(turned) @ qz[0] == pytest.approx(qz, abs=1e-14)

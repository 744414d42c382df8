"""Rotation matrices from rotation vectors and back, for arrays of them."""

from __future__ import annotations

import numpy as np

from neurframe_cli.mesh.arrays import Floats


def exponential(w: Floats) -> Floats:
    """Rotation matrices exp([w]x) of rotation vectors: w (n,3) in radians -> (n,3,3) (Rodrigues)."""
    angle = np.linalg.norm(w, axis=1)
    # sin(a)/a and (1 - cos a)/a^2 = sinc(a/2)^2 / 2, both smooth at zero; np.sinc takes a/pi
    a = np.sinc(angle / np.pi)[:, None, None]
    b = 0.5 * (np.sinc(angle / (2 * np.pi)) ** 2)[:, None, None]
    K = cross_matrix(w)
    return np.asarray(np.eye(3) + a * K + b * (K @ K))


def random_rotations(count: int, rng: np.random.Generator) -> Floats:
    """Uniformly distributed rotation matrices (count,3,3): of normally distributed, then unit, quaternions."""
    q = rng.normal(size=(count, 4))
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    w, v = q[:, 0, None, None], q[:, 1:]
    K = cross_matrix(v)
    return np.asarray(np.eye(3) + 2 * w * K + 2 * (K @ K))


def cross_matrix(w: Floats) -> Floats:
    """[w]x with [w]x v = w x v: (n,3) -> (n,3,3)."""
    K = np.zeros((len(w), 3, 3))
    K[:, 0, 1], K[:, 0, 2], K[:, 1, 2] = -w[:, 2], w[:, 1], -w[:, 0]
    K[:, 1, 0], K[:, 2, 0], K[:, 2, 1] = w[:, 2], -w[:, 1], w[:, 0]
    return K


def angle_between(A: Floats, B: Floats) -> Floats:
    """Angle in radians of the rotation that takes A to B: (n,3,3), (n,3,3) -> (n,).

    From |A - B|_F = 2 sqrt(2) sin(angle / 2), which is accurate for small angles where the arc cosine is not.
    """
    chord = np.linalg.norm((A - B).reshape(-1, 9), axis=1)
    return np.asarray(2.0 * np.arcsin(np.minimum(chord / np.sqrt(8.0), 1.0)))

"""Band 4 of the real spherical harmonics: values, rotations, generators, the alignment term.

Order and signs are the usual real ones: Y_{4,m} for m = -4 ... 4 ascending, m > 0 ~ cos(m phi),
m < 0 ~ sin(|m| phi), no Condon-Shortley phase, orthonormal on the unit sphere.  The paper (section 3.2) lists
q_z with its cos(4 theta) entry first and sin(4 theta) last, which is the mirror order m = 4 ... -4.  Nothing
depends on it: every formula in use is an inner product of coefficient vectors, which a common permutation of
the entries leaves as it is, and Y_{4,0} is the middle entry in both.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from neurframe_cli.mesh.arrays import Floats

# e0' R(d->z) q of a frame that has d as an axis (paper, equation 2)
ALIGNED = float(np.sqrt(7.0 / 12.0))


def band4(d: Floats) -> Floats:
    """Y_{4,-4} ... Y_{4,4} at unit vectors: d (..., 3) -> (..., 9)."""
    x, y, z = d[..., 0], d[..., 1], d[..., 2]
    xx, yy, zz = x * x, y * y, z * z
    a, b, c = (0.75 * np.sqrt(v / np.pi) for v in (35.0, 17.5, 5.0))
    e = 0.75 * np.sqrt(2.5 / np.pi)
    values = (
        a * x * y * (xx - yy),
        b * y * z * (3 * xx - yy),
        c * x * y * (7 * zz - 1),
        e * y * z * (7 * zz - 3),
        0.1875 / np.sqrt(np.pi) * (zz * (35 * zz - 30) + 3),
        e * x * z * (7 * zz - 3),
        0.5 * c * (xx - yy) * (7 * zz - 1),
        b * x * z * (xx - 3 * yy),
        0.25 * a * (xx * (xx - 3 * yy) - yy * (3 * xx - yy)),
    )
    return np.stack(values, axis=-1)


def alignment_vector(d: Floats) -> Floats:
    """The a(d) with a(d).q = e0' R(d->z) q, alignment in the paper's equation 2: unit d (..., 3) -> (..., 9).

    R(d->z) is an isometry that moves the zonal harmonic about d to the one about z, so its middle row is the
    zonal harmonic about d, sqrt(4 pi / 9) Y4(d) by the addition theorem.  a(d) is a unit vector; a(d).q <=
    ALIGNED for every frame q, with equality where d is one of its axes.
    """
    return np.asarray(np.sqrt(4.0 * np.pi / 9.0) * band4(d))


@cache
def _quadrature() -> tuple[Floats, Floats]:
    """Directions (45, 3) and weights (45,), exact up to degree 8, hence for products of two of band 4."""
    height, weight = np.polynomial.legendre.leggauss(5)
    phi = 2.0 * np.pi * np.arange(9) / 9.0
    z, angle = (v.ravel() for v in np.meshgrid(height, phi, indexing="ij"))
    radius = np.sqrt(1.0 - z * z)
    directions = np.stack([radius * np.cos(angle), radius * np.sin(angle), z], axis=1)
    return directions, np.repeat(weight, 9) * (2.0 * np.pi / 9.0)


def rotation_band4(R: Floats) -> Floats:
    """The action of rotations on coefficients: R (..., 3, 3) -> D (..., 9, 9) orthogonal, D(A B) = D(A) D(B).

    If q holds the coefficients of f, D q holds those of s -> f(R^-1 s).  Column m of D is the projection of
    the rotated Y_{4,m}, by a quadrature that is exact for it; the only error is rounding (about 1e-15).
    """
    directions, weights = _quadrature()
    rotated = band4(directions @ np.asarray(R, np.float64))
    return np.asarray((band4(directions) * weights[:, None]).T @ rotated)


@cache
def generators() -> Floats:
    """Lx, Ly, Lz as (3, 9, 9), antisymmetric: D(exp([w]x)) = exp(w_x Lx + w_y Ly + w_z Lz).

    Lz is d/dt of cos(m (phi - t)) and sin(m (phi - t)); the cyclic change of axes makes the other two of it.
    """
    Lz = np.zeros((9, 9))
    for m in range(1, 5):
        Lz[4 - m, 4 + m], Lz[4 + m, 4 - m] = m, -m
    D = rotation_band4(np.roll(np.eye(3), 1, axis=0))  # x -> y -> z -> x
    Lx = D @ Lz @ D.T
    L = np.stack([Lx, D @ Lx @ D.T, Lz])
    L.setflags(write=False)
    return L

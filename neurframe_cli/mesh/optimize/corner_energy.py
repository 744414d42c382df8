"""Shape and size of the corners of quads and hexes as one energy, regularised so that it can untangle.

At each corner, S has the edge vectors divided by their target lengths as columns, D = det S, d its dimension and
χ(D) = (D + sqrt(D² + ε²)) / 2:

    φ = (1 - λ) tr(SᵀS) / (d χ^(2/d))  +  λ (1 + D²) / (2 χ)         (Garanzha et al. 2021, equation 2)

Both parts are 1 for the target corner and more otherwise; with ε = 0 the energy is infinite where D <= 0.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints
from neurframe_cli.mesh.quality.scaled_jacobian import SMALLEST_LENGTH


@dataclass(frozen=True)
class EnergyWeights:
    """size: λ above; power: exponent of φ in the sum, larger to favour the worst corner; epsilon: ε above."""

    size: float = 0.1
    power: float = 1.0
    epsilon: float = 0.0


class CornerEnergy:
    """Sum of φ^power / power over the corners of a mesh.

    origin (m,) vertex of each corner; neighbours (m,d) the ends of its d edges, right-handed; lengths (m,d) targets.
    """

    def __init__(self, n: int, origin: Ints, neighbours: Ints, lengths: Floats) -> None:
        from scipy.sparse import coo_matrix

        self.corners, self.dimension = neighbours.shape
        self._origin, self._ends = origin, np.ascontiguousarray(neighbours.T)
        self._inverse = np.ascontiguousarray(1.0 / lengths.T)
        edges = np.arange(neighbours.size)
        rows = np.concatenate([self._ends.ravel(), np.tile(origin, self.dimension)])
        values = np.concatenate([self._inverse.ravel(), -self._inverse.ravel()])
        # (n, d m): adds what each edge over its target length, all first ones, then all second ones, does to its ends
        self._to_ends: Any = coo_matrix(
            (values, (rows, np.concatenate([edges, edges]))), shape=(n, len(edges))
        ).tocsr()
        squares = np.asarray(self._to_ends.multiply(self._to_ends).sum(axis=1)).reshape(-1, 1)
        self.scale: Floats = 1.0 / np.maximum(squares, squares.max() * 1e-9)

    def columns(self, x: Floats, corners: Ints | None = None) -> Floats:
        """S of the `corners` (k,), or of all, as (3, d, k): coordinate, column, corner."""
        P = np.ascontiguousarray(x.T)
        if corners is None:
            origin, ends, inverse = self._origin, self._ends, self._inverse
        else:
            origin, ends, inverse = self._origin[corners], self._ends[:, corners], self._inverse[:, corners]
        S = np.take(P, ends, axis=1)
        S -= np.take(P, origin, axis=1)[:, None]
        S *= inverse
        return S

    def determinants(self, x: Floats, normals: Floats | None) -> Floats:
        """D (m,) at every corner; normals (3,m) unit, needed for quads."""
        S = self.columns(x)
        return _dot(S[:, 0], _cofactors(S, normals)[:, 0])

    def scaled_jacobians(self, x: Floats, normals: Floats | None, corners: Ints) -> Floats:
        """Scaled Jacobian (k,) at `corners` (k,) with normals (3,k): D over the product of the columns' lengths."""
        S = self.columns(x, corners)
        lengths = np.sqrt(_dot(S, S)).prod(axis=0)
        D = _dot(S[:, 0], _cofactors(S, normals)[:, 0])
        return np.asarray(D / np.maximum(lengths, SMALLEST_LENGTH))

    def evaluate(self, x: Floats, normals: Floats | None, weights: EnergyWeights) -> tuple[float, Floats]:
        """Energy and its gradient (n,3) at x (n,3); inf where a corner is inverted and ε = 0, or past float range."""
        S = self.columns(x)
        by_columns = _cofactors(S, normals)
        D = _dot(S[:, 0], by_columns[:, 0])
        nowhere = np.inf, np.zeros_like(x)
        if weights.epsilon == 0.0 and D.min() <= 0.0:
            return nowhere
        with np.errstate(over="ignore", invalid="ignore"):
            phi, by_trace, by_determinant = _density(_dot(S, S).sum(axis=0), D, self.dimension, weights)
            outer = phi ** (weights.power - 1.0) if weights.power != 1.0 else np.ones_like(phi)
            by_columns *= outer * by_determinant
            S *= 2.0 * (outer * by_trace)
            by_columns += S
            value = float((outer * phi).sum()) / weights.power
            gradient = np.stack([self._to_ends @ by_columns[c].ravel() for c in range(3)], axis=1)
        if not (np.isfinite(value) and np.isfinite(gradient).all()):
            return nowhere
        return value, gradient


def _dot(a: Floats, b: Floats) -> Floats:
    """Sum over the first of the three coordinates of a and b (3,...)."""
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


def _cross(a: Floats, b: Floats, out: Floats) -> None:
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        np.multiply(a[j], b[k], out=out[i])
        out[i] -= a[k] * b[j]


def _cofactors(S: Floats, normals: Floats | None) -> Floats:
    """Derivatives (3,d,m) of the determinants by the columns."""
    result = np.empty_like(S)
    if S.shape[1] == 2:
        assert normals is not None
        _cross(S[:, 1], normals, result[:, 0])
        _cross(normals, S[:, 0], result[:, 1])
    else:
        for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            _cross(S[:, j], S[:, k], result[:, i])
    return result


def _density(
    trace: Floats, D: Floats, dimension: int, weights: EnergyWeights
) -> tuple[Floats, Floats, Floats]:
    """φ and its derivatives by tr(SᵀS) and by D."""
    root = np.sqrt(D * D + weights.epsilon**2)
    # the second form is the same number without cancellation where D < 0
    chi = np.where(D > 0.0, (D + root) / 2, weights.epsilon**2 / (2 * (root - np.minimum(D, 0.0))))
    chi_by_D = chi / root
    root_of_chi = chi if dimension == 2 else np.square(np.cbrt(chi))  # χ^(2/d); cbrt is faster than a power
    by_trace = (1.0 - weights.size) / (dimension * root_of_chi)
    shape = by_trace * trace
    size = weights.size * (1.0 + D * D) / (2 * chi)
    by_D = weights.size * D / chi - (2.0 / dimension * shape + size) / chi * chi_by_D
    return shape + size, by_trace, by_D

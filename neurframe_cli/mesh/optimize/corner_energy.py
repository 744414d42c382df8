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
        rows = np.arange(neighbours.size)
        inverse = 1.0 / lengths.T.ravel()
        values = np.concatenate([inverse, -inverse])
        columns = np.concatenate([neighbours.T.ravel(), np.tile(origin, self.dimension)])
        # (d m, n): all first edges, then all second ones, ... each over its target length
        self._edges: Any = coo_matrix(
            (values, (np.concatenate([rows, rows]), columns)), shape=(len(rows), n)
        ).tocsr()
        self._transposed: Any = self._edges.T.tocsr()
        squares = np.asarray(self._edges.multiply(self._edges).sum(axis=0)).reshape(-1, 1)
        self.scale: Floats = 1.0 / np.maximum(squares, squares.max() * 1e-9)

    def columns(self, x: Floats) -> Floats:
        """S of every corner as (d, 3, m): column, coordinate, corner."""
        return np.ascontiguousarray(
            (self._edges @ x).reshape(self.dimension, self.corners, 3).transpose(0, 2, 1)
        )

    def determinants(self, x: Floats, normals: Floats | None) -> Floats:
        """D (m,) at every corner; normals (3,m) unit, needed for quads."""
        return _determinants(self.columns(x), normals)[0]

    def scaled_jacobians(self, x: Floats, normals: Floats | None) -> Floats:
        """Scaled Jacobian (m,) at every corner: D over the product of the lengths of the columns."""
        S = self.columns(x)
        lengths = np.sqrt(np.einsum("icm,icm->im", S, S)).prod(axis=0)
        return np.asarray(_determinants(S, normals)[0] / np.maximum(lengths, SMALLEST_LENGTH))

    def evaluate(self, x: Floats, normals: Floats | None, weights: EnergyWeights) -> tuple[float, Floats]:
        """Energy and its gradient (n,3) at x (n,3); inf where a corner is inverted and ε = 0, or past float range."""
        S = self.columns(x)
        D, cofactors = _determinants(S, normals)
        nowhere = np.inf, np.zeros_like(x)
        if weights.epsilon == 0.0 and D.min() <= 0.0:
            return nowhere
        with np.errstate(over="ignore", invalid="ignore"):
            phi, by_trace, by_determinant = _density(
                np.einsum("icm,icm->m", S, S), D, self.dimension, weights
            )
            outer = phi ** (weights.power - 1.0) if weights.power != 1.0 else np.ones_like(phi)
            by_columns = 2.0 * (outer * by_trace) * S + (outer * by_determinant) * cofactors
            value = float((outer * phi).sum()) / weights.power
        if not (np.isfinite(value) and np.isfinite(by_columns).all()):
            return nowhere
        return value, np.asarray(self._transposed @ by_columns.transpose(0, 2, 1).reshape(-1, 3))


def _cross(a: Floats, b: Floats) -> Floats:
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def _determinants(S: Floats, normals: Floats | None) -> tuple[Floats, Floats]:
    """D (m,) and its derivatives by the columns (d,3,m)."""
    if len(S) == 2:
        assert normals is not None
        cofactors = np.stack([_cross(S[1], normals), _cross(normals, S[0])])
    else:
        cofactors = np.stack([_cross(S[1], S[2]), _cross(S[2], S[0]), _cross(S[0], S[1])])
    return np.einsum("cm,cm->m", S[0], cofactors[0]), cofactors


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

"""The loss of the paper as one quadratic form E(q) = q'Aq - 2 b'q + c, on a device of choice.

The alignment terms need no 9x9 rotations: e0' R(d->z) q = a(d).q (spherical_harmonics.alignment_vector).  So A is
the scalar Laplacian of the dual graph, the same for each of the nine coefficients, plus rank-one 9x9 blocks a a' on
its diagonal, and the gradient 2 (Aq - b) is one sparse product (docs/field.md).
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch

from neurframe_cli.field.energy_terms import AlignmentTerm, EnergyTerms
from neurframe_cli.field.spherical_harmonics import ALIGNED
from neurframe_cli.mesh.arrays import Floats, Ints


@dataclass(frozen=True)
class Alignment:
    """Rank-one blocks: tets (k,), vectors (k,9), weights (k,), and the sum from terms to tets as csr (m,k).

    to_tets is None where term k belongs to tet k, as all feature terms of a mesh do: no gather, no sum.
    """

    tets: torch.Tensor
    vectors: torch.Tensor
    weights: torch.Tensor
    to_tets: torch.Tensor | None

    def product(self, x: torch.Tensor) -> torch.Tensor:
        """sum_k weights_k a_k (a_k . x) for x (m,9)."""
        at_terms = x if self.to_tets is None else x.index_select(0, self.tets)
        along = (self.vectors * at_terms).sum(dim=1) * self.weights
        return self._sum(along[:, None] * self.vectors)

    def target(self) -> torch.Tensor:
        """Its part of b: sum_k weights_k ALIGNED a_k, (m,9)."""
        return self._sum(ALIGNED * self.weights[:, None] * self.vectors)

    def _sum(self, per_term: torch.Tensor) -> torch.Tensor:
        return per_term if self.to_tets is None else self.to_tets @ per_term


@dataclass(frozen=True)
class FieldEnergy:
    """E over m tets: laplacian csr (m,m), its diagonal degree (m,), the alignments, b = target (m,9), c = constant."""

    laplacian: torch.Tensor
    degree: torch.Tensor
    boundary: Alignment
    feature: Alignment
    target: torch.Tensor
    constant: float

    def product(self, x: torch.Tensor) -> torch.Tensor:
        """A x for x (m,9)."""
        return self.laplacian @ x + self.boundary.product(x) + self.feature.product(x)

    def half_gradient(self, q: torch.Tensor) -> torch.Tensor:
        """A q - b, half the gradient of E at q (m,9)."""
        return self.product(q) - self.target

    def value(self, q: torch.Tensor) -> float:
        """E(q) of q (m,9)."""
        return float(self.value_from(q, self.half_gradient(q)))

    def value_from(self, q: torch.Tensor, half_gradient: torch.Tensor) -> torch.Tensor:
        """E(q) as a scalar tensor, where A q - b is known already."""
        return (q * (half_gradient - self.target)).sum() + self.constant


def field_energy(
    terms: EnergyTerms, *, device: str | torch.device = "cpu", dtype: torch.dtype = torch.float64
) -> FieldEnergy:
    """Assembles E with the factors of the terms in it."""
    m, factors = len(terms.points), terms.factors
    smooth_weights = factors.smooth * terms.smooth_weights
    degree = np.asarray(np.bincount(terms.dual_edges.ravel(), np.repeat(smooth_weights, 2), m), np.float64)
    to: dict[str, Any] = {"device": device, "dtype": dtype}
    boundary = _alignment(terms.boundary, factors.boundary, m, to)
    feature = _alignment(terms.feature, factors.feature, m, to)
    constant = ALIGNED**2 * float(boundary.weights.double().sum() + feature.weights.double().sum())
    return FieldEnergy(
        _laplacian(terms.dual_edges, smooth_weights, degree, to),
        torch.as_tensor(degree, **to),
        boundary,
        feature,
        boundary.target() + feature.target(),
        constant,
    )


def _laplacian(dual_edges: Ints, weights: Floats, degree: Floats, to: dict[str, Any]) -> torch.Tensor:
    m = len(degree)
    first, second = dual_edges.T
    rows = np.concatenate([first, second, np.arange(m)])
    columns = np.concatenate([second, first, np.arange(m)])
    return _sparse_rows(rows, columns, np.concatenate([-weights, -weights, degree]), (m, m), to)


def _alignment(term: AlignmentTerm, factor: float, m: int, to: dict[str, Any]) -> Alignment:
    k = len(term.tets)
    one_each = np.array_equal(term.tets, np.arange(m))
    return Alignment(
        torch.as_tensor(term.tets, dtype=torch.int64, device=to["device"]),
        torch.as_tensor(term.vectors, **to),
        torch.as_tensor(factor * term.weights, **to),
        None if one_each else _sparse_rows(term.tets, np.arange(k), np.ones(k), (m, k), to),
    )


def _sparse_rows(
    rows: Ints, columns: Ints, values: Floats, shape: tuple[int, int], to: dict[str, Any]
) -> torch.Tensor:
    """A torch csr matrix, without torch's two notes to programmers (beta state, unchecked invariants)."""
    import scipy.sparse

    matrix = scipy.sparse.csr_matrix((values, (rows, columns)), shape)
    matrix.sort_indices()
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Sparse (CSR tensor support|invariant checks)")
        return torch.sparse_csr_tensor(
            torch.as_tensor(matrix.indptr.astype(np.int64)),
            torch.as_tensor(matrix.indices.astype(np.int64)),
            torch.as_tensor(matrix.data),
            shape,
            **to,
        )

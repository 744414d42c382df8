"""What the loss of the paper (section 4.2) is made of, gathered once from a tet mesh.

Lengths are those of the normalised domain, the bounding box scaled uniformly into [-1, 1]^3.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from neurframe_cli.errors import InvalidMesh
from neurframe_cli.field.nearest_feature_edge import nearest_feature_edge
from neurframe_cli.field.spherical_harmonics import ALIGNED, alignment_vector
from neurframe_cli.mesh.arrays import Features, Floats, Ints, TetMesh
from neurframe_cli.mesh.tet_adjacency import TetAdjacency, tet_adjacency


@dataclass(frozen=True)
class LossWeights:
    """The factors of the three losses and the paper's constants sigma (1/length) and tau (length)."""

    smooth: float = 1.0
    boundary: float = 20.0
    feature: float = 1.0
    sigma: float = 10.0
    tau: float = 1e-2


@dataclass(frozen=True)
class Normalization:
    """x -> (x - center) * scale: center (3,) float64 in input units, scale in 1/input units."""

    center: Floats
    scale: float

    def apply(self, points: Floats) -> Floats:
        """Points (n,3) in input units -> normalised points (n,3)."""
        return np.asarray((points - self.center) * self.scale)


@dataclass(frozen=True)
class AlignmentTerm:
    """sum_k weights_k (ALIGNED - vectors_k . q[tets_k])^2: tets (k,), vectors (k,9) unit, weights (k,)."""

    tets: Ints
    vectors: Floats
    weights: Floats

    def loss(self, q: Floats) -> float:
        residuals = ALIGNED - np.einsum("kc,kc->k", self.vectors, q[self.tets])
        return float(self.weights @ residuals**2)


@dataclass(frozen=True)
class Losses:
    """L_S, L_B, L_F without their factors, and the weighted total (equations 3 to 6)."""

    smooth: float
    boundary: float
    feature: float
    total: float


@dataclass(frozen=True)
class EnergyTerms:
    """The loss as data.

    points (m,3): normalised centroids; dual_edges (e,2) and smooth_weights (e,) = omega / |E|; boundary and feature
    with weights 1/|B| and sigma_p/|P|.
    """

    points: Floats
    dual_edges: Ints
    smooth_weights: Floats
    boundary: AlignmentTerm
    feature: AlignmentTerm
    factors: LossWeights

    def losses(self, q: Floats) -> Losses:
        """The losses of coefficients q (m,9), term by term as the paper writes them."""
        differences = q[self.dual_edges[:, 0]] - q[self.dual_edges[:, 1]]
        smooth = float(self.smooth_weights @ np.einsum("ec,ec->e", differences, differences))
        boundary, feature = self.boundary.loss(q), self.feature.loss(q)
        factors = self.factors
        total = factors.smooth * smooth + factors.boundary * boundary + factors.feature * feature
        return Losses(smooth, boundary, feature, total)


def normalization_of(V: Floats) -> Normalization:
    """Uniform scaling of the bounding box of V (n,3) into [-1, 1]^3; raises InvalidMesh where it has no extent."""
    low, high = V.min(axis=0), V.max(axis=0)
    longest = float((high - low).max())
    if not np.isfinite(longest) or longest <= 0.0:
        raise InvalidMesh(
            f"the bounding box of the tet mesh has extent {longest}, a positive length is needed"
        )
    return Normalization((low + high) / 2.0, 2.0 / longest)


def energy_terms(
    tets: TetMesh,
    features: Features,
    factors: LossWeights,
    adjacency: TetAdjacency | None = None,
    normalization: Normalization | None = None,
) -> EnergyTerms:
    """The terms of a tet mesh; a tet with several boundary faces gets one boundary term for each."""
    normalization = normalization or normalization_of(tets.V)
    adjacency = adjacency or tet_adjacency(tets.T)
    V = normalization.apply(tets.V)
    points = V[tets.T].mean(axis=1)
    first, second = adjacency.dual_edges.T
    lengths = np.linalg.norm(points[first] - points[second], axis=1)
    smooth_weights = 1.0 / (lengths + factors.tau) / max(len(lengths), 1)
    boundary = _boundary_term(V, adjacency)
    feature = _feature_term(points, V, features.edges, factors.sigma)
    return EnergyTerms(points, adjacency.dual_edges, smooth_weights, boundary, feature, factors)


def _boundary_term(V: Floats, adjacency: TetAdjacency) -> AlignmentTerm:
    """Equation 4; faces without area have no normal and are left out."""
    corners = V[adjacency.boundary_faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1)
    used = lengths > 0.0
    vectors = alignment_vector(normals[used] / lengths[used, None])
    weights = np.full(len(vectors), 1.0 / max(len(vectors), 1))
    return AlignmentTerm(adjacency.boundary_tets[used], vectors, weights)


def _feature_term(points: Floats, V: Floats, edges: Ints, sigma: float) -> AlignmentTerm:
    """Equation 5: every centroid is drawn to the direction of its nearest feature edge."""
    used = np.linalg.norm(V[edges[:, 1]] - V[edges[:, 0]], axis=1) > 0.0 if len(edges) else np.zeros(0, bool)
    if not used.any():
        return AlignmentTerm(np.zeros(0, np.int64), np.zeros((0, 9)), np.zeros(0))
    distances, directions = nearest_feature_edge(points, V, edges[used])
    weights = np.exp(-sigma * distances) / len(points)
    return AlignmentTerm(np.arange(len(points)), alignment_vector(directions), weights)

"""The paper's energy minimised directly over one unit 9-vector per tet, without a network.

The family of Ray, Sokolov and Lévy, "Practical 3D Frame Field Generation" (2016): a relaxed linear problem, its rows
normalised, then quasi-Newton.  The minimum is what a network can at best reach at the centroids ("floor" in
docs/field.md), and the target that the preset `fast` distils.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch

from neurframe_cli.field.coarsening import coarsen
from neurframe_cli.field.energy import field_energy
from neurframe_cli.field.energy_terms import EnergyTerms
from neurframe_cli.field.frames import frame_to_band4
from neurframe_cli.field.relaxed_solver import solve_relaxed
from neurframe_cli.field.sphere_lbfgs import minimize_on_spheres, unit_rows
from neurframe_cli.mesh.arrays import Floats, Ints, Progress, silent

# below this a level is solved from the relaxed problem; above it starts from a coarser level
COARSEST_TETS = 1500


@dataclass(frozen=True)
class DiscreteField:
    """q (m,9) float64 unit rows, the energy they reach, and L-BFGS iterations and products on the finest level."""

    q: Floats
    value: float
    iterations: int
    products: int


def solve_discrete(terms: EnergyTerms, *, device: str = "cpu", progress: Progress = silent) -> DiscreteField:
    """Coarse to fine: relaxed on the coarsest level, L-BFGS on every level.  Deterministic on the CPU."""
    levels, clusters = _levels(terms)
    energy = field_energy(levels[-1], device=device)
    minimum = minimize_on_spheres(energy, _normalized(solve_relaxed(energy)))
    for level in reversed(range(len(clusters))):
        progress(1.0 / (level + 2), f"solving on {len(levels[level].points)} tets")
        start = minimum.q[torch.as_tensor(clusters[level], device=device)]
        minimum = minimize_on_spheres(field_energy(levels[level], device=device), start)
    progress(1.0, f"energy {minimum.value:.5f}")
    q = np.ascontiguousarray(minimum.q.cpu().numpy())
    return DiscreteField(q, minimum.value, minimum.iterations, minimum.products)


def _normalized(x: torch.Tensor) -> torch.Tensor:
    """Unit rows; tets that nothing speaks to (no boundary, no feature in their component) get the axes as frame."""
    q = unit_rows(x)
    q[x.norm(dim=1) < 1e-12] = torch.as_tensor(frame_to_band4(np.eye(3)), device=x.device)
    return q


def _levels(terms: EnergyTerms) -> tuple[list[EnergyTerms], list[Ints]]:
    """Finest first, and the map from each level to the next; stops where joining no longer pays."""
    levels: list[EnergyTerms] = [terms]
    clusters: list[Ints] = []
    while len(levels[-1].points) > COARSEST_TETS:
        coarse, cluster = coarsen(levels[-1])
        if len(coarse.points) > 0.7 * len(cluster) or not len(coarse.dual_edges):
            break
        levels.append(coarse)
        clusters.append(cluster)
    return levels, clusters

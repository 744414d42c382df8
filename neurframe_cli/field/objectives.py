"""What a network is trained on: the true loss on all or some of its terms, or a field to imitate.

An objective puts the gradient for one step into the network's parameters and returns the value it has.  Batches
depend on the seed and the number of the step alone, so that a resumed run repeats them.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol

import numpy as np
import torch

from neurframe_cli.field.energy import FieldEnergy, field_energy
from neurframe_cli.field.energy_terms import AlignmentTerm, EnergyTerms
from neurframe_cli.field.network import FieldNetwork, evaluate
from neurframe_cli.mesh.arrays import Floats, Ints

# points per call of the network: activations that stay in a CPU's cache, launches that fill a GPU
CHUNK = {"cpu": 4096, "cuda": 1 << 18}
# above this many points the activations are computed twice instead of kept (5 KiB a point in bfloat16)
KEPT_POINTS = 1 << 17


class Objective(Protocol):
    """One step's gradient."""

    def backpropagate(self, network: FieldNetwork, step: int) -> float:
        """Sets the gradients of all parameters for step 0, 1, 2 ... and returns the objective."""


class FullLoss:
    """The loss of the paper on all tets."""

    def __init__(self, terms: EnergyTerms, device: str) -> None:
        self.energy = field_energy(terms, device=device, dtype=torch.float32)
        self.points = torch.as_tensor(terms.points, dtype=torch.float32, device=device)

    def backpropagate(self, network: FieldNetwork, step: int) -> float:
        return backpropagate_energy(network, self.points, self.energy)


class SampledLoss:
    """An unbiased estimate of the loss: the given fraction of the terms of each kind."""

    def __init__(self, terms: EnergyTerms, fraction: float, seed: list[int], device: str) -> None:
        self.terms, self.fraction, self.seed, self.device = terms, fraction, seed, device

    def backpropagate(self, network: FieldNetwork, step: int) -> float:
        generator = np.random.default_rng([*self.seed, step])
        terms = sample_terms(self.terms, self.fraction, generator)
        energy = field_energy(terms, device=self.device, dtype=torch.float32)
        points = torch.as_tensor(terms.points, dtype=torch.float32, device=self.device)
        return backpropagate_energy(network, points, energy)


class Distillation:
    """Mean squared distance to target coefficients (m,9) at the centroids, in batches that visit all tets in turn.

    The network takes a batch chunk by chunk: on a million tets it has 90,000, whose activations would take gigabytes.
    """

    def __init__(self, points: Floats, target: Floats, batch: int, seed: list[int], device: str) -> None:
        self.points = torch.as_tensor(points, dtype=torch.float32, device=device)
        self.target = torch.as_tensor(target, dtype=torch.float32, device=device)
        self.batch, self.seed = min(batch, len(points)), seed

    def backpropagate(self, network: FieldNetwork, step: int) -> float:
        chosen = self._chosen(step)
        network.zero_grad()
        total = 0.0
        for part in torch.split(chosen, CHUNK[self.points.device.type]):
            difference = network(self.points[part]) - self.target[part]
            loss = (difference * difference).sum(dim=1).mean() * (len(part) / len(chosen))
            loss.backward()
            total += float(loss.detach())
        return total

    def _chosen(self, step: int) -> torch.Tensor:
        per_epoch = len(self.points) // self.batch
        epoch, slot = divmod(step, per_epoch)
        order = np.random.default_rng([*self.seed, epoch]).permutation(len(self.points))
        return torch.as_tensor(order[slot * self.batch : (slot + 1) * self.batch], device=self.points.device)


def backpropagate_energy(network: FieldNetwork, points: torch.Tensor, energy: FieldEnergy) -> float:
    """Gradient of E(f(points)): the network chunk by chunk, the energy once over all tets.  Returns E."""
    chunks = torch.split(points, CHUNK[points.device.type])
    network.zero_grad()
    keep = len(points) <= KEPT_POINTS
    outputs = [network(chunk) for chunk in chunks] if keep else []
    q = torch.cat([output.detach() for output in outputs]) if keep else evaluate(network, points)
    half_gradient = energy.half_gradient(q)
    upstream = torch.split(2.0 * half_gradient, CHUNK[points.device.type])
    for i, gradient in enumerate(upstream):
        output = outputs[i] if keep else network(chunks[i])
        output.backward(gradient)
    return float(energy.value_from(q, half_gradient))


def sample_terms(terms: EnergyTerms, fraction: float, generator: np.random.Generator) -> EnergyTerms:
    """A random part of the dual edges and of each alignment term, with weights that keep the expectation."""
    edges = _part(len(terms.dual_edges), fraction, generator)
    boundary = _sampled(terms.boundary, fraction, generator)
    feature = _sampled(terms.feature, fraction, generator)
    dual_edges = terms.dual_edges[edges]
    used, number = np.unique(
        np.concatenate([dual_edges.ravel(), boundary.tets, feature.tets]), return_inverse=True
    )
    cut = np.cumsum([dual_edges.size, len(boundary.tets)])
    edge_ends, boundary_tets, feature_tets = np.split(number, cut)
    return replace(
        terms,
        points=terms.points[used],
        dual_edges=edge_ends.reshape(-1, 2),
        smooth_weights=terms.smooth_weights[edges] * (len(terms.dual_edges) / max(len(edges), 1)),
        boundary=replace(boundary, tets=boundary_tets),
        feature=replace(feature, tets=feature_tets),
    )


def _part(count: int, fraction: float, generator: np.random.Generator) -> Ints:
    wanted = min(count, max(1, round(fraction * count)))
    return np.sort(generator.permutation(count)[:wanted])


def _sampled(term: AlignmentTerm, fraction: float, generator: np.random.Generator) -> AlignmentTerm:
    part = _part(len(term.tets), fraction, generator)
    larger = len(term.tets) / max(len(part), 1)
    return AlignmentTerm(term.tets[part], term.vectors[part], term.weights[part] * larger)

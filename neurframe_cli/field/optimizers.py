"""Muon for the square weight matrices, Adam for the rest, under one learning-rate schedule.

Muon: momentum whose matrix is replaced by its nearest orthogonal one, by five Newton-Schulz steps (Jordan et al.,
2024); the update is scaled by 0.2 sqrt(width) so that its entries are as large as those of Adam's (Liu et al., 2025).
Both are written out here because their state has to be saved and restored bit for bit.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch

from neurframe_cli.field.network import FieldNetwork

# coefficients of the quintic Newton-Schulz iteration with the steepest slope at zero
QUINTIC = (3.4445, -4.7750, 2.0315)
NEWTON_SCHULZ_STEPS = 5

State = dict[str, torch.Tensor]


@dataclass(frozen=True)
class Schedule:
    """Learning rate of step t of total: linear warm-up, then a half cosine to floor * peak; constant if not cosine."""

    peak: float
    total: int
    warm_up: float = 0.0
    cosine: bool = False

    def rate(self, step: int) -> float:
        """Rate at step 0, 1, 2 ..."""
        if not self.cosine:
            return self.peak
        warm = self.warm_up * self.total
        if step < warm:
            return self.peak * (step + 1) / warm
        done = min((step - warm) / max(self.total - warm, 1.0), 1.0)
        return self.peak * 0.5 * (1.0 + math.cos(math.pi * done))


class Adam:
    """Kingma and Ba (2015), algorithm 1, with bias correction and no weight decay."""

    def __init__(
        self, parameters: list[torch.nn.Parameter], betas: tuple[float, float] = (0.9, 0.999)
    ) -> None:
        self.parameters, self.betas = parameters, betas
        self.mean = [torch.zeros_like(p) for p in parameters]
        self.square = [torch.zeros_like(p) for p in parameters]
        self.steps = 0

    @torch.no_grad()
    def step(self, rate: float) -> None:
        """One step along the gradients now stored in the parameters."""
        self.steps += 1
        first, second = self.betas
        correction = math.sqrt(1.0 - second**self.steps)
        for parameter, mean, square in zip(self.parameters, self.mean, self.square, strict=True):
            gradient = _gradient(parameter)
            mean.lerp_(gradient, 1.0 - first)
            square.mul_(second).addcmul_(gradient, gradient, value=1.0 - second)
            denominator = square.sqrt().div_(correction).add_(1e-8)
            parameter.addcdiv_(mean, denominator, value=-rate / (1.0 - first**self.steps))

    def state(self) -> State:
        named = {f"mean.{i}": t for i, t in enumerate(self.mean)}
        named |= {f"square.{i}": t for i, t in enumerate(self.square)}
        return named | {"steps": torch.tensor(self.steps)}

    def restore(self, state: State) -> None:
        """Takes over a state() of an Adam with the same parameters."""
        for i in range(len(self.parameters)):
            self.mean[i].copy_(state[f"mean.{i}"])
            self.square[i].copy_(state[f"square.{i}"])
        self.steps = int(state["steps"])


class Muon:
    """Orthogonalised Nesterov momentum on square matrices."""

    def __init__(
        self,
        matrices: list[torch.Tensor],
        momentum: float = 0.95,
        product_dtype: torch.dtype = torch.float32,
    ) -> None:
        self.matrices, self.momentum, self.product_dtype = matrices, momentum, product_dtype
        self.velocity = [torch.zeros_like(m) for m in matrices]

    @torch.no_grad()
    def step(self, rate: float) -> None:
        """One step along the gradients now stored in the matrices."""
        for matrix, velocity in zip(self.matrices, self.velocity, strict=True):
            gradient = _gradient(matrix)
            velocity.lerp_(gradient, 1.0 - self.momentum)
            update = orthogonalized(gradient.lerp(velocity, self.momentum), self.product_dtype)
            matrix.add_(update, alpha=-rate * 0.2 * math.sqrt(max(matrix.shape)))

    def state(self) -> State:
        return {f"velocity.{i}": t for i, t in enumerate(self.velocity)}

    def restore(self, state: State) -> None:
        """Takes over a state() of a Muon with the same matrices."""
        for i, velocity in enumerate(self.velocity):
            velocity.copy_(state[f"velocity.{i}"])


class MuonAndAdam:
    """Muon on the square matrices of a network, Adam on the rest, at one rate."""

    def __init__(self, network: FieldNetwork) -> None:
        self.muon = Muon(network.hidden_matrices(), product_dtype=network.hidden_dtype)
        self.adam = Adam(network.other_parameters())

    def step(self, rate: float) -> None:
        self.muon.step(rate)
        self.adam.step(rate)

    def state(self) -> State:
        named = {f"muon.{name}": tensor for name, tensor in self.muon.state().items()}
        return named | {f"adam.{name}": tensor for name, tensor in self.adam.state().items()}

    def restore(self, state: State) -> None:
        for prefix, part in (("muon.", self.muon), ("adam.", self.adam)):
            part.restore(
                {name.removeprefix(prefix): t for name, t in state.items() if name.startswith(prefix)}
            )


Optimizer = Adam | MuonAndAdam


def orthogonalized(matrix: torch.Tensor, dtype: torch.dtype = torch.float32) -> torch.Tensor:
    """A matrix (n,k) with its singular values moved close to 1, all but the smallest into about 0.7 ... 1.2.

    The products run in dtype; bfloat16 is as good here, 2.7 times as fast on a CPU with AMX (docs/field.md).
    """
    a, b, c = QUINTIC
    x: torch.Tensor = (matrix / matrix.norm().clamp_min(1e-30)).to(dtype)
    for _ in range(NEWTON_SCHULZ_STEPS):
        gram = x @ x.mT
        x = torch.addmm(x, torch.addmm(gram, gram, gram, beta=b, alpha=c), x, beta=a)
    return x.to(matrix.dtype)


def _gradient(parameter: torch.Tensor) -> torch.Tensor:
    assert parameter.grad is not None, "the backward pass comes before the step"
    return parameter.grad

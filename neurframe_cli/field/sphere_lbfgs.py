"""Minimum of the energy over unit coefficients: L-BFGS in x with q = x / |x|.

Nocedal and Wright, "Numerical Optimization" (2006), algorithm 7.4, with the 9x9 block-Jacobi matrix as initial
inverse Hessian.  Of x only the direction of its rows matters, so the gradient is tangent to the spheres and the rows
are normalised after every step.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import torch

from neurframe_cli.field.block_jacobi import apply_blocks, block_jacobi
from neurframe_cli.field.energy import FieldEnergy
from neurframe_cli.mesh.arrays import Progress, silent

MEMORY = 8
# sufficient decrease and the factor of a step that failed it (Armijo)
SUFFICIENT, SHORTER, SHORTEST = 1e-4, 0.4, 1e-7


@dataclass(frozen=True)
class SphereMinimum:
    """q (m,9) with unit rows, E(q), and the numbers of iterations and of sparse products."""

    q: torch.Tensor
    value: float
    iterations: int
    products: int


@dataclass
class _History:
    """The last steps s, changes of gradient y and 1 / (s . y), oldest first."""

    pairs: list[tuple[torch.Tensor, torch.Tensor, float]] = field(default_factory=list)

    def add(self, step: torch.Tensor, change: torch.Tensor) -> None:
        along = _dot(step, change)
        if along > 1e-12 * float(step.norm()) * float(change.norm()):
            self.pairs = [*self.pairs[1 - MEMORY :], (step, change, 1.0 / along)]

    def inverse_hessian(self, blocks: torch.Tensor, gradient: torch.Tensor) -> torch.Tensor:
        """The two-loop recursion."""
        d, alphas = gradient.clone(), []
        for step, change, rho in reversed(self.pairs):
            alphas.append(rho * _dot(step, d))
            d.add_(change, alpha=-alphas[-1])
        d = apply_blocks(blocks, d).mul_(self._scale(blocks))
        for (step, change, rho), alpha in zip(self.pairs, reversed(alphas), strict=True):
            d.add_(step, alpha=alpha - rho * _dot(change, d))
        return d

    def _scale(self, blocks: torch.Tensor) -> float:
        if not self.pairs:
            return 1.0
        _, change, rho = self.pairs[-1]
        return 1.0 / (rho * _dot(change, apply_blocks(blocks, change)))


def minimize_on_spheres(
    energy: FieldEnergy,
    start: torch.Tensor,
    *,
    tolerance: float = 2e-4,
    window: int = 15,
    iterations: int = 600,
    progress: Progress = silent,
) -> SphereMinimum:
    """Minimises E from the rows of start (m,9) until `window` iterations gain less than tolerance * E.

    An energy below a rounding error of E(0) counts as zero: the field of a box is constant.
    """
    blocks, history = block_jacobi(energy), _History()
    q = unit_rows(start)
    value, gradient = _value_and_gradient(energy, q)
    values, products = [value], 1
    while len(values) <= iterations and value > 1e-13 * energy.constant:
        direction = -tangent(history.inverse_hessian(blocks, gradient), q)
        slope = _dot(direction, gradient)
        if slope >= 0.0:
            history, direction = _History(), -tangent(apply_blocks(blocks, gradient), q)
            slope = _dot(direction, gradient)
        found = _line_search(energy, q, value, direction, slope)
        products += found.products
        if found.value >= value:
            break
        history.add(found.q - q, found.gradient - gradient)
        q, value, gradient = found.q, found.value, found.gradient
        values.append(value)
        progress(len(values) / iterations, f"energy {value:.5f}")
        if len(values) > window and values[-1 - window] - value < tolerance * value:
            break
    return SphereMinimum(q, value, len(values) - 1, products)


def unit_rows(x: torch.Tensor) -> torch.Tensor:
    """x (m,9) with rows of length one."""
    return torch.nn.functional.normalize(x, dim=1, eps=1e-30)


def tangent(v: torch.Tensor, q: torch.Tensor) -> torch.Tensor:
    """Rows of v (m,9) without their parts along the unit rows of q."""
    return v - (v * q).sum(dim=1, keepdim=True) * q


@dataclass(frozen=True)
class _Found:
    q: torch.Tensor
    value: float
    gradient: torch.Tensor
    products: int


def _line_search(
    energy: FieldEnergy, q: torch.Tensor, value: float, direction: torch.Tensor, slope: float
) -> _Found:
    """The first of 1, 0.4, 0.4^2 ... with enough decrease; the last tried where rounding leaves none."""
    length, products = 1.0, 0
    while True:
        trial = unit_rows(q + length * direction)
        trial_value, gradient = _value_and_gradient(energy, trial)
        products += 1
        if trial_value <= value + SUFFICIENT * length * slope or length < SHORTEST:
            return _Found(trial, trial_value, gradient, products)
        length *= SHORTER


def _value_and_gradient(energy: FieldEnergy, q: torch.Tensor) -> tuple[float, torch.Tensor]:
    half_gradient = energy.half_gradient(q)
    return float(energy.value_from(q, half_gradient)), 2.0 * tangent(half_gradient, q)


def _dot(a: torch.Tensor, b: torch.Tensor) -> float:
    return float(torch.dot(a.view(-1), b.view(-1)))

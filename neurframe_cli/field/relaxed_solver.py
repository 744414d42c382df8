"""The minimum of the energy without the unit-length constraint: one sparse linear system."""

from __future__ import annotations

from collections.abc import Callable

import torch

from neurframe_cli.field.block_jacobi import apply_blocks, block_jacobi
from neurframe_cli.field.energy import FieldEnergy

Operator = Callable[[torch.Tensor], torch.Tensor]


def solve_relaxed(
    energy: FieldEnergy, start: torch.Tensor | None = None, *, tolerance: float = 1e-4, iterations: int = 1000
) -> torch.Tensor:
    """The x (m,9) with A x = b, by conjugate gradients with 9x9 block-Jacobi preconditioning.

    A is only semidefinite where the normals fix too little (a box); the system stays consistent, and a start of
    zero gives the solution without a part in the null space, which for the box is a true frame.
    """
    x = torch.zeros_like(energy.target) if start is None else start.clone()
    blocks = block_jacobi(energy)
    return conjugate_gradients(
        energy.product, energy.target, x, lambda r: apply_blocks(blocks, r), tolerance, iterations
    )


def conjugate_gradients(
    product: Operator,
    right: torch.Tensor,
    x: torch.Tensor,
    precondition: Operator,
    tolerance: float,
    iterations: int,
) -> torch.Tensor:
    """Solves product(x) = right from x, which is overwritten, to a relative residual in the preconditioner's norm."""
    residual = right - product(x)
    direction = lifted = precondition(residual)
    energy_norm = float((residual * lifted).sum())
    goal = tolerance**2 * float((right * precondition(right)).sum())
    for _ in range(iterations):
        if energy_norm <= goal:
            break
        image = product(direction)
        step = energy_norm / float((direction * image).sum())
        x.add_(direction, alpha=step)
        residual.add_(image, alpha=-step)
        lifted = precondition(residual)
        previous, energy_norm = energy_norm, float((residual * lifted).sum())
        direction = lifted.add(direction, alpha=energy_norm / previous)
    return x

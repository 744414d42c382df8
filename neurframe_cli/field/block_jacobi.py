"""Inverse of the 9x9 diagonal blocks of the energy's matrix, the preconditioner of every linear solve here."""

from __future__ import annotations

import torch

from neurframe_cli.field.energy import Alignment, FieldEnergy


def block_jacobi(energy: FieldEnergy, shift: float = 0.0) -> torch.Tensor:
    """Inverses (m,9,9) of the diagonal blocks of A + shift I.

    A block of a tet without neighbours is singular; a shift of 1e-9 of the largest entry keeps it invertible and is
    far below what a preconditioner needs.
    """
    blocks = torch.diag_embed((energy.degree + shift)[:, None].expand(-1, 9)).contiguous()
    for alignment in (energy.boundary, energy.feature):
        _add_outer_products(blocks, alignment)
    diagonals = blocks.diagonal(dim1=1, dim2=2)
    diagonals += 1e-9 * diagonals.max().clamp_min(1e-30)
    return torch.inverse(blocks)


def apply_blocks(blocks: torch.Tensor, x: torch.Tensor) -> torch.Tensor:
    """blocks (m,9,9) times x (m,9), row by row."""
    return torch.bmm(blocks, x[:, :, None])[:, :, 0]


def _add_outer_products(blocks: torch.Tensor, alignment: Alignment) -> None:
    vectors = alignment.vectors
    scaled = alignment.weights[:, None, None] * vectors[:, :, None] * vectors[:, None, :]
    blocks.index_add_(0, alignment.tets, scaled)

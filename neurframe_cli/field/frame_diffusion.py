"""From relaxed coefficients to a field of true frames: diffusion and projection in turn (MBO).

Merriman, Bence and Osher's scheme on the octahedral variety, as in Palmer, Bommes and Solomon, "Algebraic
Representations for Volumetric Frame Fields" (2020), section 5.2: an implicit step of the energy's gradient flow, then
the nearest frame of every tet, with shorter and shorter steps.
"""

from __future__ import annotations

import numpy as np
import torch

from neurframe_cli.field.block_jacobi import apply_blocks, block_jacobi
from neurframe_cli.field.energy import FieldEnergy, field_energy
from neurframe_cli.field.energy_terms import EnergyTerms
from neurframe_cli.field.frames import frame_to_band4, nearest_frames
from neurframe_cli.field.relaxed_solver import conjugate_gradients
from neurframe_cli.mesh.arrays import Floats, Progress, silent

# 1 / (length of a diffusion step) in units of the median degree, first and last: about 15 and 2 tets far
FIRST_STIFFNESS, LAST_STIFFNESS = 0.004, 0.25
ROUNDS = 20


def diffuse_and_project(
    terms: EnergyTerms, q: Floats, *, rounds: int = ROUNDS, device: str = "cpu", progress: Progress = silent
) -> Floats:
    """Coefficients (m,9) of frames, from unit coefficients q (m,9); deterministic on the CPU."""
    energy = field_energy(terms, device=device)
    degree = float(energy.degree.median())
    for step, stiffness in enumerate(degree * np.geomspace(FIRST_STIFFNESS, LAST_STIFFNESS, rounds)):
        progress(step / rounds, f"projecting to frames, round {step + 1} of {rounds}")
        diffused = _diffused(energy, torch.as_tensor(q, device=device), float(stiffness))
        q = frame_to_band4(nearest_frames(diffused.cpu().numpy()).frames)
    return q


def _diffused(energy: FieldEnergy, q: torch.Tensor, stiffness: float) -> torch.Tensor:
    """The minimum of E(x) + stiffness |x - q|^2."""
    blocks = block_jacobi(energy, stiffness)
    return conjugate_gradients(
        lambda x: energy.product(x).add_(x, alpha=stiffness),
        energy.target + stiffness * q,
        q.clone(),
        lambda r: apply_blocks(blocks, r),
        tolerance=1e-3,
        iterations=100,
    )

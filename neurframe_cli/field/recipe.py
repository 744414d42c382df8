"""Which rounds of training follow each other: the paper's one long round, or distillation and refinement.

A recipe is a pure function of what the finished rounds have reached, so that a resumed run takes the same turns.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True)
class Round:
    """Steps under one learning-rate schedule and a fresh optimizer.

    objective "loss" (fraction of its terms per step) or "distill" (batch tets per step); optimizer "adam" or "muon"
    (Muon on the square matrices, Adam on the rest); warm_up is a share of the steps.
    """

    objective: str
    optimizer: str
    steps: int
    peak: float
    warm_up: float = 0.0
    cosine: bool = False
    fraction: float = 1.0
    batch: int = 0


class Recipe(Protocol):
    """What to train next, and how far along that is."""

    def next_round(self, losses: list[float]) -> Round | None:
        """The next round, given the losses at the ends of the finished ones, or None when it is enough."""

    def share(self, number: int) -> tuple[float, float]:
        """From where to where in [0, 1] the progress goes in round 0, 1 ..."""


@dataclass(frozen=True)
class PaperRecipe:
    """Section 5.1: Adam at 5e-5 on the full loss for 10,000 iterations; a fraction below 1 makes minibatches."""

    iterations: int = 10_000
    learning_rate: float = 5e-5
    fraction: float = 1.0

    def next_round(self, losses: list[float]) -> Round | None:
        if losses:
            return None
        return Round("loss", "adam", self.iterations, self.learning_rate, fraction=self.fraction)

    def share(self, number: int) -> tuple[float, float]:
        return 0.0, 1.0


@dataclass(frozen=True)
class FastRecipe:
    """Distil the discrete solution, then refine on the true loss until it is within `goal` of the floor.

    The distillation leaves less than 1 % on meshes of up to 10,000 tets, 2 to 2.5 % on 40,000 (docs/field.md).
    """

    floor: float
    constant: float
    distill: Round
    goal: float = 0.018
    refine_steps: int = 15
    refine_rate: float = 1e-4
    refinements: int = 3

    def next_round(self, losses: list[float]) -> Round | None:
        if not losses:
            return self.distill
        if len(losses) > self.refinements or self._is_close(losses[-1]):
            return None
        steps = self.refine_steps * 2 ** (len(losses) - 1)
        return Round("loss", "muon", steps, self.refine_rate, warm_up=0.1, cosine=True)

    def share(self, number: int) -> tuple[float, float]:
        if number == 0:
            return 0.2, 0.8
        each = 0.2 / max(self.refinements, 1)
        return 0.8 + (number - 1) * each, 0.8 + number * each

    def _is_close(self, loss: float) -> bool:
        """Within goal of the floor; where the floor is zero (a box), far below anything visible."""
        has_floor = self.floor > 1e-6 * self.constant
        return loss <= ((1.0 + self.goal) * self.floor if has_floor else 1e-5 * self.constant)


def distillation_round(tets: int, steps: int | None, fraction: float | None, rate: float | None) -> Round:
    """400 steps that visit every tet 40 times at 8,000 tets, and both grow slowly with the mesh.

    On large meshes more visits are cheaper than refinement: at 40,000 tets ten more bring as much as 15 full steps.
    """
    size = tets / 8000.0
    steps = steps or round(min(max(400.0 * size**0.3, 200.0), 1000.0))
    epochs = 40.0 * size**0.15
    batch = round(fraction * tets) if fraction else min(max(512, round(epochs * tets / steps)), tets)
    return Round("distill", "muon", steps, rate or 4e-4, warm_up=0.03, cosine=True, batch=max(batch, 1))

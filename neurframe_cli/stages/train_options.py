"""What `neurframe train` can be told."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from neurframe_cli.errors import UsageError
from neurframe_cli.field.energy_terms import LossWeights

_CHOICES = {
    "preset": ("fast", "paper"),
    "method": ("neural", "discrete"),
    "device": ("auto", "cpu", "cuda"),
    "precision": ("auto", "fp32", "tf32", "bf16"),
}


@dataclass(frozen=True)
class TrainOptions:
    """What `neurframe train` can be told; None leaves the choice to the preset.

    preset: "fast" (discrete solution, distilled and refined) or "paper" (Adam on the loss); method: "neural" or
    "discrete" (no network); iterations: of the distillation or of Adam; batch_fraction: share of the tets or of the
    loss's terms per step; refinements: most rounds on the true loss after the distillation; time_budget_s: wall
    seconds; device: auto | cpu | cuda; precision: auto | fp32 | tf32 | bf16; project: pull the discrete solution to
    true frames; threads: of PyTorch, on the CPU; log_every: steps; checkpoint_every_s: seconds.
    """

    preset: str = "fast"
    method: str = "neural"
    iterations: int | None = None
    batch_fraction: float | None = None
    refinements: int = 3
    learning_rate: float | None = None
    time_budget_s: float | None = None
    lambda_smooth: float = 1.0
    lambda_boundary: float = 20.0
    lambda_feature: float = 1.0
    sigma: float = 10.0
    seed: int = 0
    device: str = "auto"
    precision: str = "auto"
    project: bool = False
    threads: int | None = None
    log_every: int = 10
    checkpoint_every_s: float = 10.0

    def __post_init__(self) -> None:
        for name, allowed in _CHOICES.items():
            _check(name, getattr(self, name), getattr(self, name) in allowed, "one of " + ", ".join(allowed))
        for name in ("lambda_smooth", "lambda_boundary", "lambda_feature"):
            _check(name, getattr(self, name), getattr(self, name) >= 0.0, "a number from 0 on")
        for name in ("sigma", "iterations", "learning_rate", "threads", "log_every"):
            value = getattr(self, name)
            _check(name, value, value is None or value > 0, "a positive number")
        fraction = self.batch_fraction
        _check("batch_fraction", fraction, fraction is None or 0.0 < fraction <= 1.0, "above 0 and at most 1")

    def keyed(self) -> dict[str, Any]:
        """The options that determine the result, for the key of a checkpoint; threads change the last bits only."""
        unkeyed = {"time_budget_s", "threads", "log_every", "checkpoint_every_s"}
        return {name: value for name, value in asdict(self).items() if name not in unkeyed}

    def weights(self) -> LossWeights:
        return LossWeights(self.lambda_smooth, self.lambda_boundary, self.lambda_feature, self.sigma)

    @property
    def is_paper(self) -> bool:
        """Whether a network is trained as in the paper."""
        return self.preset == "paper" and self.method == "neural"


def _check(name: str, value: object, holds: bool, expected: str) -> None:
    if not holds:
        raise UsageError(f"training option {name} is {value}, expected {expected}")

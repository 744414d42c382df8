"""About how much memory a stage takes, before it begins: too little is an answer then, not an end by the system.

The formulas are fits to the peaks that benchmarks/load.py measures (docs/robustness.md); they lie above what was seen.
"""

from __future__ import annotations

from neurframe_cli.errors import NotEnoughMemory
from neurframe_cli.mesh.arrays import Progress
from neurframe_cli.pipeline.forecast import Amount
from neurframe_cli.process.memory import free_mib, resident_now_mib

# MiB of a stage = constant + sum of rate * thousands of what the name says
_NEEDS: dict[str, dict[str, float]] = {
    "tetize": {"constant": 450.0, "tets": 4.0, "faces": 10.0},
    "train": {"constant": 400.0, "tets": 2.5, "kept_tets": 6.5},
    "discretize": {"constant": 550.0, "tets": 1.5, "faces": 2.0},
    "quad": {"constant": 450.0, "faces": 10.0, "quads": 7.0},
    "hex": {"constant": 550.0, "tets": 5.0, "hexes": 12.0},
}
_PASSED_THROUGH = {"constant": 150.0, "tets": 1.0}  # tetize of a tet mesh only checks it
_KEPT_TETS = 1 << 17  # training keeps the activations of so many tets at most (field/objectives.py)
_ADVICE = {
    "quad": "a smaller --scale",
    "hex": "a smaller --scale, or tets with a longer edge",
}


def expected_mib(stage: str, amount: Amount) -> float:
    """About the most that the stage holds, in MiB, its programs included."""
    passed_through = stage == "tetize" and not amount.is_surface
    needs = _PASSED_THROUGH if passed_through else _NEEDS[stage]
    many = {
        "tets": amount.tets,
        "kept_tets": min(amount.tets, _KEPT_TETS),
        "faces": amount.faces,
        "quads": amount.quads,
        "hexes": amount.hexes,
    }
    return needs["constant"] + sum(needs.get(name, 0.0) * count / 1000 for name, count in many.items())


def refuse_too_large(stage: str, expected: float, allowed_mib: float | None) -> None:
    """Raises NotEnoughMemory where the stage is expected to take more than it was allowed, or else than is free."""
    room = free_mib() + resident_now_mib() if allowed_mib is None else allowed_mib
    if expected > room:
        raise NotEnoughMemory(
            f"{stage} would need about {expected:.0f} MiB of memory, "
            f"{room:.0f} MiB {'are free' if allowed_mib is None else 'are allowed'}",
            hint=f"{_ADVICE.get(stage, 'tets with a longer edge (--edge-length)')}, a machine with more memory, or "
            f"--memory {expected:.0f} to try all the same",
        )


def within(progress: Progress, stage: str, allowed_mib: float | None) -> Progress:
    """The progress callback, which ends a stage that holds more than it was allowed; its programs have limits of
    their own."""
    if allowed_mib is None:
        return progress

    def checked(fraction: float, text: str) -> None:
        used = resident_now_mib()
        if used > allowed_mib:
            raise NotEnoughMemory(
                f"{stage} was stopped: it used {used:.0f} MiB, allowed are {allowed_mib:.0f} MiB",
                hint="make the problem coarser, or allow more with --memory",
            )
        progress(fraction, text)

    return checked

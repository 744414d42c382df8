"""The stages as `run` and the single commands call them: options to step, step to runner, outcome to console."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from neurframe_cli.pipeline.runner import StageOutcome, Step, run_stage
from neurframe_cli.pipeline.workspace import Workspace

if TYPE_CHECKING:
    from neurframe_cli.cli.console import Console


def tetize_stage(
    workspace: Workspace, model: Path, values: Mapping[str, Any], threads: int, console: Console, *, force: bool = False
) -> StageOutcome:
    """INPUT -> tets."""
    from neurframe_cli.pipeline.tetize_step import tetize_step
    from neurframe_cli.stages.tetize import TetizeOptions

    options = TetizeOptions(
        edge_length=values["edge_length"],
        epsilon=values["epsilon"],
        feature_angle_deg=values["feature_angle"],
        seed=values["seed"],
        timeout_s=values["timeout"],
        memory_mib=values["memory"],
    )
    return _run(workspace, tetize_step(model, values["features"], options), console, force)


def _run(workspace: Workspace, step: Step, console: Console, force: bool) -> StageOutcome:
    with console.progress(step.name) as progress:
        outcome = run_stage(workspace, step, progress, force=force)
    record = outcome.record
    if outcome.skipped:
        console.log.info("%s: unchanged, skipped", step.name)
    else:
        console.log.info("%s: done in %.1f s, peak %.0f MiB", step.name, record.seconds, record.peak_mib)
    for line in _summary(step.name, record.report):
        console.log.info("  %s", line)
    return outcome


def _summary(stage: str, report: Mapping[str, Any]) -> list[str]:
    """A stage's most telling numbers, a line each."""
    if stage == "tetize":
        return [
            f"{report['tets']} tets, {report['vertices']} vertices, {report['feature_edges']} feature edges "
            f"in {report['feature_chains']} chains"
        ]
    return []

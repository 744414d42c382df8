"""What `neurframe run` says at its end, and before it begins."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from neurframe_cli.cli.chain import Kind, mesh_kind, summary
from neurframe_cli.pipeline.manifest import StageRecord, read_manifest
from neurframe_cli.pipeline.report_step import REPORT
from neurframe_cli.pipeline.workspace import Workspace

if TYPE_CHECKING:
    from neurframe_cli.pipeline.forecast import Amount
    from neurframe_cli.pipeline.plan import PlannedStage

_ELEMENTS = {"quad": "quads", "hex": "hexes"}
_STATES = {"cached": "cached", "resume": "goes on from its checkpoint", "run": "would run"}


def result_lines(workspace: Workspace, kinds: Sequence[Kind]) -> Iterator[str]:
    """What was made of each kind, is it valid, how good is it, where is it."""
    stages = read_manifest(workspace.folder).stages
    for kind in kinds:
        if kind in stages:
            yield from _mesh_lines(workspace, kind, stages[kind])
    if (workspace / REPORT).is_file():
        yield f"report: {workspace / REPORT}"
    seconds = sum(record.seconds for record in stages.values())
    peak = max((record.peak_mib for record in stages.values()), default=0.0)
    yield f"{workspace.folder}: {seconds:.0f} s in all stages, peak {peak:,.0f} MiB"


def _mesh_lines(workspace: Workspace, kind: Kind, record: StageRecord) -> Iterator[str]:
    verdict = {"done": "valid", "invalid": "NOT VALID"}.get(record.status, "none")
    yield f"{_ELEMENTS[kind]}: {verdict}{f': {record.error}' if record.error else ''}"
    if record.status in ("done", "invalid"):
        yield from (f"  {line}" for line in summary(kind, record.report))
        files = [
            *mesh_kind(kind).outputs,
            *(name for name in mesh_kind(kind).extras if name in record.outputs),
        ]
        yield from (f"  {workspace / name}" for name in files)


def plan_lines(planned: Sequence[PlannedStage], amount: Amount, speed: float, earlier: int) -> Iterator[str]:
    """One line a stage: what would be done, about how long it takes, and about how much memory."""
    from neurframe_cli.pipeline.forecast import seconds_of
    from neurframe_cli.pipeline.memory import expected_mib

    total = 0.0
    for stage in planned:
        seconds = seconds_of(stage.name, amount, speed) if stage.state != "cached" else 0.0
        total += seconds
        about = f", about {seconds:.0f} s, {expected_mib(stage.name, amount):.0f} MiB" if seconds else ""
        yield f"{stage.name:<11}{_STATES[stage.state]}{about}"
    basis = (
        f"scaled by {earlier} earlier stages here" if earlier else "one thread; nothing was measured here yet"
    )
    yield f"{'total':<11}about {total:.0f} s for about {amount.tets:,.0f} tets ({basis})"

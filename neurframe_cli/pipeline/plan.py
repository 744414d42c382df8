"""What a run would do, without doing it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

from neurframe_cli.pipeline.runner import Step, is_unchanged
from neurframe_cli.pipeline.train_step import CHECKPOINT
from neurframe_cli.pipeline.workspace import Workspace

State = Literal["cached", "resume", "run"]


@dataclass(frozen=True)
class PlannedStage:
    """cached: nothing to do; resume: from a checkpoint; run: from its beginning."""

    name: str
    state: State


def plan(workspace: Workspace, steps: Mapping[str, Callable[[], Step]], *, force: bool) -> list[PlannedStage]:
    """The stages in their order.

    A step is made only where all before it are cached, since its inputs need not be there otherwise; what follows a
    stage that runs counts as run too, although it is skipped where the same artifacts come out again.
    """
    planned: list[PlannedStage] = []
    fresh = not force
    for name, make in steps.items():
        # quads and hexes do not depend on each other
        mesh = name in ("quad", "hex")
        cached = fresh and is_unchanged(workspace, make())
        if not cached and not mesh:
            fresh = False
        planned.append(PlannedStage(name, "cached" if cached else _begun(workspace, name, force)))
    return planned


def _begun(workspace: Workspace, name: str, force: bool) -> State:
    has_checkpoint = name == "train" and not force and (workspace / CHECKPOINT).is_file()
    return "resume" if has_checkpoint else "run"

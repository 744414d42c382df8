"""`neurframe train`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from neurframe_cli.cli.command import StageCommand
from neurframe_cli.cli.options import (
    force_option,
    memory_option,
    seed_option,
    train_options,
    workspace_option,
)

if TYPE_CHECKING:
    from neurframe_cli.cli.console import Console


@click.command(name="train", cls=StageCommand)
@workspace_option
@train_options
@memory_option()
@seed_option
@force_option
def command(workspace: Path | None, force: bool, threads: int, console: Console, **values: object) -> None:
    """Learn a smooth octahedral frame field in the tets, aligned with surface normals and feature edges.

    Reads tets.mesh and features.json, writes field.safetensors (the network) and train.jsonl (one JSON line per
    logged step).  A run that was killed goes on from its last checkpoint.
    """
    from neurframe_cli.cli.chain import run_step, train_of
    from neurframe_cli.pipeline.workspace import find_workspace

    found = find_workspace(workspace)
    run_step(found, train_of(found, values, threads, fresh=force), console, force=force)

"""`neurframe run INPUT`: the whole chain."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from neurframe_cli.cli.command import StageCommand
from neurframe_cli.cli.options import (
    discretize_options,
    force_option,
    input_argument,
    seed_option,
    tetize_options,
    train_options,
    workspace_option,
)

if TYPE_CHECKING:
    from neurframe_cli.cli.console import Console


@click.command(name="run", cls=StageCommand)
@input_argument
@workspace_option
@tetize_options
@train_options
@discretize_options
@seed_option
@force_option
def command(
    model: Path, workspace: Path | None, force: bool, threads: int, console: Console, **values: object
) -> None:
    """Run the pipeline on INPUT: tets, field, frames and crosses, with pictures.

    Stages whose inputs and options have not changed are skipped; a killed run goes on where it was.
    """
    from neurframe_cli.cli.chain import discretize_stage, tetize_stage, train_stage
    from neurframe_cli.pipeline.workspace import workspace_for_input

    found = workspace_for_input(model, workspace)
    tetize_stage(found, model, values, threads, console, force=force)
    train_stage(found, values, threads, console, force=force)
    discretize_stage(found, values, console, force=force)
    console.result(str(found.folder))

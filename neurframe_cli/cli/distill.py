"""`neurframe distill`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from neurframe_cli.cli.command import StageCommand
from neurframe_cli.cli.options import device_option, force_option, seed_option, workspace_option

if TYPE_CHECKING:
    from neurframe_cli.cli.console import Console


@click.command(name="distill", cls=StageCommand)
@workspace_option
@click.option(
    "--iterations",
    type=click.IntRange(1),
    help="Training steps.  [default: 200 to 1000, with the number of tets]",
)
@device_option
@seed_option
@force_option
def command(
    workspace: Path | None,
    iterations: int | None,
    device: str,
    seed: int,
    force: bool,
    threads: int,
    console: Console,
) -> None:
    """Train the network further until it is the field of the integer-grid map that `hex` has made.

    Reads field.safetensors and map.hexex, writes map-field.safetensors: a field to be asked anywhere, that agrees with
    the hexes and their matchings.
    """
    from neurframe_cli.cli.chain import run_step
    from neurframe_cli.pipeline.distill_step import distill_step
    from neurframe_cli.pipeline.workspace import find_workspace
    from neurframe_cli.stages.distill_map import DistillOptions

    found = find_workspace(workspace)
    options = DistillOptions(iterations, seed, device, threads)
    run_step(found, distill_step(found, options), console, force=force)

"""`neurframe streamlines`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from neurframe_cli.cli.command import StageCommand
from neurframe_cli.cli.options import continuous_options

if TYPE_CHECKING:
    from neurframe_cli.cli.console import Console


@click.command(name="streamlines", cls=StageCommand)
@continuous_options(120, "Seeds in the volume, and as many on the surface.")
def command(
    workspace: Path | None,
    samples: int,
    pictures: bool,
    seed: int,
    force: bool,
    threads: int,
    console: Console,
) -> None:
    """Trace curves along the axes of the continuous field, in the volume and on the surface (paper, appendix A.2).

    Writes streamlines.vtp and streamlines.png.
    """
    from neurframe_cli.cli.chain import run_step
    from neurframe_cli.pipeline.continuous_steps import streamlines_step
    from neurframe_cli.pipeline.workspace import find_workspace
    from neurframe_cli.stages.streamlines import StreamlineOptions

    found = find_workspace(workspace)
    step = streamlines_step(found, StreamlineOptions(samples=samples, seed=seed), pictures=pictures)
    run_step(found, step, console, force=force)

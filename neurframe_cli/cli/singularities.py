"""`neurframe singularities`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from neurframe_cli.cli.command import StageCommand
from neurframe_cli.cli.options import continuous_options

if TYPE_CHECKING:
    from neurframe_cli.cli.console import Console


@click.command(name="singularities", cls=StageCommand)
@continuous_options(2000, "Random triangles that the search begins with.")
def command(
    workspace: Path | None,
    samples: int,
    pictures: bool,
    seed: int,
    force: bool,
    threads: int,
    console: Console,
) -> None:
    """Sample the singular graph of the continuous field (paper, appendix A.1).

    Writes singularities.vtp and singularities.png.
    """
    from neurframe_cli.cli.chain import run_step
    from neurframe_cli.pipeline.continuous_steps import singularities_step
    from neurframe_cli.pipeline.workspace import find_workspace
    from neurframe_cli.stages.singularities import SingularitiesOptions

    found = find_workspace(workspace)
    step = singularities_step(found, SingularitiesOptions(samples=samples, seed=seed), pictures=pictures)
    run_step(found, step, console, force=force)

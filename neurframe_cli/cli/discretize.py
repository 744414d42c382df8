"""`neurframe discretize`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from neurframe_cli.cli.command import StageCommand
from neurframe_cli.cli.options import discretize_options, force_option, memory_option, workspace_option

if TYPE_CHECKING:
    from neurframe_cli.cli.console import Console


@click.command(name="discretize", cls=StageCommand)
@workspace_option
@discretize_options
@click.option(
    "--points",
    type=click.Path(path_type=Path),
    help="Ask the field at these points instead (text with x y z a line, or .npy); writes points.npz.",
)
@memory_option()
@force_option
def command(
    workspace: Path | None, points: Path | None, force: bool, threads: int, console: Console, **values: object
) -> None:
    """Query the field: frames at tet centroids, crosses at triangle centroids, singular edges, pictures.

    Writes tets.fra, frames.npz, cross.npz, cross.vtp, singular_edges.vtp and PNG pictures.
    """
    from neurframe_cli.cli.chain import discretize_of, points_stage, run_step
    from neurframe_cli.pipeline.workspace import find_workspace

    found = find_workspace(workspace)
    if points is not None:
        points_stage(found, points, console, force=force)
    else:
        run_step(found, discretize_of(found, values), console, force=force)

"""`neurframe tetize INPUT`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from neurframe_cli.cli.command import StageCommand
from neurframe_cli.cli.options import (
    feature_angle_option,
    force_option,
    input_argument,
    limit_options,
    seed_option,
    tetize_options,
    workspace_option,
)

if TYPE_CHECKING:
    from neurframe_cli.cli.console import Console


@click.command(name="tetize", cls=StageCommand)
@input_argument
@workspace_option
@tetize_options("--edge-length")
@feature_angle_option
@limit_options(600.0, "the tetrahedral meshing")
@seed_option
@force_option
def command(
    model: Path, workspace: Path | None, force: bool, threads: int, console: Console, **values: object
) -> None:
    """Fill a surface with tetrahedra (fTetWild), or take a tet mesh as it is.

    INPUT is a surface (STL, OBJ, PLY, OFF, 3MF, GLB; STEP with the extra `step`) or a tet mesh (MEDIT, VTK, VTU, MSH,
    OVM).  Writes surface.ply, tets.mesh and features.json to the workspace.
    """
    from neurframe_cli.cli.chain import run_step, tetize_of
    from neurframe_cli.pipeline.workspace import workspace_for_input

    run_step(workspace_for_input(model, workspace), tetize_of(model, values), console, force=force)

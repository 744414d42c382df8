"""`neurframe hex`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from neurframe_cli.cli.command import StageCommand
from neurframe_cli.cli.options import force_option, hex_options, mesh_options, workspace_option

if TYPE_CHECKING:
    from neurframe_cli.cli.console import Console


@click.command(name="hex", cls=StageCommand)
@workspace_option
@mesh_options("--target-cells", "hexes")
@hex_options
@force_option
def command(workspace: Path | None, force: bool, threads: int, console: Console, **values: Any) -> None:
    """Parametrise the tets along the frames (CubeCover), extract the hexes (HexEx), smooth and check them.

    Writes map.hexex (the integer-grid map), hex.vtk and hex.mesh; exit code 4 where the hexes are not valid.
    Where no map gives valid ones they are those of a regular grid, and a warning says so, unless --no-grid.
    With --fill filled.vtu and filled.msh then hold them with pyramids and tets in place of what is missing or bad.
    """
    from neurframe_cli.cli.chain import mesh_request, mesh_stage
    from neurframe_cli.pipeline.workspace import find_workspace

    request = mesh_request(["hex"], values, threads)["hex"]
    mesh_stage("hex", find_workspace(workspace), request, values["output"], console, force=force)

"""`neurframe quad`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from neurframe_cli.cli.command import StageCommand
from neurframe_cli.cli.options import force_option, mesh_options, quad_options, workspace_option

if TYPE_CHECKING:
    from neurframe_cli.cli.console import Console


@click.command(name="quad", cls=StageCommand)
@workspace_option
@mesh_options("--target-faces", "quads")
@quad_options
@click.option(
    "--surface",
    "surface_file",
    type=click.Path(path_type=Path),
    help="Put the quads on the surface in this file; it may be open.  [default: the surface of the workspace]",
)
@force_option
def command(workspace: Path | None, force: bool, threads: int, console: Console, **values: Any) -> None:
    """Parametrise the surface along the crosses (MIQ), extract the quads (QEx), smooth and check them.

    Writes map.obj (the integer-grid uv map) and quad.obj; exit code 4 where the quads are not valid.  With --surface
    and --field surface no other stage need have run.
    """
    from neurframe_cli.cli.chain import mesh_request, mesh_stage
    from neurframe_cli.pipeline.workspace import find_workspace, workspace_for_input

    request = mesh_request(["quad"], values, threads)["quad"]
    model, alone = values["surface_file"], values["field"] == "surface"
    found = workspace_for_input(model, workspace) if model and alone else find_workspace(workspace)
    mesh_stage("quad", found, request, values["output"], console, force=force)

"""`neurframe view`: a workspace or a mesh in the browser, served on this machine only."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from neurframe_cli.cli.command import StageCommand
from neurframe_cli.cli.options import workspace_option
from neurframe_cli.errors import UsageError

if TYPE_CHECKING:
    from neurframe_cli.cli.console import Console


@click.command(name="view", cls=StageCommand)
@click.argument("mesh", type=click.Path(path_type=Path), required=False)
@workspace_option
@click.option(
    "--browser/--no-browser", default=True, show_default=True, help="Open the page, or only say where it is."
)
@click.option(
    "--port", type=click.IntRange(0, 65535), default=0, show_default=True, help="0: any that is free."
)
def command(
    mesh: Path | None, workspace: Path | None, browser: bool, port: int, threads: int, console: Console
) -> None:
    """Show the report of a workspace, or one MESH (surface, tets, quads or hexes), in the browser.

    The page is served on this machine only, until Ctrl-C.
    """
    from neurframe_cli.pipeline.serve import serve_page

    if mesh is not None and workspace is not None:
        raise UsageError("MESH and -w are two things to view", hint="leave one of them out")
    page = _mesh_page(mesh) if mesh is not None else _workspace_page(workspace)

    def ready(address: str) -> None:
        console.result(address)
        if browser:
            import webbrowser

            if not webbrowser.open(address):
                console.log.warning("no browser was found: open that address yourself")
        console.log.info("Ctrl-C ends it")

    serve_page(page, port, ready)


def _workspace_page(workspace: Path | None) -> str:
    from neurframe_cli.pipeline.report_step import report_page
    from neurframe_cli.pipeline.workspace import find_workspace

    return report_page(find_workspace(workspace))[0]


def _mesh_page(mesh: Path) -> str:
    from neurframe_cli.pipeline.mesh_view import mesh_page
    from neurframe_cli.report.vtkjs import INSTALL_HINT, viewer_script

    if viewer_script() is None:
        raise UsageError("the 3D view needs vtk.js, which is not installed", hint=INSTALL_HINT)
    return mesh_page(mesh)

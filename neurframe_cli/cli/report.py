"""`neurframe report`: what happened in a workspace, as one HTML file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from neurframe_cli.cli.command import StageCommand
from neurframe_cli.cli.options import workspace_option
from neurframe_cli.errors import UsageError

if TYPE_CHECKING:
    from neurframe_cli.cli.console import Console


@click.command(name="report", cls=StageCommand)
@workspace_option
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    metavar="FILE.html",
    help="The HTML file.  [default: report.html in the workspace]",
)
def command(workspace: Path | None, output: Path | None, threads: int, console: Console) -> None:
    """Write what happened in a workspace as one HTML file that needs no network, with every number as JSON beside it.

    The interactive 3D view is part of it where the extra `report` is installed: pip install 'neurframe[report]'.
    """
    from neurframe_cli.pipeline.report_step import write_report
    from neurframe_cli.pipeline.workspace import find_workspace
    from neurframe_cli.report.vtkjs import INSTALL_HINT, viewer_script

    if output is not None and output.suffix.lower() not in (".html", ".htm"):
        raise UsageError(f"{output}: the report is HTML", hint=f"-o {output.with_suffix('.html')}")
    written = write_report(find_workspace(workspace).folder, output)
    if viewer_script() is None:
        console.log.warning("the report has no interactive 3D view; for one: %s", INSTALL_HINT)
    console.result(str(written))

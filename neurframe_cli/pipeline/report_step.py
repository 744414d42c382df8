"""report.html and report.json of a workspace, and the summary of a batch."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from neurframe_cli.pipeline.atomic import atomic_path, write_json
from neurframe_cli.pipeline.report_document import report_document
from neurframe_cli.pipeline.report_pictures import report_pictures
from neurframe_cli.pipeline.report_scene import workspace_scene
from neurframe_cli.pipeline.workspace import Workspace

REPORT = "report.html"


def write_report(workspace_folder: Path, path: Path | None = None) -> Path:
    """Writes the report of a workspace as one HTML file, and its numbers as .json beside it; returns the HTML's path.

    path: where to, report.html in the workspace by default.  The 3D view is part of it where trame-vtk (extra
    `report`) is installed.  What is damaged or missing in the workspace is left out and listed under the report's
    warnings.  Raises UsageError where nothing has been done in the workspace, StageError where a file cannot be
    written.
    """
    workspace = Workspace(workspace_folder)
    target = workspace / REPORT if path is None else path
    page, document = report_page(workspace)
    with atomic_path(target) as temporary:
        temporary.write_text(page, encoding="utf-8", errors="backslashreplace")
    write_json(target.with_suffix(".json"), document)
    return target


def report_page(workspace: Workspace) -> tuple[str, dict[str, Any]]:
    """The HTML of a workspace's report, and its document."""
    from neurframe_cli.report.page import render_report

    document, meshes = report_document(workspace)
    pictures = report_pictures(workspace, document)
    scene = workspace_scene(workspace, document, meshes)
    return render_report(document, pictures, scene), document


def write_summary(rows: Sequence[Mapping[str, Any]], path: Path, *, title: str = "Batch") -> Path:
    """Writes a table of a batch as one HTML file, with a line for each of `rows`; returns its path.

    A row is a JSON object.  Its entries are the columns, in the order in which they first come up, those of nested
    objects with their names joined.  Entries with a meaning of their own: `outcome` (or `status`) is shown as a
    coloured badge and counted at the top, `report` is the path of a report.html, relative to `path`, and becomes a
    link.
    """
    from neurframe_cli.report.page import render_summary

    with atomic_path(path) as temporary:
        temporary.write_text(render_summary(rows, title), encoding="utf-8", errors="backslashreplace")
    return path

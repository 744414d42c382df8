"""Pages from their templates: one HTML file each, with everything in it."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from markupsafe import Markup

from neurframe_cli import __version__
from neurframe_cli.picture.mesh_pictures import QUALITY_RAMP
from neurframe_cli.report import words
from neurframe_cli.report.figures import loss_figure, quality_figures
from neurframe_cli.report.vtkjs import INSTALL_HINT, viewer_license, viewer_script

_FIRST_COLUMNS = ("model", "outcome", "status", "report")
_NAMES = {"quad": "Quads", "hex": "Hexes"}


@dataclass(frozen=True)
class Picture:
    """A picture of the page: file name, stage that drew it, what it shows, address with all of it."""

    name: str
    stage: str
    caption: str
    uri: str


def render_report(
    document: Mapping[str, Any], pictures: Sequence[Picture], scene: Mapping[str, Any] | None
) -> str:
    """The page of one workspace: `document` as report_document makes it, `scene` as scene_document."""
    return _render(
        "report.html.j2",
        title=document["workspace"],
        document=document,
        names=_NAMES,
        longest=max(stage["seconds"] for stage in document["stages"].values()) or 1.0,
        pictures=pictures,
        loss=loss_figure(document["training"]),
        histograms=quality_figures(document["meshes"]),
        **_view(scene),
    )


def render_mesh(title: str, facts: Mapping[str, Any], figure: Markup, scene: Mapping[str, Any] | None) -> str:
    """The page of one mesh file: a few numbers, a chart, and the 3D view."""
    return _render("mesh.html.j2", title=title, facts=facts, figure=figure, **_view(scene))


def render_summary(rows: Sequence[Mapping[str, Any]], title: str) -> str:
    """The page of a batch, a line for each row; the columns are those that the rows have, nested ones joined."""
    flat = [words.flat(row) for row in rows]
    columns = sorted(
        dict.fromkeys(name for row in flat for name in row), key=lambda name: name not in _FIRST_COLUMNS
    )
    outcome = next((name for name in ("outcome", "status") if name in columns), None)
    return _render(
        "summary.html.j2",
        title=title,
        rows=flat,
        columns=columns,
        numeric=[name for name in columns if words.all_numbers(row.get(name) for row in flat)],
        outcome_column=outcome,
        counts=words.count(row.get(outcome) for row in flat) if outcome else {},
        document=list(rows),
    )


def _view(scene: Mapping[str, Any] | None) -> dict[str, Any]:
    """The 3D view with vtk.js, where it is installed."""
    script = viewer_script()
    ramp = ", ".join(f"{color} {100 * quality:g}%" for quality, color in QUALITY_RAMP)
    return {
        "scene": scene,
        "vtkjs": None if script is None else Markup(script),
        "vtkjs_license": viewer_license(),
        "install": INSTALL_HINT,
        "ramp": ramp,
    }


def _render(template: str, **values: Any) -> str:
    from jinja2 import ChainableUndefined, Environment, PackageLoader

    environment = Environment(
        loader=PackageLoader("neurframe_cli.report"),
        autoescape=True,
        # the report of a stage that failed, or of another version, has fewer entries
        undefined=ChainableUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {
        "number": words.number,
        "place": words.place,
        "duration": words.duration,
        "flat": words.flat,
        "tone": words.tone,
        "local_link": words.local_link,
        "embedded": _embedded,
    }
    return environment.get_template(template).render(version=__version__, **values)


def _embedded(value: Any) -> Markup:
    """JSON that can stand inside a script element: nothing in it ends that element."""
    text = json.dumps(value, allow_nan=False)
    return Markup(text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026"))

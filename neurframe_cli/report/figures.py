"""The charts of a report from the numbers of its document."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from markupsafe import Markup

from neurframe_cli.picture.mesh_pictures import quality_colors
from neurframe_cli.report.chart import Series, curve_chart, histogram_chart

_OBJECTIVES = {"distill": "distance to the discrete field (distillation)", "loss": "the field's loss"}


def loss_figure(training: Sequence[Mapping[str, Any]]) -> Markup:
    """The objective over the seconds of training, one curve for each round; empty where nothing was trained."""
    curves: dict[str, list[tuple[float, float]]] = {}
    for record in training:
        if record.get("event") == "step":
            kind = str(record.get("objective"))
            name = f"round {record.get('round')}: {_OBJECTIVES.get(kind, kind)}"
            curves.setdefault(name, []).append((float(record["seconds"]), float(record["value"])))
    return curve_chart([Series(name, points) for name, points in curves.items()], "seconds", "objective")


def quality_figures(meshes: Mapping[str, Mapping[str, Any]]) -> dict[str, Markup]:
    """Histogram of the scaled Jacobian of each mesh, by kind."""
    return {kind: quality_figure(mesh["histogram"], kind) for kind, mesh in meshes.items()}


def quality_figure(histogram: Mapping[str, Any], kind: str) -> Markup:
    """Bars in the colours that the pictures give the cells."""
    name = "hexes" if kind == "hex" else "quads"
    return histogram_chart(
        histogram["edges"], histogram["counts"], _color, "worst scaled Jacobian of a cell", name
    )


def _color(quality: float) -> str:
    return "#{:02x}{:02x}{:02x}".format(*quality_colors(np.array([quality]))[0])

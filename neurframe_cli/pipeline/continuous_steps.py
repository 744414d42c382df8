"""singularities and streamlines on files: the continuous field itself, beyond any mesh (paper, appendix)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, replace
from typing import Any

import numpy as np

from neurframe_cli.field.field_file import Field, read_field
from neurframe_cli.mesh.features import read_features
from neurframe_cli.mesh.read_surface import read_surface
from neurframe_cli.mesh.read_tets import read_medit
from neurframe_cli.picture.field_data import FieldData
from neurframe_cli.picture.vtp import write_singular_points_vtp, write_streamlines_vtp
from neurframe_cli.pipeline.atomic import atomic_path
from neurframe_cli.pipeline.pictures import draw_or_warn
from neurframe_cli.pipeline.runner import StageContext, Step
from neurframe_cli.pipeline.tetize_step import FEATURES, SURFACE, TETS
from neurframe_cli.pipeline.train_step import FIELD
from neurframe_cli.pipeline.workspace import Workspace
from neurframe_cli.stages.singularities import SingularitiesOptions, find_singularities
from neurframe_cli.stages.streamlines import StreamlineOptions, trace_streamlines

# sample(context, field, mesh) writes NAME.vtp and returns the report and what the picture shows
Sample = Callable[[StageContext, Field, FieldData], tuple[dict[str, Any], dict[str, Any]]]


def singularities_step(workspace: Workspace, options: SingularitiesOptions, *, pictures: bool) -> Step:
    """Points of the singular graph -> singularities.vtp, singularities.png."""

    def sample(context: StageContext, field: Field, mesh: FieldData) -> tuple[dict[str, Any], dict[str, Any]]:
        found = find_singularities(field.query, mesh.tets, options, context.progress)
        with atomic_path(context.workspace / "singularities.vtp") as path:
            write_singular_points_vtp(path, found.points, found.quarters, found.turn, found.axis)
        return {"points": len(found.points)}, {
            "singular_points": found.points,
            "point_quarters": found.quarters,
        }

    return _step("singularities", workspace, asdict(options), sample, pictures)


def streamlines_step(workspace: Workspace, options: StreamlineOptions, *, pictures: bool) -> Step:
    """Curves along the axes of the field -> streamlines.vtp, streamlines.png."""

    def sample(context: StageContext, field: Field, mesh: FieldData) -> tuple[dict[str, Any], dict[str, Any]]:
        found = trace_streamlines(field.query, mesh.tets, mesh.surface, options, context.progress)
        with atomic_path(context.workspace / "streamlines.vtp") as path:
            write_streamlines_vtp(path, found.volume, found.surface)
        curves = [*found.volume, *found.surface]
        offsets = np.cumsum([0, *map(len, curves)]).astype(np.int64)
        shown = {
            "streamline_points": np.concatenate([np.zeros((0, 3)), *curves]),
            "streamline_offsets": offsets,
        }
        return {"volume": len(found.volume), "surface": len(found.surface)}, shown

    return _step("streamlines", workspace, asdict(options), sample, pictures)


def _step(name: str, workspace: Workspace, options: dict[str, Any], sample: Sample, pictures: bool) -> Step:
    inputs = {file: workspace.require(file, "tetize INPUT") for file in (SURFACE, TETS, FEATURES)}
    inputs[FIELD] = workspace.require(FIELD, "train")

    def work(context: StageContext) -> dict[str, Any]:
        tets = read_medit(inputs[TETS])[0]
        features = read_features(inputs[FEATURES], len(tets.V))
        mesh = FieldData(read_surface(inputs[SURFACE]), tets, features.edges)
        report, shown = sample(context, read_field(inputs[FIELD]), mesh)
        if pictures:
            draw_or_warn(context, {name: f"{name}.png"}, replace(mesh, **shown))
        return report

    outputs = (f"{name}.vtp", f"{name}.png")
    keyed = {**options, "pictures": pictures}
    return Step(name, 1, inputs, outputs, keyed, work, packages=("torch", "numpy", "pyvista"))

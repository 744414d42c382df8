"""discretize on files: field.safetensors -> tets.fra, frames.npz, cross.npz, .vtp twins, pictures."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from neurframe_cli.field.field_file import read_field
from neurframe_cli.field.fra import write_fra
from neurframe_cli.mesh.arrays import Features, Surface, TetMesh
from neurframe_cli.mesh.features import read_features
from neurframe_cli.mesh.read_surface import read_surface
from neurframe_cli.mesh.read_tets import read_medit
from neurframe_cli.picture.field_data import FieldData
from neurframe_cli.picture.vtp import write_crosses_vtp, write_singular_edges_vtp
from neurframe_cli.pipeline.atomic import atomic_path
from neurframe_cli.pipeline.forecast import Amount
from neurframe_cli.pipeline.pictures import draw_or_warn
from neurframe_cli.pipeline.runner import StageContext, Step
from neurframe_cli.pipeline.tetize_step import FEATURES, SURFACE, TETS
from neurframe_cli.pipeline.train_step import FIELD
from neurframe_cli.pipeline.workspace import Workspace
from neurframe_cli.stages.cross_surface import Choice, choose_cross_surface
from neurframe_cli.stages.discretize import Discretization, discretize, sample_frames

FRAMES_FRA, FRAMES, CROSSES, CROSSES_VTP = "tets.fra", "frames.npz", "cross.npz", "cross.vtp"
SINGULAR_EDGES = "singular_edges.vtp"
PICTURES = {
    "crosses": "field-crosses.png",
    "singular": "field-singular.png",
    "frames": "field-frames.png",
    "tets": "tets.png",
}
POINTS = "points.npz"


def discretize_step(
    workspace: Workspace, choice: Choice, *, pictures: bool = True, memory_mib: float | None = None
) -> Step:
    """The stage bound to its files; `choice` of the surface that carries the crosses; memory_mib: see Step."""
    inputs = {name: workspace.require(name, "tetize INPUT") for name in (SURFACE, TETS, FEATURES)}
    inputs[FIELD] = workspace.require(FIELD, "train")

    def work(context: StageContext) -> dict[str, Any]:
        tets = read_medit(inputs[TETS])[0]
        features = read_features(inputs[FEATURES], len(tets.V))
        surface, reason = choose_cross_surface(read_surface(inputs[SURFACE]), tets, choice)
        context.expect("discretize", Amount(len(tets.T), len(surface.F)))
        field = read_field(inputs[FIELD])
        found = discretize(
            field.query, tets, surface, features, progress=lambda x, text: context.progress(0.8 * x, text)
        )
        _write(context, found, tets, surface)
        if pictures:
            context.progress(0.8, "pictures")
            draw_or_warn(context, PICTURES, _picture_data(found, tets, surface, features))
        return {**found.summary(), "surface": reason}

    return Step(
        name="discretize",
        version=2,
        inputs=inputs,
        outputs=(FRAMES_FRA, FRAMES, CROSSES, CROSSES_VTP, SINGULAR_EDGES, *PICTURES.values()),
        options={"surface": choice, "pictures": pictures},
        unkeyed_options={"memory_mib": memory_mib},
        work=work,
        packages=("torch", "numpy", "pyvista"),
        memory_mib=memory_mib,
    )


def _write(context: StageContext, found: Discretization, tets: TetMesh, surface: Surface) -> None:
    workspace = context.workspace
    with atomic_path(workspace / FRAMES_FRA) as path:
        write_fra(path, found.tets.frames)
    _save(
        workspace / FRAMES,
        coefficients=found.tets.coefficients,
        frames=found.tets.frames,
        distance=found.tets.distance,
    )
    _save(workspace / CROSSES, V=surface.V, F=surface.F, crosses=found.crosses)
    with atomic_path(workspace / CROSSES_VTP) as path:
        write_crosses_vtp(path, surface, found.crosses)
    with atomic_path(workspace / SINGULAR_EDGES) as path:
        write_singular_edges_vtp(path, tets.V, found.singular)


def _save(path: Path, **arrays: Any) -> None:
    with atomic_path(path) as temporary:
        np.savez(temporary, **arrays)


def _picture_data(found: Discretization, tets: TetMesh, surface: Surface, features: Features) -> FieldData:
    return FieldData(
        surface,
        tets,
        features.edges,
        crosses=found.crosses,
        frames=found.tets.frames,
        singular_edges=found.singular.edges,
        quarters=found.singular.quarters,
    )


def points_step(workspace: Workspace, points_file: Path) -> Step:
    """The field at the points of a file (.npy, or text with three numbers a line) -> points.npz."""
    from neurframe_cli.mesh.read_points import read_points

    field = workspace.require(FIELD, "train")
    points = read_points(points_file)

    def work(context: StageContext) -> dict[str, Any]:
        found = sample_frames(read_field(field).query, points, progress=context.progress)
        _save(
            context.workspace / POINTS,
            points=points,
            coefficients=found.coefficients,
            frames=found.frames,
            distance=found.distance,
        )
        return {"points": len(points), "unconverged_projections": int((~found.converged).sum())}

    return Step(
        "points", 1, {FIELD: field, "points": points_file}, (POINTS,), {}, work, packages=("torch", "numpy")
    )

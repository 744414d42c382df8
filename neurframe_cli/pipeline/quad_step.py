"""quad on files: cross.npz -> map.obj -> quad.obj."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path

import numpy as np

from neurframe_cli.errors import UnreadableFile
from neurframe_cli.mesh.arrays import Floats, Surface
from neurframe_cli.mesh.check_tets import check_indices
from neurframe_cli.mesh.open_file import check_file, foreign_reader
from neurframe_cli.mesh.optimize.smooth import SmoothOptions
from neurframe_cli.mesh.read_cells import CellMesh
from neurframe_cli.mesh.read_surface import read_surface
from neurframe_cli.mesh.write_mesh import write_surface
from neurframe_cli.pipeline.atomic import atomic_path, scratch_folder
from neurframe_cli.pipeline.discretize_step import CROSSES
from neurframe_cli.pipeline.mesh_step import MadeMesh, MeshKind, MeshRequest, Model, extract, mesh_step, part
from neurframe_cli.pipeline.native import ProgramResult, run_program
from neurframe_cli.pipeline.runner import StageContext, Step
from neurframe_cli.pipeline.tetize_step import SURFACE
from neurframe_cli.pipeline.workspace import Workspace
from neurframe_cli.stages.smooth_quads import smooth_quads


def quad_step(workspace: Workspace, request: MeshRequest) -> Step:
    """The stage bound to its files (paper, section 5.1.1)."""
    inputs = {
        SURFACE: workspace.require(SURFACE, "tetize INPUT"),
        CROSSES: workspace.require(CROSSES, "discretize"),
    }
    return mesh_step(QUAD, inputs, request, lambda: read_surface(inputs[SURFACE]), {})


def read_crosses(path: Path) -> tuple[Surface, Floats]:
    """The surface and its crosses (m,2,3) from cross.npz; raises UnreadableFile or InvalidMesh."""
    check_file(path)
    # numpy leaves a file open that it opened itself and cannot read
    with foreign_reader(path, "numpy"), path.open("rb") as file, np.load(file, allow_pickle=False) as stored:
        V, F, crosses = (stored[name] for name in ("V", "F", "crosses"))
        V, F, crosses = V.astype(np.float64), F.astype(np.int64), crosses.astype(np.float64)
    if V.shape[1:] != (3,) or F.shape[1:] != (3,) or crosses.shape != (len(F), 2, 3):
        raise UnreadableFile(
            f"{path}: {V.shape} positions, {F.shape} triangles, {crosses.shape} crosses do not fit together",
            hint="neurframe discretize --force makes the file again",
        )
    check_indices(V, F, path, "triangle")
    return Surface(V, F), crosses


def _make(context: StageContext, inputs: Mapping[str, Path], model: Model, request: MeshRequest) -> MadeMesh:
    """Parametrize, extract, smooth."""
    carrier, crosses = read_crosses(inputs[CROSSES])
    parametrization = _parametrize(context, carrier, crosses, model, request)
    extraction, raw = extract(
        QUAD, context, request.limits, parametrization, part(context.progress, 0.5, 0.7)
    )
    progress = part(context.progress, 0.7, 0.9)
    smoothed = smooth_quads(raw.V, raw.cells, model.surface, model.features, SmoothOptions(), progress)
    cells = CellMesh(raw.kind, smoothed.V, raw.cells)
    return MadeMesh(cells, parametrization, extraction, {"smoothing": asdict(smoothed.report)})


def _parametrize(
    context: StageContext, carrier: Surface, crosses: Floats, model: Model, request: MeshRequest
) -> ProgramResult:
    size = request.size.arguments(model.surface, "--target-faces")
    size += ["--feature-angle", repr(request.feature_angle_deg)]
    with scratch_folder(context.workspace.folder) as scratch:
        files = scratch / "surface.obj", scratch / "crosses.txt"
        write_surface(files[0], carrier)
        np.savetxt(files[1], crosses.reshape(-1, 6), fmt="%.17g")
        with atomic_path(context.workspace / QUAD.map_name) as path:
            arguments: list[str | Path] = [*files, "-o", path, *size]
            return run_program("miq", arguments, request.limits, part(context.progress, 0.0, 0.5))


QUAD = MeshKind(
    name="quad",
    map_name="map.obj",
    outputs=("quad.obj",),
    extractor="qex",
    pictures={"quads": "quad.png"},
    make=_make,
)

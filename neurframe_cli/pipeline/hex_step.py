"""hex on files: tets.mesh, tets.fra -> map.hexex -> hex.vtk, hex.mesh."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path

from neurframe_cli.field.fra import frame_count
from neurframe_cli.mesh.optimize.smooth import SmoothOptions
from neurframe_cli.mesh.read_cells import CellMesh
from neurframe_cli.mesh.read_surface import read_surface
from neurframe_cli.pipeline.atomic import atomic_path
from neurframe_cli.pipeline.discretize_step import FRAMES_FRA
from neurframe_cli.pipeline.forecast import Amount, expected_hexes
from neurframe_cli.pipeline.mesh_step import MadeMesh, MeshKind, MeshRequest, Model, extract, mesh_step, part
from neurframe_cli.pipeline.native import run_program
from neurframe_cli.pipeline.runner import StageContext, Step
from neurframe_cli.pipeline.tetize_step import FEATURES, SURFACE, TETS
from neurframe_cli.pipeline.workspace import Workspace
from neurframe_cli.stages.smooth_hexes import smooth_hexes


def hex_step(workspace: Workspace, request: MeshRequest) -> Step:
    """The stage bound to its files (paper, section 5.1.2)."""
    inputs = {name: workspace.require(name, "tetize INPUT") for name in (SURFACE, TETS, FEATURES)}
    inputs[FRAMES_FRA] = workspace.require(FRAMES_FRA, "discretize")
    return mesh_step(HEX, inputs, request, lambda: read_surface(inputs[SURFACE]), {})


def _make(context: StageContext, inputs: Mapping[str, Path], model: Model, request: MeshRequest) -> MadeMesh:
    """Parametrize, extract, smooth."""
    tets = frame_count(inputs[FRAMES_FRA])
    context.expect("hex", Amount(tets, hexes=expected_hexes(model.surface, request.size)))
    size = request.size.arguments(model.surface, "--target-cells")
    size += ["--feature-angle", repr(request.feature_angle_deg), "--features", str(inputs[FEATURES])]
    with atomic_path(context.workspace / HEX.map_name) as path:
        arguments: list[str | Path] = [inputs[TETS], inputs[FRAMES_FRA], "-o", path, *size]
        parametrization = run_program(
            "cubecover", arguments, request.limits, part(context.progress, 0.0, 0.5)
        )
    extraction, raw = extract(HEX, context, request.limits, parametrization, part(context.progress, 0.5, 0.7))
    progress = part(context.progress, 0.7, 0.9)
    smoothed = smooth_hexes(raw.V, raw.cells, model.surface, model.features, SmoothOptions(), progress)
    cells = CellMesh(raw.kind, smoothed.V, raw.cells)
    return MadeMesh(cells, parametrization, extraction, {"smoothing": asdict(smoothed.report)})


HEX = MeshKind(
    name="hex",
    map_name="map.hexex",
    outputs=("hex.vtk", "hex.mesh"),
    extractor="hexex",
    pictures={"hexes": "hex.png", "hexes_cut": "hex-cut.png"},
    make=_make,
)

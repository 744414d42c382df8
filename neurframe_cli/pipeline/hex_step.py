"""hex on files: tets.mesh, tets.fra -> map.hexex -> hex.vtk, hex.mesh."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from neurframe_cli.field.fra import frame_count
from neurframe_cli.mesh.arrays import Floats, Ints, part, silent
from neurframe_cli.mesh.finer_map import write_finer_map
from neurframe_cli.mesh.read_cells import CellMesh
from neurframe_cli.mesh.read_surface import read_surface
from neurframe_cli.picture.mesh_data import MeshData
from neurframe_cli.pipeline.atomic import atomic_path, scratch_folder
from neurframe_cli.pipeline.discretize_step import FRAMES_FRA
from neurframe_cli.pipeline.fill_step import FILLED, FILLED_PICTURE, fill_step
from neurframe_cli.pipeline.forecast import Amount, expected_hexes
from neurframe_cli.pipeline.mesh_step import MadeMesh, MeshKind, MeshRequest, Model, extract, mesh_step
from neurframe_cli.pipeline.native import run_program
from neurframe_cli.pipeline.pictures import draw_or_warn
from neurframe_cli.pipeline.report_trouble import defects_of
from neurframe_cli.pipeline.runner import StageContext, Step
from neurframe_cli.pipeline.tetize_step import FEATURES, SURFACE, TETS
from neurframe_cli.pipeline.workspace import Workspace
from neurframe_cli.stages.finish_hexes import FinishOptions, finish_hexes


def hex_step(workspace: Workspace, request: MeshRequest) -> Step:
    """The stage bound to its files (paper, section 5.1.2)."""
    inputs = {name: workspace.require(name, "tetize INPUT") for name in (SURFACE, TETS, FEATURES)}
    inputs[FRAMES_FRA] = workspace.require(FRAMES_FRA, "discretize")
    return mesh_step(HEX, inputs, request, lambda: read_surface(inputs[SURFACE]), asdict(request.hexes))


def _make(context: StageContext, inputs: Mapping[str, Path], model: Model, request: MeshRequest) -> MadeMesh:
    """Parametrize, extract, finish."""
    tets = frame_count(inputs[FRAMES_FRA])
    context.expect("hex", Amount(tets, hexes=expected_hexes(model.surface, request.size)))
    size = request.size.arguments(model.surface, "--target-cells")
    size += [
        "--feature-angle",
        repr(request.feature_angle_deg),
        "--features",
        str(inputs[FEATURES].absolute()),
    ]
    with atomic_path(context.workspace / HEX.map_name) as path:
        arguments: list[str | Path] = [inputs[TETS], inputs[FRAMES_FRA], "-o", path, *size]
        parametrization = run_program(
            "cubecover", arguments, request.limits, part(context.progress, 0.0, 0.5)
        )
    if parametrization.statistics.get("polycube"):
        context.warn(POLYCUBE)
    extraction, raw = extract(HEX, context, request.limits, parametrization, part(context.progress, 0.5, 0.7))
    options = FinishOptions(request.hexes.padding, request.hexes.splitting)
    progress = part(context.progress, 0.7, 0.95)

    def finer(times: int) -> tuple[Floats, Ints]:
        with scratch_folder(context.workspace.folder) as scratch:
            write_finer_map(context.workspace / HEX.map_name, scratch / HEX.map_name, times)
            cells = extract(HEX, context, request.limits, parametrization, silent, scratch / HEX.map_name)[1]
        return cells.V, cells.cells

    finished = finish_hexes(raw.V, raw.cells, model.surface, model.features, options, finer, progress)
    for warning in finished.warnings:
        context.warn(warning)
    cells = CellMesh(raw.kind, finished.V, finished.cells)
    return MadeMesh(cells, parametrization, extraction, finished.report)


def _complete(
    context: StageContext, inputs: Mapping[str, Path], made: MadeMesh, request: MeshRequest
) -> dict[str, Any]:
    """A picture of where and why the hexes are not valid, and the filled mesh where it was asked for."""
    if request.pictures:
        places = {
            f"{defect['count']} {defect['what']}": np.array(defect["places"], np.float64).reshape(-1, 3)
            for defect in defects_of(
                {"parametrization": made.parametrization.statistics, "extraction": made.extraction.statistics}
            )
        }
        data = MeshData(made.cells.V, made.cells.cells, places)
        draw_or_warn(context, {"hexes_trouble": TROUBLE_PICTURE}, data)
    if not request.hexes.fill:
        return {}
    return {"filled": fill_step(context, inputs, made.cells, request.limits, pictures=request.pictures)}


POLYCUBE = "the learned field carries no map here: the hexes follow a polycube, without singular lines inside"
TROUBLE_PICTURE = "hex-trouble.png"
HEX = MeshKind(
    name="hex",
    version=2,
    map_name="map.hexex",
    outputs=("hex.vtk", "hex.mesh"),
    extractor="hexex",
    pictures={"hexes": "hex.png", "hexes_cut": "hex-cut.png", "hexes_singular": "hex-singular.png"},
    make=_make,
    complete=_complete,
    extras=(TROUBLE_PICTURE, *FILLED, FILLED_PICTURE),
)

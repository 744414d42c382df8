"""hex on files: tets.mesh, tets.fra -> map.hexex -> hex.vtk, hex.mesh."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from neurframe_cli.mesh.quality.check import Verdict
from neurframe_cli.mesh.read_surface import read_surface
from neurframe_cli.picture.mesh_data import MeshData
from neurframe_cli.pipeline.discretize_step import FRAMES_FRA
from neurframe_cli.pipeline.fill_step import FILLED, FILLED_PICTURE, fill_step
from neurframe_cli.pipeline.hex_maps import mapped_hexes
from neurframe_cli.pipeline.mesh_step import MadeMesh, MeshKind, MeshRequest, Model, mesh_step
from neurframe_cli.pipeline.pictures import draw_or_warn
from neurframe_cli.pipeline.report_trouble import defects_of
from neurframe_cli.pipeline.runner import StageContext, Step
from neurframe_cli.pipeline.tetize_step import FEATURES, SURFACE, TETS
from neurframe_cli.pipeline.workspace import Workspace


def hex_step(workspace: Workspace, request: MeshRequest) -> Step:
    """The stage bound to its files (paper, section 5.1.2)."""
    inputs = {name: workspace.require(name, "tetize INPUT") for name in (SURFACE, TETS, FEATURES)}
    inputs[FRAMES_FRA] = workspace.require(FRAMES_FRA, "discretize")
    options = {**asdict(request.hexes), "grid": request.hexes.grid_allowed}
    return mesh_step(HEX, inputs, request, lambda: read_surface(inputs[SURFACE]), options)


def _make(context: StageContext, inputs: Mapping[str, Path], model: Model, request: MeshRequest) -> MadeMesh:
    return mapped_hexes(HEX, context, inputs, model, request)


def _complete(
    context: StageContext,
    inputs: Mapping[str, Path],
    made: MadeMesh,
    request: MeshRequest,
    verdict: Verdict,
) -> dict[str, Any]:
    """A picture of where and why the hexes are not valid, or those of the map that a grid replaced; and the filled mesh
    where the hexes are not valid and it was asked for."""
    shown = made.replaced or (None if verdict.valid else made.cells)
    if request.pictures and shown is not None:
        places = {
            f"{defect['count']} {defect['what']}": np.array(defect["places"], np.float64).reshape(-1, 3)
            for defect in defects_of({**made.statistics, **made.report})
        }
        draw_or_warn(context, {"hexes_trouble": TROUBLE_PICTURE}, MeshData(shown.V, shown.cells, places))
    if verdict.valid or not request.hexes.fill:
        return {}
    return {"filled": fill_step(context, inputs, made.cells, request.limits, pictures=request.pictures)}


TROUBLE_PICTURE = "hex-trouble.png"
HEX = MeshKind(
    name="hex",
    version=11,
    map_name="map.hexex",
    outputs=("hex.vtk", "hex.mesh"),
    extractor="hexex",
    pictures={"hexes": "hex.png", "hexes_cut": "hex-cut.png", "hexes_singular": "hex-singular.png"},
    make=_make,
    complete=_complete,
    extras=(TROUBLE_PICTURE, *FILLED, FILLED_PICTURE),
)

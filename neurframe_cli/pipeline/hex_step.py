"""hex on files: tets.mesh, tets.fra -> map.hexex -> hex.vtk, hex.mesh."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from neurframe_cli.mesh.arrays import Progress
from neurframe_cli.pipeline.discretize_step import FRAMES_FRA
from neurframe_cli.pipeline.mesh_step import MeshKind, MeshRequest, mesh_step
from neurframe_cli.pipeline.native import Limits, ProgramResult, run_program
from neurframe_cli.pipeline.runner import StageContext, Step
from neurframe_cli.pipeline.tetize_step import FEATURES, SURFACE, TETS
from neurframe_cli.pipeline.workspace import Workspace


def hex_step(workspace: Workspace, request: MeshRequest) -> Step:
    """The stage bound to its files (paper, section 5.1.2)."""
    inputs = {name: workspace.require(name, "tetize INPUT") for name in (SURFACE, TETS, FEATURES)}
    inputs[FRAMES_FRA] = workspace.require(FRAMES_FRA, "discretize")
    return mesh_step(HEX, inputs, request)


def _parametrize(
    context: StageContext,
    inputs: Mapping[str, Path],
    size: list[str],
    target: Path,
    limits: Limits,
    progress: Progress,
) -> ProgramResult:
    files: list[str | Path] = [inputs[TETS], inputs[FRAMES_FRA], "-o", target, "--features", inputs[FEATURES]]
    return run_program("cubecover", [*files, *size], limits, progress)


HEX = MeshKind(
    name="hex",
    map_name="map.hexex",
    outputs=("hex.vtk", "hex.mesh"),
    count_option="--target-cells",
    extractor="hexex",
    pictures={"hexes": "hex.png", "hexes_cut": "hex-cut.png"},
    parametrize=_parametrize,
)

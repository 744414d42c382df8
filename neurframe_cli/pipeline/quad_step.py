"""quad on files: cross.npz -> map.obj -> quad.obj."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from neurframe_cli.errors import UnreadableFile
from neurframe_cli.mesh.arrays import Floats, Progress, Surface
from neurframe_cli.mesh.write_mesh import write_surface
from neurframe_cli.pipeline.atomic import scratch_folder
from neurframe_cli.pipeline.discretize_step import CROSSES
from neurframe_cli.pipeline.mesh_step import MeshKind, MeshRequest, mesh_step
from neurframe_cli.pipeline.native import Limits, ProgramResult, run_program
from neurframe_cli.pipeline.runner import StageContext, Step
from neurframe_cli.pipeline.tetize_step import SURFACE
from neurframe_cli.pipeline.workspace import Workspace


def quad_step(workspace: Workspace, request: MeshRequest) -> Step:
    """The stage bound to its files (paper, section 5.1.1)."""
    inputs = {
        SURFACE: workspace.require(SURFACE, "tetize INPUT"),
        CROSSES: workspace.require(CROSSES, "discretize"),
    }
    return mesh_step(QUAD, inputs, request)


def read_crosses(path: Path) -> tuple[Surface, Floats]:
    """The surface and its crosses (m,2,3) from cross.npz; raises UnreadableFile."""
    try:
        with np.load(path, allow_pickle=False) as stored:
            return Surface(stored["V"], stored["F"]), stored["crosses"]
    except (OSError, ValueError, KeyError) as error:
        raise UnreadableFile(
            f"{path}: no crosses in it: {error}", hint="neurframe discretize --force"
        ) from error


def _parametrize(
    context: StageContext,
    inputs: Mapping[str, Path],
    size: list[str],
    target: Path,
    limits: Limits,
    progress: Progress,
) -> ProgramResult:
    carrier, crosses = read_crosses(inputs[CROSSES])
    with scratch_folder(context.workspace.folder) as scratch:
        files = scratch / "surface.obj", scratch / "crosses.txt"
        write_surface(files[0], carrier)
        np.savetxt(files[1], crosses.reshape(-1, 6), fmt="%.17g")
        return run_program("miq", [*files, "-o", target, *size], limits, progress)


QUAD = MeshKind(
    name="quad",
    map_name="map.obj",
    outputs=("quad.obj",),
    count_option="--target-faces",
    extractor="qex",
    pictures={"quads": "quad.png"},
    parametrize=_parametrize,
)

"""--fill on files: a hex mesh that is not valid -> filled.vtu, filled.msh, filled.png."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from neurframe_cli.errors import StageError, TimedOut
from neurframe_cli.mesh.arrays import Surface, TetMesh
from neurframe_cli.mesh.features import read_features
from neurframe_cli.mesh.filling.hybrid_files import read_hybrid, write_hybrid
from neurframe_cli.mesh.quality.check import CheckOptions
from neurframe_cli.mesh.quality.check_hybrid import check_hybrid
from neurframe_cli.mesh.read_cells import CellMesh
from neurframe_cli.mesh.read_tets import read_medit
from neurframe_cli.mesh.tet_adjacency import tet_adjacency
from neurframe_cli.picture.mesh_data import HybridData
from neurframe_cli.pipeline.atomic import atomic_path, scratch_folder
from neurframe_cli.pipeline.native import Limits
from neurframe_cli.pipeline.pictures import draw_or_warn
from neurframe_cli.pipeline.runner import StageContext
from neurframe_cli.pipeline.tetize_step import FEATURES, TETS
from neurframe_cli.pipeline.workspace import Workspace
from neurframe_cli.stages.fill_voids import FilledMesh, fill_voids
from neurframe_cli.stages.run_netgen import run_netgen

FILLED = ("filled.vtu", "filled.msh")
FILLED_PICTURE = "filled.png"


def fill_step(
    context: StageContext, inputs: Mapping[str, Path], hexes: CellMesh, limits: Limits, *, pictures: bool
) -> dict[str, Any]:
    """Writes the filled mesh; returns its numbers, or under `error` why there is none, which spoils no hex."""
    tets = read_medit(inputs[TETS])[0]
    surface = Surface(tets.V, tet_adjacency(tets.T).boundary_faces)
    with scratch_folder(context.workspace.folder) as scratch:

        def tetrahedralize(void: Surface, edge_length: float) -> TetMesh:
            return run_netgen(
                void,
                edge_length,
                timeout_s=limits.timeout_s,
                memory_mib=limits.memory_mib,
                scratch_dir=scratch,
            )

        try:
            filled = fill_voids(
                hexes.V,
                hexes.cells,
                surface,
                read_features(inputs[FEATURES]).edges,
                tetrahedralize,
                progress=lambda _, text: context.progress(0.96, text),
            )
        except (StageError, TimedOut) as error:
            context.warn(f"the voids were not filled: {error}")
            return {"error": str(error)}
    return _kept(context, filled, surface, pictures=pictures)


def _kept(context: StageContext, filled: FilledMesh, surface: Surface, *, pictures: bool) -> dict[str, Any]:
    """Writes the mesh and its picture; its numbers as they are read back, and which hexes were given up why."""
    for name in FILLED:
        with atomic_path(context.workspace / name) as path:
            write_hybrid(path, filled.mesh)
    if pictures:
        draw_or_warn(context, {"filled": FILLED_PICTURE}, HybridData(filled.mesh))
    verdict = check_hybrid(read_hybrid(context.workspace / FILLED[0]), surface, CheckOptions())
    return {
        **verdict.numbers,
        "valid": verdict.valid,
        "problems": verdict.problems,
        "given_up": list(filled.obstacles),
    }


def export_filled(workspace: Workspace, output: Path) -> None:
    """The filled mesh of the workspace once more, as another file in the format of its extension."""
    mesh = read_hybrid(workspace / FILLED[0])
    with atomic_path(output) as temporary:
        write_hybrid(temporary, mesh)

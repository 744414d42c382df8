"""The two programs of quads on their files: crosses -> map -> quads, until there are as many as were asked for."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from neurframe_cli.mesh.arrays import Floats, part
from neurframe_cli.mesh.merge_doublets import merge_doublets
from neurframe_cli.mesh.read_cells import CellMesh
from neurframe_cli.mesh.write_mesh import write_surface
from neurframe_cli.pipeline.atomic import atomic_path, scratch_folder
from neurframe_cli.pipeline.mesh_step import MeshKind, extract
from neurframe_cli.pipeline.native import Limits, ProgramResult, run_program
from neurframe_cli.pipeline.quad_source import CrossCarrier
from neurframe_cli.pipeline.runner import StageContext

COUNT_TOLERANCE, COUNT_ROUNDS = 0.05, 5


@dataclass(frozen=True)
class MapProblem:
    """What neurframe-miq is asked: sizing (n,) factors on the edge length at the carrier's vertices, or None; one of
    edge_length, in input units, and count of quads."""

    carrier: CrossCarrier
    sizing: Floats | None
    edge_length: float | None
    count: int | None
    feature_angle_deg: float
    limits: Limits


@dataclass(frozen=True)
class MappedQuads:
    """The quads of a map, and what the programs said."""

    cells: CellMesh
    parametrization: ProgramResult
    extraction: ProgramResult


def mapped_quads(kind: MeshKind, context: StageContext, problem: MapProblem) -> MappedQuads:
    """The quads of a map, which stays in the workspace; where their number was asked for, of the nearest of several.

    neurframe-miq steers the parametric area, which differs from the number of quads where cells are folded or lost.
    """
    if problem.count is None:
        return _attempt(kind, context, problem, None)
    asked, best, least = problem.count, None, np.inf
    with scratch_folder(context.workspace.folder) as scratch:
        for _ in range(COUNT_ROUNDS):
            found = _attempt(kind, context, problem, asked)
            ratio = len(found.cells.cells) / problem.count
            if abs(ratio - 1.0) < least:
                best, least = found, abs(ratio - 1.0)
                shutil.copyfile(context.workspace / kind.map_name, scratch / kind.map_name)
            if least <= COUNT_TOLERANCE:
                break
            asked = max(1, round(asked / ratio))
        assert best is not None, "the first attempt has a finite ratio"
        if best is not found:
            with atomic_path(context.workspace / kind.map_name) as path:
                shutil.copyfile(scratch / kind.map_name, path)
    if least > COUNT_TOLERANCE:
        context.warn(f"{len(best.cells.cells)} quads instead of {problem.count}: no map came nearer")
    return best


def _attempt(kind: MeshKind, context: StageContext, problem: MapProblem, count: int | None) -> MappedQuads:
    parametrization = _parametrize(kind, context, problem, count)
    extraction, cells = extract(
        kind, context, problem.limits, parametrization, part(context.progress, 0.5, 0.7)
    )
    V, quads, doublets = merge_doublets(cells.V, cells.cells)
    if doublets:
        context.warn(f"{doublets} pairs of quads that share two edges were merged")
    return MappedQuads(CellMesh("quad", V, quads), parametrization, extraction)


def _parametrize(
    kind: MeshKind, context: StageContext, problem: MapProblem, count: int | None
) -> ProgramResult:
    with scratch_folder(context.workspace.folder) as scratch:
        surface, crosses, sizing = (scratch / name for name in ("surface.obj", "crosses.txt", "sizing.txt"))
        write_surface(surface, problem.carrier.surface)
        np.savetxt(crosses, problem.carrier.crosses.reshape(-1, 6), fmt="%.17g")
        size = (
            ["--edge-length", repr(problem.edge_length)] if count is None else ["--target-faces", str(count)]
        )
        if problem.sizing is not None:
            np.savetxt(sizing, problem.sizing, fmt="%.17g")
            size += ["--sizing", str(sizing)]
        with atomic_path(context.workspace / kind.map_name) as path:
            arguments: list[str | Path] = [surface, crosses, "-o", path, *size]
            arguments += ["--feature-angle", repr(problem.feature_angle_deg)]
            return run_program("miq", arguments, problem.limits, part(context.progress, 0.0, 0.5))

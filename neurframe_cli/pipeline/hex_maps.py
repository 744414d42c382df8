"""From frames to finished hexes: the best map, where its hexes do not pass the next best one, and then a grid.

A map may be valid and its hexes not: trilinear cells ask for more than the pieces of the map, and a feature that the
map does not follow may be farther away than the check allows.  neurframe-cubecover says how many valid maps it has
found, and makes the one that it is asked for.  Where none of them does, a regular grid takes their place.
"""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from neurframe_cli.errors import NotEnoughMemory, NotValid, StageError
from neurframe_cli.field.fra import frame_count
from neurframe_cli.mesh.arrays import Floats, Ints, Progress, part, silent
from neurframe_cli.mesh.finer_map import write_finer_map
from neurframe_cli.mesh.hex_shell import hex_shell
from neurframe_cli.mesh.read_cells import CellMesh
from neurframe_cli.pipeline.atomic import atomic_path, scratch_folder
from neurframe_cli.pipeline.discretize_step import FRAMES_FRA
from neurframe_cli.pipeline.forecast import Amount, expected_hexes
from neurframe_cli.pipeline.mesh_step import MadeMesh, MeshKind, MeshRequest, Model, extract
from neurframe_cli.pipeline.native import ProgramResult, run_program
from neurframe_cli.pipeline.runner import StageContext
from neurframe_cli.pipeline.tetize_step import FEATURES, TETS
from neurframe_cli.stages.finish_hexes import FinishedHexes, FinishOptions, finish_hexes
from neurframe_cli.stages.grid_hexes import GridHexes, GridOptions, far_places, grid_hexes
from neurframe_cli.stages.smooth_hexes import HEX_OPTIONS

MOST_MAPS = 2  # whose hexes are finished; each takes as long as the first one
# bounding-box diagonals; where the best map's hexes are farther away another map's are not tried
FAR_OFF = 0.02
MOST_PLACES = 200  # in a report; more tell no more
POLYCUBE = "the learned field carries no map here: the hexes follow a polycube, without singular lines inside"


@dataclass(frozen=True)
class _Hexes:
    """The hexes of one map, and what the two programs said."""

    finished: FinishedHexes
    parametrization: ProgramResult
    extraction: ProgramResult


def mapped_hexes(
    kind: MeshKind, context: StageContext, inputs: Mapping[str, Path], model: Model, request: MeshRequest
) -> MadeMesh:
    """Parametrize, extract, finish (paper, section 5.1.2); where no hexes of a map pass, those of a grid.

    The map that the hexes are of, or the best one where they are of none, is then in the workspace.  Raises what
    run_program and, where there is no grid, extract raise for the best map; the others may fail, which is a warning.
    """
    tets = frame_count(inputs[FRAMES_FRA])
    context.expect("hex", Amount(tets, hexes=expected_hexes(model.surface, request.size)))
    maker = _HexMaker(kind, context, inputs, model, request)
    with atomic_path(maker.map_file) as path:
        best = maker.parametrize(path, 1, part(context.progress, 0.0, 0.4))
    try:
        made = maker.best_hexes(best, part(context.progress, 0.4, 0.7))
    except NotValid as error:
        grid = maker.on_grid(str(error), 0.0)
        if grid is None:
            raise
        return MadeMesh(CellMesh("hex", grid.V, grid.cells), best, None, grid.report)
    if not made.finished.fine:
        grid = maker.instead_of(made.finished)
        if grid is not None:
            return maker.replaced_by(grid, made)
        if made.finished.given_up:
            made = maker.hexes(best, maker.map_file, part(context.progress, 0.95, 1.0), give_up=False)
    finished = made.finished
    if made.parametrization.statistics.get("polycube"):
        context.warn(POLYCUBE)
    for warning in finished.warnings:
        context.warn(warning)
    cells = CellMesh("hex", finished.V, finished.cells)
    return MadeMesh(cells, made.parametrization, made.extraction, finished.report)


@dataclass(frozen=True)
class _HexMaker:
    """What every map and its hexes are made of."""

    kind: MeshKind
    context: StageContext
    inputs: Mapping[str, Path]
    model: Model
    request: MeshRequest

    @property
    def map_file(self) -> Path:
        """Where the workspace keeps the map that its hexes are of."""
        return self.context.workspace / self.kind.map_name

    def parametrize(self, path: Path, number: int, progress: Progress) -> ProgramResult:
        """Write the best map, or the one with this `number` among the valid ones."""
        arguments: list[str | Path] = [self.inputs[TETS], self.inputs[FRAMES_FRA], "-o", path]
        arguments += self.request.size.arguments(self.model.surface, "--target-cells")
        arguments += ["--feature-angle", repr(self.request.feature_angle_deg)]
        arguments += ["--features", str(self.inputs[FEATURES].absolute())]
        if number > 1:
            arguments += ["--alternative", str(number)]
        return run_program("cubecover", arguments, self.request.limits, progress)

    def best_hexes(self, best: ProgramResult, progress: Progress) -> _Hexes:
        """Those of the `best` map, or where these do not pass, of another valid one, which then is the workspace's."""
        made = self.hexes(best, self.map_file, part(progress, 0.0, 0.4), self.request.hexes.grid_allowed)
        if made.finished.fine or made.finished.numbers.hausdorff > FAR_OFF:
            return made
        return self.another(made, part(progress, 0.4, 1.0))

    def instead_of(self, finished: FinishedHexes) -> GridHexes | None:
        """Hexes of a grid that are better than those of the map, which are not fine."""
        worst = finished.numbers.min_scaled_jacobian
        why = ", ".join(finished.problems)
        why = why or f"a hex is all but inverted, with a scaled Jacobian of {worst:.3f}"
        least = 0.0 if finished.problems else worst
        which = "as the map gives them, its hexes" if finished.given_up else "the hexes of the best map"
        return self.on_grid(f"{which} are refused ({why})", least)

    def replaced_by(self, grid: GridHexes, made: _Hexes) -> MadeMesh:
        """The hexes of the grid, with those of the map that it replaces, and where these are away from the surface."""
        finished, surface = made.finished, self.model.surface
        far = far_places(finished.V, hex_shell(finished.cells).quads, surface, HEX_OPTIONS)
        report = {
            **grid.report,
            "of_the_map": finished.report,
            "far_places": {"count": len(far), "places": far[:MOST_PLACES].tolist()},
        }
        cells, replaced = (CellMesh("hex", hexes.V, hexes.cells) for hexes in (grid, finished))
        return MadeMesh(cells, made.parametrization, made.extraction, report, replaced)

    def on_grid(self, why: str, least: float) -> GridHexes | None:
        """Hexes of a grid whose worst scaled Jacobian is above `least`, with the reason `why` in a warning; None where
        they are not wanted or cannot be had: the hexes of the map, such as they are, must not be lost for that."""
        if not self.request.hexes.grid_allowed:
            return None
        edge_length, limits = self.request.size.layered_edge(self.model.surface), GridOptions()
        surface, features = self.model.surface, self.model.features
        try:
            made = grid_hexes(surface, features, edge_length, limits, part(self.context.progress, 0.7, 0.95))
        except (NotValid, NotEnoughMemory, MemoryError) as error:
            self.context.warn(f"no hexes of a grid: {error}")
            return None
        if made.worst <= least:
            return None
        self.context.warn(f"{why}: the mesh is a regular grid with a layer to the surface{_finer(made)}")
        return made

    def hexes(
        self, parametrization: ProgramResult, map_file: Path, progress: Progress, give_up: bool
    ) -> _Hexes:
        """The finished hexes of a map; `give_up`: not where they are hopeless."""
        limits = self.request.limits

        def finer(times: int) -> tuple[Floats, Ints]:
            with scratch_folder(self.context.workspace.folder) as scratch:
                write_finer_map(map_file, scratch / self.kind.map_name, times)
                finer_map = scratch / self.kind.map_name
                cells = extract(self.kind, self.context, limits, parametrization, silent, finer_map)[1]
            return cells.V, cells.cells

        steps = part(progress, 0.0, 0.2)
        extraction, raw = extract(self.kind, self.context, limits, parametrization, steps, map_file)
        options = FinishOptions(self.request.hexes.padding, self.request.hexes.splitting, give_up)
        surface, features = self.model.surface, self.model.features
        finished = finish_hexes(raw.V, raw.cells, surface, features, options, finer, part(progress, 0.2, 1.0))
        return _Hexes(finished, parametrization, extraction)

    def another(self, first: _Hexes, progress: Progress) -> _Hexes:
        """Hexes that pass, of the best other valid map that has such, which becomes the workspace's; or the `first`."""
        maps = min(MOST_MAPS, int(first.parametrization.statistics.get("valid_maps", 1)))
        for number in range(2, maps + 1):
            steps = part(progress, (number - 2) / (maps - 1), (number - 1) / (maps - 1))
            with scratch_folder(self.context.workspace.folder) as scratch:
                path = scratch / self.kind.map_name
                try:
                    parametrization = self.parametrize(path, number, part(steps, 0.0, 0.4))
                    made = self.hexes(parametrization, path, part(steps, 0.4, 1.0), give_up=True)
                except (StageError, NotValid) as error:
                    self.context.warn(f"no hexes of the valid map number {number}: {error}")
                    break
                if not made.finished.fine:
                    continue
                with atomic_path(self.map_file) as target:
                    shutil.copyfile(path, target)
            self.context.warn(
                f"the hexes of the best map do not pass; these are of the valid map number {number}"
            )
            return made
        return first


def _finer(made: GridHexes) -> str:
    everywhere = "" if made.finer == 1.0 else f", {made.finer:g} times finer than asked for"
    return everywhere + (", and finer in the places where that was too far from it" if made.split else "")

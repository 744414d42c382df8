"""The hex stage with --fill and --padding on real programs, from tets and frames whose hexes are known."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from field_shapes import box_tets, cylinder_tets, four_line_frames

from neurframe_cli.cli.main import run_command_line
from neurframe_cli.errors import NotEnoughMemory, NotValid
from neurframe_cli.mesh.arrays import Floats, Ints, Progress, Surface, as_tets, silent
from neurframe_cli.mesh.features import features_by_angle
from neurframe_cli.mesh.filling.hybrid_files import read_hybrid
from neurframe_cli.mesh.filling.hybrid_mesh import measure_hybrid
from neurframe_cli.mesh.read_cells import read_cells
from neurframe_cli.mesh.tet_adjacency import tet_adjacency
from neurframe_cli.pipeline import hex_maps
from neurframe_cli.pipeline.artifacts import store_frames, store_tets
from neurframe_cli.pipeline.hex_options import HexOptions
from neurframe_cli.pipeline.hex_step import hex_step
from neurframe_cli.pipeline.manifest import read_manifest
from neurframe_cli.pipeline.mesh_step import MeshRequest
from neurframe_cli.pipeline.native import Limits, ProgramResult, run_program
from neurframe_cli.pipeline.runner import run_stage
from neurframe_cli.pipeline.sizing import ElementSize, element_size
from neurframe_cli.pipeline.workspace import Workspace
from neurframe_cli.stages.finish_hexes import FinishedHexes, finish_hexes
from neurframe_cli.stages.grid_hexes import GridHexes, grid_hexes


def stored(folder: Path, V: Floats, T: Ints, frames: Floats) -> Workspace:
    """A workspace as discretize leaves it."""
    tets = as_tets(V, T)
    surface = Surface(tets.V, tet_adjacency(tets.T).boundary_faces)
    features = features_by_angle(surface.V, surface.F, 45.0)
    folder.mkdir()
    workspace = Workspace(folder)
    store_tets(workspace, surface, tets, features)
    store_frames(workspace, frames, surface, np.zeros((len(surface.F), 2, 3)))
    return workspace


def request(size: ElementSize, options: HexOptions) -> MeshRequest:
    return MeshRequest(size, 45.0, Limits(300.0, None, 1), pictures=False, hexes=options)


def test_padding_adds_a_layer_to_each_side_of_a_box(tmp_path: Path) -> None:
    V, T = box_tets((3, 3, 3))
    workspace = stored(tmp_path / "box", V, T, np.tile(np.eye(3), (len(T), 1, 1)))
    side = float(np.ptp(V[:, 0]))
    size = element_size(None, side / 3, None, 30.0)
    record = run_stage(workspace, hex_step(workspace, request(size, HexOptions(padding=True))), silent).record
    assert record.report["padding"]["kept"]
    assert record.report["mesh"]["cells"] == 5**3
    assert record.report["mesh"]["min_scaled_jacobian"] > 0.99


def test_what_is_not_valid_is_filled(tmp_path: Path) -> None:
    V, T = cylinder_tets(8, 3)
    workspace = stored(tmp_path / "cylinder", V, T, four_line_frames(V[T].mean(axis=1)))
    # eight chords round the cylinder are farther from it than the check allows
    size = element_size(4.0, None, None, 30.0)
    with pytest.raises(NotValid, match="Hausdorff"):
        run_stage(
            workspace, hex_step(workspace, request(size, HexOptions(splitting=False, fill=True))), silent
        )
    report = read_manifest(workspace.folder).stages["hex"].report
    assert 0.5 < report["mesh"]["valid_volume_share"] < 1.0
    filled = read_hybrid(workspace / "filled.vtu")
    assert measure_hybrid(filled).valid
    assert report["filled"]["hexes"] == len(filled.hexes)
    assert measure_hybrid(read_hybrid(workspace / "filled.msh")).valid
    # without --fill nothing more is written
    other = stored(tmp_path / "other", V, T, four_line_frames(V[T].mean(axis=1)))
    with pytest.raises(NotValid):
        run_stage(other, hex_step(other, request(size, HexOptions(splitting=False, grid=False))), silent)
    assert not (other / "filled.vtu").exists()
    assert len(read_cells(other / "hex.vtk").cells) == report["mesh"]["cells"]


def test_filled_meshes_reach_a_program_too() -> None:
    import neurframe_cli as nf

    V, T = cylinder_tets(8, 3)
    tets = as_tets(V, T)
    surface = Surface(tets.V, tet_adjacency(tets.T).boundary_faces)
    features = features_by_angle(surface.V, surface.F, 45.0)
    frames = nf.Frames(four_line_frames(V[T].mean(axis=1)), surface, np.zeros((len(surface.F), 2, 3)), {})
    model = nf.Tets(tets.V, tets.T, surface, features, {})
    made = nf.hex(model, frames, scale=4.0, options=nf.HexOptions(splitting=False, fill=True))
    assert not made.valid
    assert made.filled is not None
    assert len(made.filled.hexes) == made.report["filled"]["hexes"]


def test_formats_without_pyramids_are_refused_before_anything_is_done(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["run", str(tmp_path / "part.stl"), "--hex", "--fill", "-o", str(tmp_path / "mesh.ovm")]
    assert run_command_line(arguments) == 2
    assert "no mesh of hexes, pyramids and tets" in capsys.readouterr().err


def test_the_next_valid_map_is_taken_where_the_hexes_of_the_best_do_not_pass(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    V, T = box_tets((3, 3, 3))
    workspace = stored(tmp_path / "box", V, T, np.tile(np.eye(3), (len(T), 1, 1)))
    asked: list[int] = []

    def two_maps(
        program: str, arguments: Sequence[str | os.PathLike[str]], limits: Limits, progress: Progress
    ) -> ProgramResult:
        """The real program, which finds one map only, as if it had found two; the second one ends in an empty line."""
        words = list(arguments)
        asked.append(int(str(words.pop())) if words[-2] == "--alternative" else 1)
        result = run_program(program, [word for word in words if word != "--alternative"], limits, progress)
        if asked[-1] == 2:
            with Path(words[words.index("-o") + 1]).open("a") as written:
                written.write("\n")
        return replace(result, statistics=result.statistics | {"valid_maps": 2, "number": asked[-1]})

    def first_ones_do_not_pass(*arguments: Any) -> FinishedHexes:
        return replace(finish_hexes(*arguments), problems=() if asked[-1] > 1 else ("too round",))

    monkeypatch.setattr(hex_maps, "run_program", two_maps)
    monkeypatch.setattr(hex_maps, "finish_hexes", first_ones_do_not_pass)
    size = element_size(None, float(np.ptp(V[:, 0])) / 3, None, 30.0)
    record = run_stage(workspace, hex_step(workspace, request(size, HexOptions())), silent).record
    assert asked == [1, 2]
    assert record.report["parametrization"]["number"] == 2
    assert any("valid map number 2" in warning for warning in record.warnings)
    assert (workspace / "map.hexex").read_text().endswith("\n\n")


@pytest.mark.parametrize("extracted", [True, False])
def test_a_grid_takes_the_place_of_hexes_that_do_not_pass(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, *, extracted: bool
) -> None:
    V, T = box_tets((3, 3, 3))
    workspace = stored(tmp_path / "box", V, T, np.tile(np.eye(3), (len(T), 1, 1)))

    def none_passes(*arguments: Any) -> FinishedHexes:
        if not extracted:
            raise NotValid("no hex mesh could be extracted from the map")
        made = finish_hexes(*arguments)
        return replace(made, V=made.V + np.array([0.0, 0.0, 0.1]), problems=("too round",))

    monkeypatch.setattr(hex_maps, "finish_hexes", none_passes)
    size = element_size(None, float(np.ptp(V[:, 0])) / 3, None, 30.0)
    asked = replace(request(size, HexOptions()), pictures=True)
    record = run_stage(workspace, hex_step(workspace, asked), silent).record
    assert any("regular grid" in warning for warning in record.warnings)
    # three cells along each edge, and a layer on all six sides
    assert record.report["mesh"]["cells"] == 3**3 + 6 * 3**2
    assert len(read_cells(workspace / "hex.vtk").cells) == 3**3 + 6 * 3**2
    assert [attempt["finer"] for attempt in record.report["grid"]] == [1.0]
    assert (workspace / "map.hexex").exists()
    assert ("of_the_map" in record.report) == extracted
    # where the hexes of the map were too far from the surface: above and below, by the tenth that they were moved
    assert (workspace / "hex-trouble.png").exists() == extracted
    if extracted:
        heights = np.array(record.report["far_places"]["places"])[:, 2]
        assert record.report["far_places"]["count"] >= len(heights) > 0
        assert np.abs(heights - V[:, 2].mean()).max() > 0.4 * np.ptp(V[:, 2])
    assert any("too round" in warning for warning in record.warnings) == extracted


def test_hexes_of_the_map_stay_where_a_grid_cannot_be_had_or_is_worse(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    V, T = box_tets((3, 3, 3))
    size = element_size(None, float(np.ptp(V[:, 0])) / 3, None, 30.0)

    def hardly_valid(*arguments: Any) -> FinishedHexes:
        made = finish_hexes(*arguments)
        return replace(made, numbers=replace(made.numbers, min_scaled_jacobian=0.04))

    def no_memory(*arguments: Any) -> GridHexes:
        raise NotEnoughMemory("6,000 MiB of memory are needed")

    def worse(*arguments: Any) -> GridHexes:
        return replace(grid_hexes(*arguments), worst=0.03)

    monkeypatch.setattr(hex_maps, "finish_hexes", hardly_valid)
    for name, other, says in (("full", no_memory, "6,000 MiB"), ("worse", worse, "")):
        monkeypatch.setattr(hex_maps, "grid_hexes", other)
        workspace = stored(tmp_path / name, V, T, np.tile(np.eye(3), (len(T), 1, 1)))
        record = run_stage(workspace, hex_step(workspace, request(size, HexOptions())), silent).record
        assert record.report["mesh"]["cells"] == 3**3
        assert not any("regular grid" in warning for warning in record.warnings)
        assert [says in warning for warning in record.warnings] == [True] * bool(says)


@pytest.mark.parametrize("options", [HexOptions(grid=False), HexOptions(fill=True)])
def test_no_grid_is_made_where_it_is_not_wanted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, options: HexOptions
) -> None:
    V, T = box_tets((3, 3, 3))
    workspace = stored(tmp_path / "box", V, T, np.tile(np.eye(3), (len(T), 1, 1)))

    def nothing(*arguments: Any) -> FinishedHexes:
        raise NotValid("no hex mesh could be extracted from the map")

    monkeypatch.setattr(hex_maps, "finish_hexes", nothing)
    size = element_size(None, float(np.ptp(V[:, 0])) / 3, None, 30.0)
    with pytest.raises(NotValid, match="no hex mesh could be extracted"):
        run_stage(workspace, hex_step(workspace, request(size, options)), silent)

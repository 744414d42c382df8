"""`neurframe check` for hexes: the singular graph, the share of valid volume, hybrid meshes, pictures."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from smooth_shapes import cube_hexes, cylinder_hexes, sphere_hexes

from neurframe_cli.cli.main import run_command_line
from neurframe_cli.mesh.filling.hybrid_files import write_hybrid
from neurframe_cli.mesh.filling.hybrid_mesh import HybridMesh
from neurframe_cli.mesh.quality.check import CheckOptions, check_hexes
from neurframe_cli.mesh.quality.hex_singular_graph import hex_singular_graph
from neurframe_cli.mesh.quality.polygons import topology_problems
from neurframe_cli.mesh.read_cells import CellMesh
from neurframe_cli.mesh.write_cells import write_cells
from neurframe_cli.mesh.write_mesh import write_surface
from neurframe_cli.picture.mesh_data import HybridData, MeshData
from neurframe_cli.stages.pad_hexes import pad_hexes


def test_a_grid_has_no_singular_edge() -> None:
    assert hex_singular_graph(cube_hexes(3).cells).summary() == {
        "interior_singular_edges": 0,
        "singular_edges_by_valence": {},
        "singular_arcs": 0,
        "singular_nodes": 0,
    }


def test_the_cylinder_has_four_arcs_of_valence_three() -> None:
    shape = cylinder_hexes(layers=6)
    found = hex_singular_graph(shape.cells)
    assert found.summary() == {
        "interior_singular_edges": 4 * 6,
        "singular_edges_by_valence": {"3": 4 * 6},
        "singular_arcs": 4,
        "singular_nodes": 0,
    }
    along = shape.V[found.edges[:, 1]] - shape.V[found.edges[:, 0]]
    assert np.abs(along[:, :2]).max() < 1e-12


def test_a_cube_in_a_sphere_has_twenty_arcs_and_eight_nodes() -> None:
    # a cube with a layer round it: its twelve edges, and from its eight corners one arc each to the boundary
    V, H = pad_hexes(*(getattr(sphere_hexes(4), name) for name in ("V", "cells")))
    found = hex_singular_graph(H)
    assert found.summary() == {
        "interior_singular_edges": 12 * 4 + 8,
        "singular_edges_by_valence": {"3": 12 * 4 + 8},
        "singular_arcs": 20,
        "singular_nodes": 8,
    }
    assert len(V) > found.nodes.max()


def test_inverted_hexes_do_not_count_as_volume() -> None:
    shape = cube_hexes(4)
    V = shape.V.copy()
    corner = int(np.linalg.norm(V, axis=1).argmin())
    V[corner] = 0.3  # beyond the opposite vertex of its hex
    numbers = check_hexes(V, shape.cells, shape.surface, shape.features, CheckOptions()).numbers
    assert numbers["inverted"] == 1
    assert numbers["valid_volume_share"] == pytest.approx(63 / 64)


@pytest.fixture
def cube(tmp_path: Path) -> Path:
    write_surface(tmp_path / "cube.ply", cube_hexes(2).surface)
    return tmp_path / "cube.ply"


def corner_of_pyramids(n: int) -> HybridMesh:
    """The unit cube in n^3 hexes, the first of which is six pyramids round its centre."""
    shape = cube_hexes(n)
    quads = shape.cells[0][
        [[0, 1, 2, 3], [4, 7, 6, 5], [0, 4, 5, 1], [1, 5, 6, 2], [2, 6, 7, 3], [3, 7, 4, 0]]
    ]
    V = np.concatenate([shape.V, shape.V[shape.cells[0]].mean(axis=0)[None]])
    pyramids = np.column_stack([quads, np.full(6, len(shape.V))])
    return HybridMesh(V, shape.cells[1:], pyramids, np.zeros((0, 4), np.int64))


def test_hexes_with_pyramids_are_checked(cube: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mesh = cube.parent / "mixed.vtu"
    whole = corner_of_pyramids(3)
    write_hybrid(mesh, whole)
    assert run_command_line(["check", str(mesh), "--against", str(cube), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["kind"], found["hexes"], found["pyramids"], found["valid"]) == ("hybrid", 26, 6, True)
    assert found["hex_volume_share"] == pytest.approx(26 / 27)
    write_hybrid(mesh, HybridMesh(whole.V, whole.hexes, whole.pyramids[1:], whole.tets))
    assert (
        run_command_line(["check", str(mesh), "--against", str(cube)]) == 0
    )  # a dent of 0.6 % of the volume
    inside_out = whole.pyramids[:, [0, 3, 2, 1, 4]]
    write_hybrid(mesh, HybridMesh(whole.V, whole.hexes, inside_out, whole.tets))
    assert run_command_line(["check", str(mesh), "--against", str(cube)]) == 4
    assert "6 cells with a Jacobian" in capsys.readouterr().err


@pytest.mark.slow
def test_pictures_of_what_is_not_valid_and_of_what_was_filled(tmp_path: Path) -> None:
    from neurframe_cli.picture.draw import draw

    shape = cube_hexes(3)
    V = shape.V.copy()
    V[int(np.linalg.norm(V, axis=1).argmin())] = 0.5
    trouble, filled = tmp_path / "trouble.png", tmp_path / "filled.png"
    draw(
        {"hexes_trouble": trouble},
        MeshData(V, shape.cells, {"2 folded tets": np.array([[0.1] * 3, [0.9] * 3])}),
    )
    draw({"filled": filled}, HybridData(corner_of_pyramids(3)))
    for path in (trouble, filled):
        pixels = np.asarray(Image.open(path).convert("RGB"), int)
        assert pixels.std() > 5
    colors = np.asarray(Image.open(trouble).convert("RGB"), int)
    red = (colors[..., 0] > 120) & (colors[..., 1] < 70) & (colors[..., 2] < 80)
    assert red.sum() > 500  # the inverted hex


@pytest.mark.slow
def test_pictures_of_a_mesh_file(cube: Path) -> None:
    mesh, drawn = cube.parent / "grid.vtk", cube.parent / "pictures"
    shape = cube_hexes(3)
    write_cells(mesh, CellMesh("hex", shape.V, shape.cells))
    assert run_command_line(["check", str(mesh), "--against", str(cube), "--pictures", str(drawn), "-q"]) == 0
    names = {path.name for path in drawn.iterdir()}
    assert names == {f"grid-{name}.png" for name in ("hexes", "hexes-cut", "hexes-singular")}


def test_an_input_that_touches_itself_is_named_as_the_cause() -> None:
    """Two tetrahedra with a common tip: three is no Euler characteristic of a closed manifold."""
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    other = np.array([3, 4, 5, 6])[faces]
    assert topology_problems(faces, faces) == []
    assert "touches itself" in topology_problems(faces, np.concatenate([faces, other]))[0]
    assert topology_problems(faces, np.concatenate([faces, faces + 4])) == [
        "components, Euler characteristic (1, 2) instead of (2, 4)"
    ]

"""Quads in every output format, read back by other readers than ours where there is one."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest
import trimesh
from smooth_shapes import grid_hexes, sphere_quads

from neurframe_cli.errors import UnsupportedFormat
from neurframe_cli.mesh.read_cells import CellMesh, read_cells
from neurframe_cli.mesh.write_cells import FORMATS, check_output, write_cells

SHAPE = sphere_quads(3)
MESH = CellMesh("quad", SHAPE.V, SHAPE.cells)
# how much of a coordinate the format keeps: ten digits in Nastran's columns, glTF is float32
PRECISION = {".bdf": 1e-9, ".glb": 1e-6, ".inp": 1e-12}


@pytest.mark.parametrize("extension", [e for e in FORMATS["quad"] if e != ".glb"])
def test_quads_stay_quads(tmp_path: Path, extension: str) -> None:
    path = tmp_path / f"mesh{extension}"
    write_cells(path, MESH)
    read = read_cells(path)
    assert read.kind == "quad"
    np.testing.assert_array_equal(read.cells, MESH.cells)
    np.testing.assert_allclose(read.V, MESH.V, atol=PRECISION.get(extension, 1e-15))


@pytest.mark.parametrize("extension", [".obj", ".ply", ".vtk", ".vtu"])
def test_meshio_reads_what_we_write(tmp_path: Path, extension: str) -> None:
    path = tmp_path / f"mesh{extension}"
    write_cells(path, MESH)
    assert len(meshio.read(path).cells_dict["quad"]) == len(MESH.cells)


def test_glb_holds_two_triangles_a_quad(tmp_path: Path) -> None:
    path = tmp_path / "mesh.glb"
    write_cells(path, MESH)
    scene = trimesh.load_scene(path)
    (shape,) = scene.geometry.values()
    assert len(shape.faces) == 2 * len(MESH.cells)
    assert shape.is_watertight
    np.testing.assert_allclose(shape.vertices, MESH.V, atol=PRECISION[".glb"])


@pytest.mark.parametrize("name", ["mesh.stl", "mesh.3mf", "mesh", "mesh.xyz"])
def test_formats_without_quads_are_refused(name: str) -> None:
    with pytest.raises(UnsupportedFormat, match="no quad mesh is written") as refused:
        check_output(Path(name), "quad")
    assert ".obj" in str(refused.value.hint)


@pytest.mark.parametrize("extension", [".obj", ".ply", ".vtu", ".glb"])
def test_the_same_quads_give_the_same_bytes(tmp_path: Path, extension: str) -> None:
    written = []
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        path = tmp_path / folder / f"mesh{extension}"
        write_cells(path, MESH)
        written.append(path.read_bytes())
    assert written[0] == written[1]


def test_hexes_in_nastran_go_on_in_a_second_line(tmp_path: Path) -> None:
    V, H = grid_hexes(2)
    write_cells(tmp_path / "mesh.bdf", CellMesh("hex", V - 0.5, H))
    read = read_cells(tmp_path / "mesh.bdf")
    np.testing.assert_array_equal(read.cells, H)
    np.testing.assert_allclose(read.V, V - 0.5, atol=1e-9)

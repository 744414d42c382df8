"""Hexes in every output format: the vertex order, against a cube, by readers that are not ours where there is one."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
from smooth_shapes import cylinder_hexes, grid_hexes

from neurframe_cli.errors import InvalidMesh, UnreadableFile, UnsupportedFormat
from neurframe_cli.mesh.arrays import Floats, Ints
from neurframe_cli.mesh.ovm import OvmLines
from neurframe_cli.mesh.quality.scaled_jacobian import hex_scaled_jacobians
from neurframe_cli.mesh.read_cells import CellMesh, read_cells
from neurframe_cli.mesh.write_cells import FORMATS, check_output, write_cells

CORNERS = np.array(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float
)
CUBE = CellMesh("hex", CORNERS, np.arange(8)[None])
PRECISION = {".bdf": 1e-9, ".inp": 1e-12}


@pytest.mark.parametrize("extension", FORMATS["hex"])
def test_the_cube_keeps_its_vertex_order(tmp_path: Path, extension: str) -> None:
    path = tmp_path / f"cube{extension}"
    write_cells(path, CUBE)
    read = read_cells(path)
    # a cube has 24 right-handed numberings; the corners say which vertex is which
    positions = read.V[read.cells[0]]
    assert hex_scaled_jacobians(read.V, read.cells) == pytest.approx(np.ones((1, 8)))
    if extension != ".ovm":  # which names faces, not corners: the numbering may be turned
        np.testing.assert_allclose(positions, CORNERS, atol=PRECISION.get(extension, 0))


@pytest.mark.parametrize("extension", FORMATS["hex"])
def test_a_cylinder_comes_back(tmp_path: Path, extension: str) -> None:
    shape = cylinder_hexes(layers=2)
    path = tmp_path / f"mesh{extension}"
    write_cells(path, CellMesh("hex", shape.V, shape.cells))
    read = read_cells(path)
    np.testing.assert_allclose(read.V, shape.V, atol=PRECISION.get(extension, 1e-15))
    np.testing.assert_array_equal(np.sort(read.cells, axis=1), np.sort(shape.cells, axis=1))
    assert hex_scaled_jacobians(read.V, read.cells).min() > 0


@pytest.mark.parametrize("extension", [e for e in FORMATS["hex"] if e != ".ovm"])
def test_meshio_reads_what_we_write(tmp_path: Path, extension: str) -> None:
    path = tmp_path / f"cube{extension}"
    write_cells(path, CUBE)
    found = meshio.read(path)
    np.testing.assert_array_equal(found.cells_dict["hexahedron"], CUBE.cells)


@pytest.mark.parametrize(
    ("extension", "reader"),
    [
        (".vtk", "vtkUnstructuredGridReader"),
        (".vtu", "vtkXMLUnstructuredGridReader"),
        (".e", "vtkExodusIIReader"),
    ],
)
def test_vtk_sees_a_cube_of_volume_one(tmp_path: Path, extension: str, reader: str) -> None:
    path = tmp_path / f"cube{extension}"
    write_cells(path, CUBE)
    grid = _by_vtk(path, reader)
    assert grid.n_cells == 1
    assert grid.GetCellType(0) == 12  # VTK_HEXAHEDRON
    assert grid.compute_cell_sizes().cell_data["Volume"][0] == pytest.approx(1.0)
    np.testing.assert_allclose(grid.points[grid.get_cell(0).point_ids], CORNERS)


def _by_vtk(path: Path, name: str) -> Any:
    import pyvista
    import vtk

    reader = getattr(vtk, name)()
    reader.SetFileName(str(path))
    reader.Update()
    found = pyvista.wrap(reader.GetOutputDataObject(0))
    return found.combine() if isinstance(found, pyvista.MultiBlock) else found


def test_abaqus_and_nastran_name_the_cells(tmp_path: Path) -> None:
    write_cells(tmp_path / "cube.inp", CUBE)
    assert "C3D8" in (tmp_path / "cube.inp").read_text()
    write_cells(tmp_path / "cube.bdf", CUBE)
    cell = next(line for line in (tmp_path / "cube.bdf").read_text().splitlines() if line.startswith("CHEXA"))
    assert cell.split() == ["CHEXA", "1", "1", "1", "2", "3", "4", "5", "6"]


def test_half_faces_of_an_ovm_look_inward(tmp_path: Path) -> None:
    path = tmp_path / "grid.ovm"
    write_cells(path, CellMesh("hex", *grid_hexes(2)))
    V, faces, cells = _ovm(path)
    assert len(faces) == 36  # of two by two by two hexes, each once
    uses = np.bincount(cells.ravel(), minlength=72)
    assert uses.max() == 1
    for cell in cells:
        loops = [faces[h // 2][:: 1 if h % 2 == 0 else -1] for h in cell]
        centre = V[np.unique(loops)].mean(axis=0)
        for loop in loops:
            normal = np.cross(V[loop[1]] - V[loop[0]], V[loop[2]] - V[loop[0]])
            assert normal @ (centre - V[loop[0]]) > 0


def _ovm(path: Path) -> tuple[Floats, Ints, Ints]:
    lines = OvmLines(path)
    lines.expect("OVM ASCII")
    V = np.array([lines.floats(3) for _ in range(lines.count("Vertices"))])
    edges = np.array([lines.integers(2) for _ in range(lines.count("Edges"))])
    faces = np.array([lines.counted() for _ in range(lines.count("Faces"))])
    cells = np.array([lines.counted() for _ in range(lines.count("Polyhedra"))])
    return V, np.where(faces % 2 == 0, edges[faces // 2, 0], edges[faces // 2, 1]), cells


@pytest.mark.parametrize(
    ("old", "new", "error", "message"),
    [
        ("Polyhedra\n1\n6 ", "Polyhedra\n1\n6 12 ", UnreadableFile, "announces"),
        ("Polyhedra\n1\n6 ", "Polyhedra\n1\n5 ", UnreadableFile, "announces"),
        ("6 1 ", "6 99 ", UnreadableFile, "half-face 99"),
        ("6 1 ", "6 3 ", InvalidMesh, "do not close to a hex"),
    ],
)
def test_a_damaged_ovm_is_refused(
    tmp_path: Path, old: str, new: str, error: type[Exception], message: str
) -> None:
    path = tmp_path / "cube.ovm"
    write_cells(path, CUBE)
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(error, match=message):
        read_cells(path)


@pytest.mark.parametrize("name", ["mesh.obj", "mesh.stl", "mesh", "mesh.xyz"])
def test_other_extensions_are_one_clear_line(name: str) -> None:
    with pytest.raises(UnsupportedFormat, match="no hex mesh is written") as refused:
        check_output(Path(name), "hex")
    assert "\n" not in str(refused.value)
    assert ".vtu" in str(refused.value.hint)
    assert ".ovm" in str(refused.value.hint)

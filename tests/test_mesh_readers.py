"""Every format: what is written or hand-made is read back as it was; what is broken is refused by name."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path

import numpy as np
import pytest

from neurframe_cli.errors import InputError, InvalidMesh, UnreadableFile, UnsupportedFormat
from neurframe_cli.mesh.arrays import Features, Surface, TetMesh, as_surface, as_tets
from neurframe_cli.mesh.features import features_from_edges
from neurframe_cli.mesh.file_format import file_format
from neurframe_cli.mesh.load import load_model
from neurframe_cli.mesh.read_surface import read_surface
from neurframe_cli.mesh.read_tets import read_medit, read_tets
from neurframe_cli.mesh.tet_adjacency import tet_adjacency
from neurframe_cli.mesh.weld import weld
from neurframe_cli.mesh.write_mesh import write_surface, write_tets

CUBE_V = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)
# five tets: one in the middle, four in the corners 0, 3, 5, 6
CUBE_T = np.array([[1, 2, 4, 7], [0, 1, 2, 4], [3, 2, 1, 7], [5, 1, 4, 7], [6, 4, 2, 7]])


@pytest.fixture
def tets() -> TetMesh:
    volumes = np.linalg.det(CUBE_V[CUBE_T[:, 1:]] - CUBE_V[CUBE_T[:, :1]])
    return as_tets(CUBE_V, np.where((volumes < 0)[:, None], CUBE_T[:, [0, 1, 3, 2]], CUBE_T))


@pytest.fixture
def surface(tets: TetMesh) -> Surface:
    return as_surface(tets.V, tet_adjacency(tets.T).boundary_faces)


@pytest.fixture
def features(tets: TetMesh) -> Features:
    edges = np.array([(i, j) for i in range(8) for j in range(i + 1, 8) if (i ^ j).bit_count() == 1])
    return features_from_edges(tets.V, edges)


def same_tets(one: TetMesh, two: TetMesh) -> bool:
    return np.array_equal(one.V, two.V) and np.array_equal(np.sort(one.T, axis=1), np.sort(two.T, axis=1))


def test_medit_round_trip_keeps_every_bit(tets: TetMesh, features: Features, tmp_path: Path) -> None:
    odd = as_tets(tets.V * np.pi * 1e-7 + 1 / 3, tets.T)
    write_tets(tmp_path / "a.mesh", odd, features)
    read, edges = read_medit(tmp_path / "a.mesh")
    assert np.array_equal(read.V, odd.V)
    assert np.array_equal(read.T, odd.T)
    assert np.array_equal(edges.edges, features.edges)
    assert np.array_equal(edges.corners, np.arange(8))
    assert len(edges.chains) == 12


@pytest.mark.parametrize("extension", [".vtk", ".vtu", ".msh"])
def test_tet_formats_of_meshio_round_trip(
    extension: str, tets: TetMesh, features: Features, tmp_path: Path
) -> None:
    path = tmp_path / f"a{extension}"
    write_tets(path, tets, features)
    read, edges = read_tets(path)
    assert same_tets(read, tets)
    assert np.array_equal(edges.edges, features.edges)


@pytest.mark.parametrize("extension", [".ply", ".stl", ".obj", ".off", ".vtk", ".vtu"])
def test_surface_formats_round_trip(extension: str, surface: Surface, tmp_path: Path) -> None:
    path = tmp_path / f"a{extension}"
    write_surface(path, surface)
    read = read_surface(path)
    assert np.array_equal(read.V[read.F], surface.V[surface.F])
    if extension != ".stl":
        assert np.array_equal(read.F, surface.F)


@pytest.mark.parametrize("extension", [".3mf", ".glb", ".stl", ".ply"])
def test_files_of_trimesh_are_read(extension: str, surface: Surface, tmp_path: Path) -> None:
    import trimesh

    path = tmp_path / f"a{extension}"
    trimesh.Trimesh(surface.V, surface.F, process=False).export(path)
    read = read_surface(path)
    V, F = weld(read.V, read.F, 0.0)
    assert len(V) == 8
    assert np.array_equal(
        np.sort(V[F].reshape(-1, 9), axis=0), np.sort(surface.V[surface.F].reshape(-1, 9), axis=0)
    )


@pytest.mark.parametrize(
    ("extension", "liar"), [(".stl", ".obj"), (".ply", ".stl"), (".vtk", ".mesh"), (".off", "")]
)
def test_content_beats_the_name(extension: str, liar: str, surface: Surface, tmp_path: Path) -> None:
    write_surface(tmp_path / f"a{extension}", surface)
    lying = (tmp_path / f"a{extension}").rename(tmp_path / f"b{liar}")
    assert file_format(lying) == extension.lstrip(".")
    model = load_model(lying)
    assert isinstance(model, Surface)
    assert len(model.F) == 12


def test_binary_stl_whose_header_says_solid(surface: Surface, tmp_path: Path) -> None:
    path = tmp_path / "a.stl"
    write_surface(path, surface)
    path.write_bytes(b"solid".ljust(80) + path.read_bytes()[80:])
    assert len(read_surface(path).F) == 12


OVM = """OVM ASCII
Vertices
4
0 0 0
1 0 0
0 1 0
0 0 1
Edges
6
0 1
0 2
0 3
1 2
1 3
2 3
Faces
4
3 2 7 1
3 0 8 5
3 4 11 3
3 6 10 9
Polyhedra
1
4 0 2 4 6
EProp int "feature_edges"
1
0
0
0
0
1
"""


def test_ovm(tmp_path: Path) -> None:
    (tmp_path / "a.ovm").write_text(OVM)
    mesh, features = read_tets(tmp_path / "a.ovm")
    assert sorted(mesh.T[0]) == [0, 1, 2, 3]
    assert features.edges.tolist() == [[0, 1], [2, 3]]


def test_ovm_with_a_cell_that_is_no_tet(tmp_path: Path) -> None:
    (tmp_path / "a.ovm").write_text(OVM.replace("4 0 2 4 6", "3 0 2 4"))
    with pytest.raises(InvalidMesh, match=r"cell 0 has 3 faces"):
        read_tets(tmp_path / "a.ovm")


TAGGED_VTK = """# vtk DataFile Version 2.0
tagged
ASCII
DATASET UNSTRUCTURED_GRID
POINTS 5 double
0 0 0  1 0 0  0 1 0  0 0 1  1 1 1
CELLS {cells} {numbers}
{lines}3 1 2 3
3 1 2 4
3 0 1 2
3 0 3 1
3 0 2 3
3 1 4 3
3 2 3 4
4 0 1 2 3
4 1 4 2 3
CELL_TYPES {cells}
{line_types}5 5 5 5 5 5 5 10 10
CELL_DATA {cells}
SCALARS CellEntityIds int 1
LOOKUP_TABLE default
{line_tags}9 1 2 3 4 5 6 1 1
"""


def test_curves_of_tagged_vtk_become_features(tmp_path: Path) -> None:
    """Boundary edges 0-1 and 1-2 as curves; edge 1-3 is a curve as well."""
    lines = "2 0 1\n2 1 2\n2 1 3\n"
    text = TAGGED_VTK.format(cells=12, numbers=47, lines=lines, line_types="3 3 3 ", line_tags="1 2 3 ")
    (tmp_path / "a.vtk").write_text(text)
    mesh, features = read_tets(tmp_path / "a.vtk")
    assert len(mesh.T) == 2
    assert features.edges.tolist() == [[0, 1], [1, 2], [1, 3]]
    assert 1 in features.corners


def test_polygons_of_off(tmp_path: Path) -> None:
    """A cube of quads, with comments, colours and an L-shaped lid that only one fan triangulates rightly."""
    (tmp_path / "a.off").write_text(
        "OFF # a comment\n\n6 1 0\n2 0 0\n2 2 0\n1 2 0\n1 1 0\n0 1 0\n0 0 0\n6 0 1 2 3 4 5 255 0 0\n"
    )
    surface = read_surface(tmp_path / "a.off")
    a, b, c = (surface.V[surface.F[:, i]] for i in range(3))
    areas = np.cross(b - a, c - a)[:, 2] / 2
    assert (areas >= 0).all()
    assert areas.sum() == pytest.approx(3.0)


BROKEN = {
    "missing.stl": (None, UnreadableFile),
    "empty.stl": ("", UnreadableFile),
    "words.txt": ("these are only words", UnsupportedFormat),
    "words.ply": ("these are only words", UnreadableFile),
    "range.obj": ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", InputError),
    "points.obj": ("v 0 0 0\nv 1 0 0\nv 0 1 0\n", InputError),
    "nan.off": ("OFF\n3 1 0\n0 0 nan\n1 0 0\n0 1 0\n3 0 1 2\n", InvalidMesh),
    "counts.off": ("OFF\n3000000000 1 0\n0 0 0\n", UnreadableFile),
    "cut.mesh": ("MeshVersionFormatted 2\nDimension 3\nVertices 4\n0 0 0 0\n1 0 0 0\n", UnreadableFile),
    "flat.mesh": (
        "MeshVersionFormatted 2\nDimension 3\nVertices 4\n0 0 0 0\n1 0 0 0\n0 1 0 0\n1 1 0 0\n"
        "Tetrahedra 1\n1 2 3 4 0\nEnd\n",
        InvalidMesh,
    ),
    "range.mesh": (
        "MeshVersionFormatted 2\nDimension 3\nVertices 4\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n"
        "Tetrahedra 1\n1 2 3 5 0\nEnd\n",
        InvalidMesh,
    ),
    "entity.vtu": ('<?xml version="1.0"?><VTKFile><!ENTITY a "b"></VTKFile>', UnreadableFile),
    "binary.ovm": ("OVMB\n\r\n", UnsupportedFormat),
    "binary.mesh": ("\1\0\0\0\2\0\0\0\3\0\0\0", UnsupportedFormat),
}


@pytest.mark.parametrize("name", BROKEN)
def test_broken_files_are_refused_and_named(
    name: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    text, expected = BROKEN[name]
    path = tmp_path / name
    if text is not None:
        path.write_text(text)
    with pytest.raises(expected) as caught:
        load_model(path)
    assert name in str(caught.value)
    assert "\n" not in str(caught.value)
    assert capfd.readouterr() == ("", ""), "a library printed something"


def test_overlapping_tets_are_refused(tmp_path: Path) -> None:
    """Both fourth vertices lie above the shared face."""
    (tmp_path / "a.mesh").write_text(
        "MeshVersionFormatted 2\nDimension\n3\nVertices\n5\n0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n.1 .1 2 0\n"
        "Tetrahedra\n2\n1 2 3 4 0\n1 2 3 5 0\nEnd\n"
    )
    with pytest.raises(InvalidMesh, match="overlap"):
        read_tets(tmp_path / "a.mesh")


def test_zip_bomb(tmp_path: Path) -> None:
    path = tmp_path / "bomb.3mf"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("3D/3dmodel.model", b"\0" * (50 << 20))
    with pytest.raises(UnreadableFile, match="unpacks from"):
        read_surface(path)


def test_a_zip_that_is_no_model(tmp_path: Path) -> None:
    path = tmp_path / "a.3mf"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("readme.txt", json.dumps({}))
    with pytest.raises(UnreadableFile, match="without a 3D model"):
        read_surface(path)


def test_step_without_gmsh_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "a.step"
    path.write_text("ISO-10303-21;\n")
    monkeypatch.setattr("neurframe_cli.mesh.read_step.find_gmsh", lambda: None)
    with pytest.raises(UnsupportedFormat, match="Gmsh") as caught:
        read_surface(path)
    assert "pip install" in str(caught.value.hint)

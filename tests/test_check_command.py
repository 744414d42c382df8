"""`neurframe check`: exit 0 for a valid mesh file, 4 for an invalid one, 2 for what is no mesh of quads or hexes."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from test_quality import cube_shell, hex_grid

from neurframe_cli.cli.main import run_command_line
from neurframe_cli.mesh.quality.polygons import triangulated


@pytest.fixture
def box(tmp_path: Path) -> Path:
    import trimesh

    V, Q = cube_shell(1)
    path = tmp_path / "box.stl"
    trimesh.Trimesh(V, triangulated(Q), process=False).export(path)
    return path


def write(path: Path, V: object, cells: object, kind: str) -> Path:
    import meshio

    meshio.Mesh(V, [(kind, cells)]).write(path)
    return path


@pytest.mark.parametrize("name", ["hex.vtk", "hex.vtu", "hex.mesh", "hex.inp"])
def test_valid_hexes_pass_in_every_format(box: Path, name: str, capsys: pytest.CaptureFixture[str]) -> None:
    mesh = write(box.parent / name, *hex_grid(3), "hexahedron")
    assert run_command_line(["check", str(mesh), "--against", str(box), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["valid"]
    assert found["feature_recall"] == 1.0


def test_valid_quads_pass_and_a_hole_is_exit_4(box: Path, capsys: pytest.CaptureFixture[str]) -> None:
    V, Q = cube_shell(4)
    closed, holed = write(box.parent / "q.obj", V, Q, "quad"), write(box.parent / "h.obj", V, Q[1:], "quad")
    assert run_command_line(["check", str(closed), "--against", str(box)]) == 0
    assert run_command_line(["check", str(holed), "--against", str(box)]) == 4
    assert "open edges" in capsys.readouterr().err


def test_what_is_no_quad_or_hex_mesh_is_exit_2(box: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run_command_line(["check", str(box), "--against", str(box)]) == 2
    assert "no quads and no hexahedra" in capsys.readouterr().err
    V, Q = cube_shell(1)
    bad = write(box.parent / "bad.vtk", np.where(V > 0, np.nan, V), Q, "quad")
    assert run_command_line(["check", str(bad), "--against", str(box)]) == 2
    assert "finite" in capsys.readouterr().err

"""`neurframe view`: a page on this machine only, until it is interrupted."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
import threading
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from field_shapes import box_tets
from html_page import Page
from report_workspaces import dented_cube, make_workspace

from neurframe_cli.cli.main import run_command_line
from neurframe_cli.errors import InputError
from neurframe_cli.mesh.arrays import Features, TetMesh
from neurframe_cli.mesh.read_cells import CellMesh
from neurframe_cli.mesh.write_cells import write_cells
from neurframe_cli.mesh.write_mesh import write_tets
from neurframe_cli.pipeline.mesh_view import mesh_page
from neurframe_cli.report import vtkjs

SAMPLES = Path(__file__).parent.parent / "samples"
PATIENCE_S = 120.0


@contextmanager
def viewing(*arguments: str) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """`neurframe view ARGUMENTS --no-browser` as a process, and the address that it prints."""
    command = [sys.executable, "-m", "neurframe_cli", "view", *arguments, "--no-browser"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    rescue = threading.Timer(PATIENCE_S, process.kill)
    rescue.start()
    try:
        assert process.stdout is not None
        address = process.stdout.readline().strip()
        assert re.fullmatch(r"http://127\.0\.0\.1:\d+/", address), process.communicate()
        yield process, address
    finally:
        rescue.cancel()
        process.kill()
        process.communicate()


def fetch(address: str, host: str | None = None) -> tuple[int, str]:
    """Status and body."""
    request = urllib.request.Request(address, headers={} if host is None else {"Host": host})
    opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))
    try:
        with opener.open(request, timeout=PATIENCE_S) as answer:
            return answer.status, answer.read().decode()
    except urllib.error.HTTPError as error:
        with error:
            return error.code, error.read().decode()


def test_a_workspace_is_served_here_only_until_ctrl_c(tmp_path: Path) -> None:
    folder = make_workspace(tmp_path / "cube.neurframe")
    before = {path.name for path in folder.iterdir()}
    with viewing("-w", str(folder)) as (process, address):
        status, body = fetch(address)
        assert status == 200
        assert Page(body).json("numbers")["workspace"] == "cube.neurframe"
        assert fetch(address + "report.json")[0] == 404
        assert fetch(address + "../manifest.json")[0] == 404
        # a name of somebody else's that leads to this machine
        assert fetch(address, host="example.org")[0] == 404
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 130
    assert "Traceback" not in said
    assert {path.name for path in folder.iterdir()} == before


def test_a_port_that_is_taken_is_an_error(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with viewing(str(SAMPLES / "cube.stl")) as (_, address):
        port = address.rstrip("/").rpartition(":")[2]
        assert run_command_line(["view", str(SAMPLES / "cube.stl"), "--no-browser", "--port", port]) == 2
    assert f"port {port} cannot be used" in capsys.readouterr().err


def test_hexes_tets_and_triangles_have_a_page(tmp_path: Path) -> None:
    V, H = dented_cube()
    write_cells(tmp_path / "h.vtk", CellMesh("hex", V, H))
    page = Page(mesh_page(tmp_path / "h.vtk"))
    assert page.json("numbers")["hexes"] == len(H)
    assert (
        page.json("scene")["cut"]["layer"] == "hex mesh, 64 hexes" == page.json("scene")["layers"][0]["title"]
    )
    tets = TetMesh(*box_tets((2, 1, 1)))
    write_tets(tmp_path / "t.mesh", tets, Features())
    page = Page(mesh_page(tmp_path / "t.mesh"))
    assert page.json("numbers")["tets"] == len(tets.T)
    assert page.json("numbers")["diagonal"] == pytest.approx(np.linalg.norm(np.ptp(tets.V, axis=0)))
    page = Page(mesh_page(SAMPLES / "cube.stl"))
    assert page.json("numbers")["triangles"] == 12
    assert page.addresses() == []


def test_what_is_no_mesh_is_said(tmp_path: Path) -> None:
    (tmp_path / "no.stl").write_text("no mesh")
    for name in ("no.stl", "missing.vtk"):
        with pytest.raises(InputError, match=name):
            mesh_page(tmp_path / name)
    (tmp_path / "bad.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 9\n")
    with pytest.raises(InputError, match=r"bad\.obj"):
        mesh_page(tmp_path / "bad.obj")


def test_without_the_extra_a_mesh_is_refused_in_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    find = vtkjs.importlib.util.find_spec
    monkeypatch.setattr(
        vtkjs.importlib.util, "find_spec", lambda name: None if name == "trame_vtk" else find(name)
    )
    assert run_command_line(["view", str(SAMPLES / "cube.stl"), "--no-browser"]) == 2
    assert "pip install 'neurframe[report]'" in capsys.readouterr().err


def test_two_things_to_view_are_one_too_many(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run_command_line(["view", "a.stl", "-w", str(tmp_path)]) == 2
    assert "leave one of them out" in capsys.readouterr().err

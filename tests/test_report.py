"""Reports hold all that is known, in one file that asks the network for nothing and believes no name."""

from __future__ import annotations

import json
import shutil
from dataclasses import asdict
from pathlib import Path

import pytest
from html_page import Page
from report_workspaces import DEFECT, SIDE, make_workspace

from neurframe_cli.cli.main import run_command_line
from neurframe_cli.errors import StageError, UsageError
from neurframe_cli.pipeline.manifest import Manifest, StageRecord, read_manifest, write_manifest
from neurframe_cli.pipeline.report_step import write_report, write_summary
from neurframe_cli.report import vtkjs

HOSTILE = """</script><script>window.hacked=1</script><img src=x onerror="window.hacked=1">'"&amp;"""


@pytest.fixture(scope="module")
def workspace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return make_workspace(tmp_path_factory.mktemp("report") / "cube.neurframe")


@pytest.fixture(scope="module")
def page(workspace: Path) -> Page:
    return Page(write_report(workspace).read_text(encoding="utf-8"))


def test_the_page_is_whole_and_asks_the_network_for_nothing(page: Page) -> None:
    assert page.addresses() == []
    assert page.handlers() == []
    policy = next(meta["content"] for meta in page.all("meta") if meta.get("http-equiv"))
    assert policy is not None
    assert "default-src 'none'" in policy
    assert "http" not in policy


def test_the_numbers_are_those_of_the_manifest(page: Page, workspace: Path) -> None:
    document = page.json("numbers")
    assert document == json.loads((workspace / "report.json").read_text())
    manifest = read_manifest(workspace)
    assert document["stages"] == {name: asdict(record) for name, record in manifest.stages.items()}
    assert document["outcome"] == "valid"
    assert document["totals"] == {"seconds": 1.25 * 7, "cpu_seconds": 2.5 * 7, "peak_mib": 321.5}
    assert document["surface"]["diagonal"] == pytest.approx(3**0.5)
    assert len(document["training"]) == 20
    assert document["troubles"] == []
    assert document["notes"] == []


def test_quality_is_that_of_the_files(page: Page, workspace: Path) -> None:
    document = page.json("numbers")
    for kind, cells in (("quad", 6 * SIDE**2), ("hex", SIDE**3)):
        mesh = document["meshes"][kind]
        checked = document["stages"][kind]["report"]["mesh"]
        assert sum(mesh["histogram"]["counts"]) == cells == mesh["cells"]
        assert len(mesh["histogram"]["edges"]) == len(mesh["histogram"]["counts"]) + 1
        assert mesh["worst"][0]["scaled_jacobian"] == checked["min_scaled_jacobian"]
        assert [entry["cell"] for entry in mesh["worst"]] == checked["worst_cells"]
    # the vertex in the middle was pushed towards the corner (1, 1, 1)
    assert document["meshes"]["hex"]["worst"][0]["at"] == pytest.approx([0.64] * 3, abs=0.03)
    assert document["meshes"]["hex"]["worst"][0]["scaled_jacobian"] < 0.9


def test_the_page_shows_what_there_is(page: Page) -> None:
    for shown in (
        "cube.neurframe",
        "Time and memory",
        "321.5",
        "distillation",
        "Worst cells",
        "2026-01-02 03:04:05",
    ):
        assert shown in page.text
    assert [figure["alt"] for figure in page.all("img")] == [
        "Quads, coloured by quality, and irregular vertices",
        "Hexes from outside, coloured by quality",
        "Hexes behind a cut, and singular edges",
        "Singular edges of the field",
    ]
    assert all((image["src"] or "").startswith("data:image/webp;base64,") for image in page.all("img"))
    # loss curve, and a histogram for each mesh
    assert len([svg for svg in page.all("svg") if svg["class"] == "chart"]) == 3
    titles = [layer["title"] for layer in page.json("scene")["layers"]]
    for title in (
        "hex mesh, 64 hexes",
        "quad mesh, 96 quads",
        "input surface",
        "singular edges",
        "streamlines inside",
    ):
        assert any(found.startswith(title) for found in titles), titles


def test_the_same_workspace_gives_the_same_bytes(workspace: Path, tmp_path: Path) -> None:
    one, other = (write_report(workspace, tmp_path / f"{name}.html") for name in ("one", "other"))
    assert one.read_bytes() == other.read_bytes()
    assert (tmp_path / "one.json").read_bytes() == (tmp_path / "other.json").read_bytes()


def test_names_and_messages_are_text(tmp_path: Path) -> None:
    folder = make_workspace(tmp_path / "<script>window.hacked=1<", valid=False, warning=HOSTILE)
    manifest = read_manifest(folder)
    manifest.stages["hex"].error = HOSTILE
    manifest.stages["train"].options[HOSTILE] = HOSTILE
    manifest.stages["hex"].report["parametrization"]["defects"][HOSTILE] = {"count": 3, "places": [DEFECT]}
    write_manifest(folder, manifest)
    page = Page(write_report(folder).read_text(encoding="utf-8"))
    assert page.handlers() == []
    assert page.addresses() == []
    assert not any("hacked" in script for name, script in page.scripts.items() if name not in ("numbers",))
    assert page.text.count(HOSTILE) >= 4
    assert page.json("numbers")["workspace"] == folder.name


def test_an_invalid_mesh_says_why_and_where(tmp_path: Path) -> None:
    page = Page(write_report(make_workspace(tmp_path / "w", valid=False)).read_text(encoding="utf-8"))
    document = page.json("numbers")
    assert document["outcome"] == "invalid"
    (trouble,) = document["troubles"]
    assert trouble["defects"] == [{"what": "off-axis edge of the field", "count": 1, "places": [DEFECT]}]
    assert "corner Jacobian <= 0" in page.text
    assert "0.25, 0.5, 0.75" in page.text
    assert json.dumps(DEFECT) in [
        button["data-at"] for button in page.all("button") if button.get("class") == "goto"
    ]
    assert any(layer["title"] == "defects, 1" for layer in page.json("scene")["layers"])


def test_a_damaged_artifact_is_left_out_and_said(tmp_path: Path) -> None:
    folder = make_workspace(tmp_path / "w")
    (folder / "hex.vtk").write_bytes((folder / "hex.vtk").read_bytes()[:300])
    (folder / "quad.png").write_bytes(b"no picture")
    (folder / "hex.png").write_bytes((folder / "hex.png").read_bytes()[:200])
    (folder / "train.jsonl").write_text('{"event": "step", "val')
    (folder / "surface.ply").write_bytes(b"ply\n")
    (folder / "singular_edges.vtp").write_text("<VTKFile>")
    (folder / "streamlines.vtp").unlink()
    document = Page(write_report(folder).read_text(encoding="utf-8")).json("numbers")
    assert list(document["meshes"]) == ["quad"]
    assert document["surface"] is None
    notes = "\n".join(document["notes"])
    for name in (
        "hex.vtk",
        "quad.png",
        "hex.png",
        "train.jsonl",
        "surface.ply",
        "singular_edges.vtp",
        "streamlines.vtp",
    ):
        assert name in notes, name


def test_what_an_unfinished_stage_left_is_not_shown(tmp_path: Path) -> None:
    folder = make_workspace(tmp_path / "w")
    manifest = read_manifest(folder)
    manifest.stages["hex"].status, manifest.stages["hex"].error = "failed", "out of memory"
    write_manifest(folder, manifest)
    document = Page(write_report(folder).read_text(encoding="utf-8")).json("numbers")
    assert document["outcome"] == "failed"
    assert list(document["meshes"]) == ["quad"]


def test_a_stage_that_died_at_once_has_a_report_too(tmp_path: Path) -> None:
    (tmp_path / "w").mkdir()
    record = StageRecord("failed", "k", error="no surface in it", outputs={"surface.ply": ""})
    write_manifest(tmp_path / "w", Manifest({"tetize": record}))
    page = Page(write_report(tmp_path / "w").read_text(encoding="utf-8"))
    assert "no surface in it" in page.text
    assert "scene" not in page.scripts


def test_nothing_done_and_nowhere_to_write_are_errors(tmp_path: Path, workspace: Path) -> None:
    with pytest.raises(UsageError, match="nothing has been done"):
        write_report(tmp_path)
    with pytest.raises(StageError, match="cannot write"):
        write_report(workspace, tmp_path / "missing" / "report.html")


def test_without_the_extra_there_is_a_report_without_3d(
    workspace: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    find = vtkjs.importlib.util.find_spec
    monkeypatch.setattr(
        vtkjs.importlib.util, "find_spec", lambda name: None if name == "trame_vtk" else find(name)
    )
    page = Page(write_report(workspace, tmp_path / "report.html").read_text(encoding="utf-8"))
    assert "vtkjs" not in page.scripts
    assert "pip install 'neurframe[report]'" in page.text
    assert len(page.all("img")) == 4


def test_report_on_the_command_line(
    workspace: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    target = tmp_path / "out.html"
    assert run_command_line(["report", "-w", str(workspace), "-o", str(target)]) == 0
    assert capsys.readouterr().out.strip() == str(target)
    assert json.loads(target.with_suffix(".json").read_text())["workspace"] == "cube.neurframe"
    assert run_command_line(["report", "-w", str(workspace), "-o", str(tmp_path / "out.json")]) == 2
    assert "HTML" in capsys.readouterr().err
    shutil.copytree(workspace, tmp_path / "copy.neurframe")
    (tmp_path / "copy.neurframe" / "manifest.json").unlink()
    assert run_command_line(["report", "-w", str(tmp_path / "copy.neurframe")]) == 2


def test_a_batch_is_a_table_with_links(tmp_path: Path) -> None:
    rows = [
        {
            "model": "a/b.stl",
            "outcome": "valid",
            "quads": 1234,
            "hex": {"cells": 7},
            "report": "b #1/report.html",
        },
        {"model": HOSTILE, "outcome": "timed out", "seconds": 1.5, "report": "javascript:window.hacked=1"},
        {"model": "c.stl", "outcome": "valid", "report": None},
    ]
    page = Page(write_summary(rows, tmp_path / "summary.html").read_text(encoding="utf-8"))
    assert page.json("numbers") == rows
    assert page.handlers() == []
    # beside the page, whatever they look like
    assert page.addresses() == ["./b%20%231/report.html", "./javascript%3Awindow.hacked%3D1"]
    heads = ["model", "outcome", "report", "quads", "hex cells", "seconds"]
    assert page.text.split("sorts by it.")[1].strip().startswith("2valid1timed out")
    assert "".join(heads) in page.text
    assert len(page.all("tr")) == 1 + len(rows)


def test_an_empty_batch_is_a_page_too(tmp_path: Path) -> None:
    assert "0 models" in Page(write_summary([], tmp_path / "summary.html").read_text(encoding="utf-8")).text

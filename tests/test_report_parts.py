"""The parts of a report: what they promise for any input."""

from __future__ import annotations

import base64
import io
import json
import zipfile
import zlib
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_quality import cube_shell, hex_grid

from neurframe_cli.errors import UnreadableFile
from neurframe_cli.mesh.hex_shell import HEX_FACES
from neurframe_cli.mesh.read_cells import CellMesh
from neurframe_cli.picture.read_vtp import read_vtp
from neurframe_cli.picture.vtp import write_streamlines_vtp
from neurframe_cli.report import words
from neurframe_cli.report.axis import linear_ticks, log_ticks, tick_label
from neurframe_cli.report.chart import Series, curve_chart, histogram_chart
from neurframe_cli.report.layers import Layer, ViewFrame
from neurframe_cli.report.mesh_quality import cell_quality, describe_quality
from neurframe_cli.report.scene import cut_document, hex_faces, scene_document
from neurframe_cli.report.tubes import SIDES, tubes
from neurframe_cli.report.vtkjs import scene_archive, viewer_license, viewer_script


def unpacked(archive: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """The scene of an archive, and its arrays as bytes by hash."""
    with zipfile.ZipFile(io.BytesIO(base64.b64decode(archive))) as content:
        document = json.loads(content.read("index.json"))
    return document["scene"], {
        name: base64.b64decode(entry["content"]) for name, entry in document["hashes"].items()
    }


def test_a_scene_holds_the_points_and_cells_of_its_layers() -> None:
    V, Q = cube_shell(3)
    moved = 1000 + 3 * V
    colors = np.arange(3 * len(Q)).reshape(-1, 3).astype(np.uint8)
    archive = scene_archive([Layer("quads", moved, Q, colors=colors)], ViewFrame.around(moved))
    scene, arrays = unpacked(archive)
    actor = scene["dependencies"][0]["dependencies"][1]
    data = actor["dependencies"][0]["dependencies"][0]["properties"]
    points = np.frombuffer(arrays[data["points"]["hash"]], np.float32).reshape(-1, 3)
    diagonal = 3 * 3**0.5
    # half of a step of the grid: 1 / 262144 of the diagonal
    assert np.abs(points * diagonal + (1000 + 1.5) - moved).max() < diagonal / 2**18 * 1.01
    cells = np.frombuffer(arrays[data["polys"]["hash"]], np.uint32).reshape(-1, 5)
    assert (cells[:, 0] == 4).all()
    assert np.array_equal(cells[:, 1:], Q)
    assert arrays[data["fields"][0]["hash"]] == colors.tobytes()
    assert archive == scene_archive([Layer("quads", moved, Q, colors=colors)], ViewFrame.around(moved))


def test_the_faces_of_a_grid_and_their_owners() -> None:
    n = 3
    _, H = hex_grid(n)
    faces = hex_faces(H)
    assert len(faces.corners) == 3 * n**2 * (n + 1)
    assert len(faces.shell) == 6 * n**2
    for side in (0, 1):
        there = faces.owners[:, side] >= 0
        owner, corners = H[faces.owners[there, side]], faces.corners[there]
        assert (corners[:, :, None] == owner[:, None, :]).any(axis=2).all()
    # seen from outside by the first owner: the same cyclic order as in the hex
    first = np.sort(H[faces.owners[:, 0]][:, HEX_FACES], axis=2)
    assert (first == np.sort(faces.corners, axis=1)[:, None]).all(axis=2).any(axis=1).all()


def test_cutting_needs_what_the_page_gets() -> None:
    V, H = hex_grid(2)
    faces, quality = hex_faces(H), cell_quality(CellMesh("hex", V, H))
    cut = cut_document("hexes", faces, quality)
    assert cut is not None
    for name, kind, values in (("corners", np.uint32, faces.corners), ("owners", np.int32, faces.owners)):
        packed = zlib.decompress(base64.b64decode(cut[name]))
        assert np.array_equal(np.frombuffer(packed, kind).reshape(values.shape), values)
    assert len(zlib.decompress(base64.b64decode(cut["colors"]))) == 3 * len(H)


def test_a_layer_too_large_for_a_page_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    V, Q = cube_shell(2)
    large, small = Layer("large", V, np.repeat(Q, 4, axis=0)), Layer("small", V, Q)
    monkeypatch.setattr("neurframe_cli.report.scene.MOST_CELLS_TOGETHER", 2 * len(Q))
    document = scene_document([small, large, replace(small, title="also small")])
    assert document is not None
    assert [layer["title"] for layer in document["layers"]] == ["small", "also small"]
    assert document["left_out"] == ["large"]
    assert scene_document([large]) is None
    assert scene_document([Layer("nothing", V, Q[:0])]) is None


def test_tubes_keep_their_distance_from_their_segments() -> None:
    rng = np.random.default_rng(3)
    V = rng.normal(size=(8, 3))
    edges = np.array([[0, 1], [2, 3], [4, 5], [6, 7], [0, 7]])
    points, sides = tubes(V, edges, 0.05)
    assert points.shape == (2 * SIDES * len(edges), 3)
    assert sides.shape == (SIDES * len(edges), 4)
    rings = points.reshape(len(edges), 2, SIDES, 3)
    assert np.allclose(np.linalg.norm(rings - V[edges][:, :, None], axis=-1), 0.05)
    along = V[edges[:, 1]] - V[edges[:, 0]]
    assert np.allclose(np.einsum("erk,ek->er", (rings - V[edges][:, :, None]).reshape(5, -1, 3), along), 0)


@given(st.floats(-1e6, 1e6), st.floats(1e-6, 1e6))
@settings(deadline=None)
def test_ticks_are_round_and_inside(low: float, span: float) -> None:
    ticks = linear_ticks(low, low + span)
    assert 1 <= len(ticks) <= 8
    slack = 1e-6 * span + 1e-9 * abs(low)
    assert all(low - slack <= tick <= low + span + slack for tick in ticks)
    assert ticks == sorted(ticks)


@given(st.floats(1e-12, 1e6), st.floats(1.0, 1e12))
@settings(deadline=None)
def test_logarithmic_ticks_are_inside(low: float, factor: float) -> None:
    ticks = log_ticks(low, low * factor)
    assert 1 <= len(ticks) <= 8
    assert all(low * 0.99 <= tick <= low * factor * 1.01 for tick in ticks)


def test_tick_labels_are_short() -> None:
    assert [tick_label(x) for x in (0, 0.25, 12, 1e-6, 2e7)] == ["0", "0.25", "12", "1e-6", "2e7"]


def test_charts_leave_out_what_cannot_be_drawn() -> None:
    chart = curve_chart([Series("a<b", [(0, 1.0), (1, 0.0), (2, float("nan")), (3, 0.1)])], "x", "y")
    assert "a&lt;b" in chart
    assert "nan" not in chart
    assert curve_chart([Series("nothing", [(0, 0.0)])], "x", "y") == ""
    assert curve_chart([Series("one", [(5, 2.0)])], "x", "y") != ""
    bars = histogram_chart([0.0, 0.5, 1.0], [0, 3], lambda quality: "#123456", "q", "cells")
    assert bars.count('class="bar"') == 1
    assert "0.5 to 1: 3" in bars


def test_histogram_of_inverted_cells_begins_below_zero() -> None:
    V, H = hex_grid(2)
    H = H.copy()
    H[0] = H[0][[4, 5, 6, 7, 0, 1, 2, 3]]
    mesh = CellMesh("hex", V, H)
    described = describe_quality(mesh, cell_quality(mesh))
    assert described["histogram"]["edges"][0] == -1.0
    assert described["histogram"]["counts"][0] == 1
    assert described["worst"][0] == {"cell": 0, "scaled_jacobian": -1.0, "at": [0.25, 0.25, 0.25]}


def test_numbers_as_words() -> None:
    assert [words.number(x) for x in (None, True, 1234567, 0.123456, [1, 2.5], "x")] == [
        "–",
        "yes",
        "1\u202f234\u202f567",
        "0.1235",
        "1, 2.5",
        "x",
    ]
    assert [words.duration(x) for x in (12.34, 125, 7260)] == ["12.3 s", "2 min 5 s", "2 h 1 min"]
    assert words.flat({"a": {"b_c": 1}, "d": 2}) == {"a b c": 1, "d": 2}
    assert words.local_link("javascript:alert(1)").startswith("./")


def test_polylines_read_back(tmp_path: Any) -> None:
    one, other = np.random.default_rng(0).normal(size=(2, 4, 3))
    write_streamlines_vtp(tmp_path / "s.vtp", [one], [other[:2]])
    lines = read_vtp(tmp_path / "s.vtp")
    assert np.allclose(lines.points, np.concatenate([one, other[:2]]))
    assert lines.segments.tolist() == [[0, 1], [1, 2], [2, 3], [4, 5]]
    assert lines.line.tolist() == [0, 0, 0, 1]
    assert lines.data["on_surface"].tolist() == [0, 1]
    write_streamlines_vtp(tmp_path / "none.vtp", [], [])
    assert len(read_vtp(tmp_path / "none.vtp").segments) == 0
    whole = (tmp_path / "s.vtp").read_bytes()
    for share in range(1, 10):
        (tmp_path / f"{share}.vtp").write_bytes(whole[: share * len(whole) // 10])
    for name in (*(f"{share}.vtp" for share in range(1, 10)), "missing.vtp"):
        with pytest.raises(UnreadableFile, match=name):
            read_vtp(tmp_path / name)


@pytest.mark.skipif(viewer_script() is None, reason="trame-vtk (extra `report`) is not installed")
def test_the_viewer_can_stand_in_a_script_element() -> None:
    script = viewer_script()
    assert script is not None
    assert "</script" not in script.lower()
    assert "kitware.github.io/vtk-js/icon" not in script
    assert "Redistribution and use in source and binary forms" in viewer_license()

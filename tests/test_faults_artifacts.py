"""Artifacts that something else has spoilt: no traceback, no crash, no result that nobody has checked."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from faults import OUTPUTS, Ended, assert_clear, copy_of, words

from neurframe_cli.cli.main import run_command_line
from neurframe_cli.errors import NotValid, StageError, UsageError
from neurframe_cli.mesh.read_cells import read_cells
from neurframe_cli.pipeline.atomic import sha256_of
from neurframe_cli.pipeline.manifest import read_manifest

# artifact -> a stage that reads it
READERS = [
    ("tets.mesh", "train"),
    ("features.json", "train"),
    ("surface.ply", "discretize"),
    ("tets.mesh", "discretize"),
    ("features.json", "discretize"),
    ("field.safetensors", "discretize"),
    ("surface.ply", "quad"),
    ("cross.npz", "quad"),
    ("surface.ply", "hex"),
    ("tets.mesh", "hex"),
    ("features.json", "hex"),
    ("tets.fra", "hex"),
]
FAILURES = (UsageError.exit_code, StageError.exit_code, NotValid.exit_code)


def emptied(path: Path) -> None:
    path.write_bytes(b"")


def cut_off(path: Path) -> None:
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])


def overwritten(path: Path) -> None:
    content = bytearray(path.read_bytes())
    middle = len(content) // 2
    content[middle : middle + 64] = bytes(range(64))
    path.write_bytes(content)


def folder_instead(path: Path) -> None:
    path.unlink()
    path.mkdir()


def gone(path: Path) -> None:
    path.unlink()


DAMAGES: tuple[Callable[[Path], None], ...] = (emptied, cut_off, overwritten, folder_instead, gone)


def run(stage: str, workspace: Path, capsys: pytest.CaptureFixture[str]) -> Ended:
    code = run_command_line(words(stage, workspace))
    return Ended(code, capsys.readouterr().err)


def assert_warned(artifact: str, stage: str, workspace: Path) -> None:
    """A file that its stage has not written is used, and not in silence."""
    warnings = read_manifest(workspace).stages[stage].warnings
    assert any(warning.startswith(f"{artifact} is not the file that") for warning in warnings)


@pytest.mark.parametrize("damage", DAMAGES)
@pytest.mark.parametrize(("artifact", "stage"), READERS)
def test_damaged_artifact(
    artifact: str,
    stage: str,
    damage: Callable[[Path], None],
    staged: dict[str, Path],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    workspace = copy_of(staged[stage], tmp_path)
    damage(workspace / artifact)
    ended = run(stage, workspace, capsys)
    assert artifact in ended.said
    if ended.code == 0:  # 64 bytes of a binary file may be as good as those before
        assert damage is overwritten
        assert_warned(artifact, stage, workspace)
        return
    assert_clear(ended, *FAILURES)
    assert not any((workspace / name).exists() for name in OUTPUTS[stage] if not name.startswith("map."))


@pytest.fixture(scope="module")
def other(staged: dict[str, Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A workspace of another model: fewer tets, and elsewhere."""
    folder = tmp_path_factory.mktemp("other")
    V = np.array([[x, y, z] for x in (5, 6) for y in (0, 2) for z in (0, 1)], np.float64)
    T = [[0, 3, 5, 6], [0, 3, 1, 5], [0, 3, 6, 2], [0, 5, 4, 6], [3, 5, 6, 7]]
    tets = [[a, b, c, d] for a, b, c, d in T]
    flipped = [t if np.linalg.det(V[t[1:]] - V[t[0]]) > 0 else [t[0], t[2], t[1], t[3]] for t in tets]
    lines = ["MeshVersionFormatted 2", "Dimension 3", f"Vertices {len(V)}"]
    lines += [f"{x} {y} {z} 0" for x, y, z in V.tolist()] + [f"Tetrahedra {len(flipped)}"]
    lines += [f"{a + 1} {b + 1} {c + 1} {d + 1} 0" for a, b, c, d in flipped] + ["End"]
    (folder / "block.mesh").write_text("\n".join(lines) + "\n")
    workspace = folder / "block.neurframe"
    assert run_command_line(["tetize", str(folder / "block.mesh"), "-w", str(workspace), "-q"]) == 0
    for stage in ("train", "discretize"):
        assert run_command_line(words(stage, workspace)) == 0
    return workspace


@pytest.mark.parametrize(("artifact", "stage"), READERS)
def test_artifact_of_another_workspace(
    artifact: str,
    stage: str,
    staged: dict[str, Path],
    other: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """It is refused, or what is made of it passes the checks: a field, for one, can be asked anywhere."""
    workspace = copy_of(staged[stage], tmp_path)
    shutil.copyfile(other / artifact, workspace / artifact)
    ended = run(stage, workspace, capsys)
    if ended.code != 0:
        assert_clear(ended, *FAILURES)
        return
    assert read_manifest(workspace).stages[stage].inputs[artifact] == sha256_of(other / artifact)
    assert_warned(artifact, stage, workspace)
    if stage in ("quad", "hex"):
        mesh = workspace / OUTPUTS[stage][1]
        assert len(read_cells(mesh).cells) > 0
        assert run_command_line(["check", str(mesh), "--against", str(workspace / "surface.ply"), "-q"]) == 0


def test_a_stage_does_not_go_on_with_what_was_made_of_something_else(
    staged: dict[str, Path], other: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """tets.fra is there, whole, and of other tets than those there now."""
    workspace = copy_of(staged["hex"], tmp_path)
    shutil.copyfile(other / "tets.mesh", workspace / "tets.mesh")
    ended = run("hex", workspace, capsys)
    assert_clear(ended, UsageError.exit_code)
    assert "another tets.mesh" in ended.said
    assert "neurframe discretize" in ended.said


@pytest.mark.parametrize("damage", DAMAGES)
def test_damaged_result_is_made_again(
    damage: Callable[[Path], None],
    staged: dict[str, Path],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    workspace = copy_of(staged["done"], tmp_path)
    damage(workspace / "hex.vtk")
    ended = run("hex", workspace, capsys)
    if damage is folder_instead:
        assert_clear(ended, StageError.exit_code)
        assert "hex.vtk" in ended.said
        return
    assert ended.code == 0
    assert sha256_of(workspace / "hex.vtk") == sha256_of(staged["done"] / "hex.vtk")


def later_manifest(workspace: Path) -> None:
    _change_json(workspace / "manifest.json", version=99)


def later_features(workspace: Path) -> None:
    _change_json(workspace / "features.json", version=99)


def later_frames(workspace: Path) -> None:
    path = workspace / "tets.fra"
    path.write_text(path.read_text().replace("FRA 1", "FRA 2", 1))


def later_field(workspace: Path) -> None:
    """The length of the header stays as it is."""
    path = workspace / "field.safetensors"
    content = path.read_bytes()
    old = rb"\"version\": 1"
    assert old in content
    path.write_bytes(content.replace(old, rb"\"version\": 9", 1))


def _change_json(path: Path, **entries: int) -> None:
    path.write_text(json.dumps(json.loads(path.read_text()) | entries))


@pytest.mark.parametrize(
    ("change", "stage"),
    [(later_manifest, stage) for stage in ("tetize", "train", "discretize", "quad", "hex")]
    + [
        (later_features, "train"),
        (later_frames, "hex"),
        (later_field, "discretize"),
    ],
)
def test_artifact_of_a_later_version(
    change: Callable[[Path], None],
    stage: str,
    staged: dict[str, Path],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    workspace = copy_of(staged["train" if stage == "tetize" else stage], tmp_path)
    change(workspace)
    ended = run(stage, workspace, capsys)
    assert_clear(ended, 2)
    assert "version" in ended.said


@pytest.mark.parametrize("damage", [emptied, cut_off, overwritten])
def test_damaged_checkpoint_costs_time_only(
    damage: Callable[[Path], None],
    staged: dict[str, Path],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    workspace = copy_of(staged["train"], tmp_path)
    checkpoint = workspace / "train.checkpoint"
    shutil.copyfile(staged["done"] / "field.safetensors", checkpoint)
    damage(checkpoint)
    assert run("train", workspace, capsys).code == 0
    assert sha256_of(workspace / "field.safetensors") == sha256_of(staged["done"] / "field.safetensors")
    assert not checkpoint.exists()


def test_report_of_a_damaged_workspace(staged: dict[str, Path], tmp_path: Path) -> None:
    """What is damaged is left out of the report and named in it."""
    workspace = copy_of(staged["done"], tmp_path)
    for name in ("hex.vtk", "surface.ply", "singular_edges.vtp", "train.jsonl"):
        cut_off(workspace / name)
    assert run_command_line(["report", "-w", str(workspace), "-q"]) == 0
    notes = " ".join(json.loads((workspace / "report.json").read_text())["notes"])
    assert "hex.vtk" in notes
    assert "surface.ply" in notes

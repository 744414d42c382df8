"""From a surface to a hex mesh and back, as a user runs it: real fTetWild, real training, real executables."""

from __future__ import annotations

import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import psutil
import pytest

from neurframe_cli.cli.main import run_command_line
from neurframe_cli.field.field_file import read_field
from neurframe_cli.field.fra import read_fra
from neurframe_cli.mesh.read_cells import read_cells
from neurframe_cli.pipeline.atomic import sha256_of
from neurframe_cli.pipeline.manifest import read_manifest

SAMPLES = Path(__file__).parent.parent / "samples"
COARSE = ["--tet-edge-length", "0.15", "--threads", "1", "--no-pictures", "-q"]
ARTIFACTS = ("surface.ply", "tets.mesh", "features.json", "field.safetensors", "tets.fra", "cross.npz")


@pytest.fixture(scope="module")
def cube(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The workspace of the sample cube after `run --hex --scale 10`."""
    workspace = tmp_path_factory.mktemp("cube") / "cube.neurframe"
    arguments = ["run", str(SAMPLES / "cube.stl"), "--hex", "--scale", "10", "-w", str(workspace), *COARSE]
    assert run_command_line(arguments) == 0
    return workspace


def test_cube_becomes_a_regular_hex_mesh(cube: Path) -> None:
    mesh = read_cells(cube / "hex.vtk")
    # the edge asked for is sqrt(3)/10 of the side: six to a side
    assert len(mesh.cells) == 6**3
    numbers = read_manifest(cube).stages["hex"].report["mesh"]
    assert numbers["min_scaled_jacobian"] > 0.99
    assert numbers["feature_recall"] == 1.0
    assert numbers["volume_ratio"] == pytest.approx(1, abs=1e-3)


def test_field_of_a_cube_is_the_cube_s_own_frame(cube: Path) -> None:
    field = read_field(cube / "field.safetensors")
    frames = read_fra(cube / "tets.fra")
    # every axis within five degrees of a coordinate axis
    assert np.abs(frames).max(axis=2).min() > np.cos(np.radians(5))
    q = field.query(np.array([[0.5, 0.5, 0.5]]))
    assert q.shape == (1, 9)
    assert np.linalg.norm(q) == pytest.approx(1)


def test_second_run_skips_everything(cube: Path) -> None:
    before = {name: (cube / name).stat().st_mtime_ns for name in ARTIFACTS}
    arguments = ["run", str(SAMPLES / "cube.stl"), "--hex", "--scale", "10", "-w", str(cube), *COARSE]
    assert run_command_line(arguments) == 0
    assert {name: (cube / name).stat().st_mtime_ns for name in ARTIFACTS} == before


def test_another_scale_makes_only_the_mesh_again(cube: Path) -> None:
    trained = read_manifest(cube).stages["train"].started
    assert (
        run_command_line(["hex", "--scale", "5", "-w", str(cube), "-q", "-o", str(cube.parent / "out.vtu")])
        == 0
    )
    assert read_manifest(cube).stages["train"].started == trained
    assert len(read_cells(cube.parent / "out.vtu").cells) == 3**3


def test_field_is_asked_at_any_points(cube: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    points = tmp_path / "points.txt"
    points.write_text("0.5 0.5 0.5\n0.1, 0.2, 0.3\n")
    assert run_command_line(["discretize", "--points", str(points), "-w", str(cube), "-q"]) == 0
    with np.load(cube / "points.npz") as found:
        frames = found["frames"]
    assert frames.shape == (2, 3, 3)
    assert np.allclose(frames @ frames.transpose(0, 2, 1), np.eye(3), atol=1e-9)
    points.write_text("0.5 0.5\n")
    assert run_command_line(["discretize", "--points", str(points), "-w", str(cube)]) == 2
    assert "(n, 3) is needed" in capsys.readouterr().err


@pytest.mark.parametrize("spoil", [b"", b"no tensors", None])
def test_damaged_or_missing_field_is_one_clear_line(
    cube: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], spoil: bytes | None
) -> None:
    workspace = tmp_path / "copy"
    workspace.mkdir()
    for name in ("surface.ply", "tets.mesh", "features.json"):
        (workspace / name).write_bytes((cube / name).read_bytes())
    if spoil is not None:
        (workspace / "field.safetensors").write_bytes(spoil)
    assert run_command_line(["discretize", "-w", str(workspace), "--no-pictures"]) == 2
    assert "field.safetensors" in capsys.readouterr().err


def test_size_must_belong_to_one_mesh(capsys: pytest.CaptureFixture[str]) -> None:
    assert run_command_line(["run", str(SAMPLES / "cube.stl"), "--scale", "10"]) == 2
    assert "two would be made" in capsys.readouterr().err


def start(workspace: Path, *stage: str) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", "neurframe_cli", *stage, "-w", str(workspace), "--threads", "1", "-q"]
    return subprocess.Popen(command, stderr=subprocess.PIPE, start_new_session=True)


def hashes(workspace: Path, names: tuple[str, ...]) -> dict[str, str]:
    return {name: sha256_of(workspace / name) for name in names}


@pytest.mark.slow
@pytest.mark.parametrize("kill", range(2))
def test_killed_training_ends_with_the_same_weights(cube: Path, tmp_path: Path, kill: int) -> None:
    workspace = tmp_path / "copy"
    workspace.mkdir()
    for name in ("surface.ply", "tets.mesh", "features.json"):
        (workspace / name).write_bytes((cube / name).read_bytes())
    victim = start(workspace, "train")
    checkpoint, deadline = workspace / "train.checkpoint", time.monotonic() + 120
    while not checkpoint.exists() and time.monotonic() < deadline:
        time.sleep(0.02)
    time.sleep(random.Random(kill).random())
    os.kill(victim.pid, signal.SIGKILL)
    victim.communicate()
    assert victim.returncode == -signal.SIGKILL
    assert not (workspace / "field.safetensors").exists()
    again = start(workspace, "train")
    again.communicate(timeout=300)
    assert again.returncode == 0
    events = [json.loads(line)["event"] for line in (workspace / "train.jsonl").read_text().splitlines()]
    assert "resumed" in events
    assert hashes(workspace, ("field.safetensors",)) == hashes(cube, ("field.safetensors",))


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_interrupted_tetize_ends_with_130_and_no_orphan(tmp_path: Path, number: signal.Signals) -> None:
    workspace = tmp_path / "bracket.neurframe"
    victim = start(workspace, "tetize", str(SAMPLES / "bracket.stl"))
    deadline = time.monotonic() + 60
    children: list[psutil.Process] = []
    while not children and time.monotonic() < deadline:
        time.sleep(0.05)
        children = psutil.Process(victim.pid).children(recursive=True)
    assert children
    os.kill(victim.pid, number)
    _, said = victim.communicate(timeout=60)
    assert victim.returncode == 130
    assert b"Traceback" not in said
    assert (
        json.loads((workspace / "manifest.json").read_text())["stages"]["tetize"]["status"] == "interrupted"
    )
    assert psutil.wait_procs(children, timeout=60)[1] == []

"""A small workspace at every stage, damaged surroundings, and what must hold after any of it."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from neurframe_cli.cli.main import run_command_line
from neurframe_cli.pipeline.atomic import TEMPORARY_PREFIX, sha256_of
from neurframe_cli.pipeline.manifest import read_manifest

CUBE = Path(__file__).parent.parent / "samples" / "cube.stl"
STAGES = {
    "tetize": ["--edge-length", "0.3", "--epsilon", "0.01"],
    "train": ["--iterations", "20"],
    "discretize": ["--no-pictures"],
    "quad": ["--no-pictures", "--scale", "12"],
    "hex": ["--no-pictures", "--scale", "6"],
}
OUTPUTS = {
    "tetize": ("surface.ply", "tets.mesh", "features.json"),
    "train": ("field.safetensors",),
    "discretize": ("tets.fra", "frames.npz", "cross.npz", "cross.vtp", "singular_edges.vtp"),
    "quad": ("map.obj", "quad.obj"),
    "hex": ("map.hexex", "hex.vtk", "hex.mesh"),
}


@dataclass(frozen=True)
class Ended:
    """Exit code and standard error of a command."""

    code: int
    said: str


def words(stage: str, workspace: Path) -> list[str]:
    """`neurframe STAGE` on the cube, as arguments."""
    model = [str(CUBE)] if stage == "tetize" else []
    return [stage, *model, "-w", str(workspace), "-q", "--threads", "1", *STAGES[stage]]


def command(*arguments: str) -> list[str]:
    return [sys.executable, "-m", "neurframe_cli", *arguments]


def clean_environment(**changes: str) -> dict[str, str]:
    """This process's environment, in which the package is found from any folder."""
    found = os.pathsep.join(filter(None, [str(CUBE.parent.parent), os.environ.get("PYTHONPATH")]))
    installed = "site-packages" in str(Path(sys.modules["neurframe_cli"].__file__ or ""))
    return os.environ | ({} if installed else {"PYTHONPATH": found}) | changes


def neurframe(
    *arguments: str,
    cwd: Path | None = None,
    env: dict[str, str] | None = None,
    preexec_fn: Callable[[], None] | None = None,
) -> Ended:
    """A command in a process of its own, without a terminal; env: clean_environment() where none is given."""
    ended = subprocess.run(
        command(*arguments),
        cwd=cwd,
        env=clean_environment() if env is None else env,
        preexec_fn=preexec_fn,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        check=False,
        timeout=600,
    )
    return Ended(ended.returncode, ended.stderr.decode("utf-8", "backslashreplace"))


def assert_clear(ended: Ended, *codes: int) -> None:
    """One of the exit codes, and one line that says what is wrong, with at most a line on what to try."""
    assert ended.code in codes, ended.said
    assert "Traceback" not in ended.said
    assert "internal error" not in ended.said
    lines = [line for line in ended.said.splitlines() if line.startswith("neurframe: ")]
    assert len(lines) == 1, ended.said


def build(folder: Path) -> dict[str, Path]:
    """For each stage the workspace in which it can be run, and under "done" the one in which all were."""
    workspace, found = folder / "cube.neurframe", {}
    workspace.mkdir(parents=True)
    for stage in STAGES:
        found[stage] = folder / f"before-{stage}"
        shutil.copytree(workspace, found[stage])
        assert run_command_line(words(stage, workspace)) == 0
    return found | {"done": workspace}


def copy_of(workspace: Path, folder: Path) -> Path:
    """A workspace that a test may spoil."""
    return Path(shutil.copytree(workspace, folder / "cube.neurframe"))


def assert_whole(stage: str, workspace: Path, done: Path) -> None:
    """Every artifact is the whole one, or is not there; the manifest can be read."""
    stages = [*STAGES][: [*STAGES].index(stage) + 1]
    for name in (name for one in stages for name in OUTPUTS[one]):
        if (workspace / name).exists():
            assert sha256_of(workspace / name) == sha256_of(done / name), f"{name} is torn"
    record = read_manifest(workspace).stages.get(stage)
    assert record is None or record.status in ("running", "failed", "interrupted")


def assert_same(stage: str, workspace: Path, done: Path) -> None:
    """The stage's artifacts are those of an undisturbed run, and nothing else is left."""
    for name in OUTPUTS[stage]:
        assert sha256_of(workspace / name) == sha256_of(done / name), name
    assert read_manifest(workspace).stages[stage].status == "done"
    assert not list(workspace.glob(TEMPORARY_PREFIX + "*"))

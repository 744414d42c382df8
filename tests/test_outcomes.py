"""The page of outcomes is complete and true: each is brought about, with its exit code and one line."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import psutil
import pytest

from neurframe_cli import errors
from neurframe_cli.cli.main import COMMANDS, run_command_line
from neurframe_cli.pipeline.lock import exclusive

ROOT = Path(__file__).parent.parent
CUBE = ROOT / "samples" / "cube.stl"
PAGE = (ROOT / "docs" / "outcomes.md").read_text(encoding="utf-8")
TABLE = {name: int(code) for name, code in re.findall(r"^\| (\w+) \| (\d+) \|", PAGE, re.MULTILINE)}
COARSE = ("--edge-length", "0.3")

Outcome = tuple[int, str]


def neurframe(folder: Path, *words: object, **environment: str) -> Outcome:
    """Exit code and stderr of a command run in `folder`."""
    command = [sys.executable, "-m", "neurframe_cli", *map(str, words)]
    ended = subprocess.run(
        command, cwd=folder, env=os.environ | environment, capture_output=True, text=True, check=False
    )
    return ended.returncode, ended.stderr


def program(folder: Path, body: str) -> str:
    """An executable that does `body`."""
    path = folder / "program.sh"
    path.write_text(f"#!/bin/sh\n{body}\n")
    path.chmod(0o755)
    return str(path)


def with_extractor(folder: Path, body: str, *options: str) -> Outcome:
    """`neurframe hex` on a workspace of the cube, with another program in place of neurframe-hexex."""
    words = [
        "run",
        CUBE,
        "--hex",
        "--scale",
        "4",
        "-w",
        "cube.neurframe",
        "--tet-edge-length",
        "0.3",
        "--no-pictures",
    ]
    words += ["--method", "discrete", "--threads", "1", "-q", *options]
    return neurframe(folder, *words, NEURFRAME_HEXEX=program(folder, body))


def done(folder: Path) -> Outcome:
    return neurframe(folder, "tetize", CUBE, *COARSE)


def usage(folder: Path) -> Outcome:
    return neurframe(folder, "tetize", CUBE, "--edge-length", "-1")


def unreadable(folder: Path) -> Outcome:
    return neurframe(folder, "tetize", "missing.stl")


def unsupported(folder: Path) -> Outcome:
    (folder / "part.dwg").write_text("a drawing")
    return neurframe(folder, "tetize", "part.dwg")


def too_new(folder: Path) -> Outcome:
    (folder / "w.neurframe").mkdir()
    manifest = {"format": "neurframe-workspace", "version": 99, "stages": {}}
    (folder / "w.neurframe" / "manifest.json").write_text(json.dumps(manifest))
    return neurframe(folder, "tetize", CUBE, "-w", "w.neurframe")


def invalid_mesh(folder: Path) -> Outcome:
    (folder / "sheet.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    return neurframe(folder, "tetize", "sheet.obj")


def stage_error(folder: Path) -> Outcome:
    return with_extractor(folder, "echo 'program: error: the disk is gone' >&2; exit 3")


def child_crashed(folder: Path) -> Outcome:
    return with_extractor(folder, "kill -SEGV $$")


def child_out_of_memory(folder: Path) -> Outcome:
    hog = f"exec {sys.executable} -c 'import time; block = bytearray(1200 << 20); time.sleep(60)'"
    return with_extractor(folder, hog, "--memory", "1000")


def not_enough_memory(folder: Path) -> Outcome:
    return neurframe(folder, "tetize", CUBE, "--memory", "64")


def workspace_busy(folder: Path) -> Outcome:
    (folder / "w.neurframe").mkdir()
    with exclusive(folder / "w.neurframe"):
        return neurframe(folder, "tetize", CUBE, "-w", "w.neurframe")


def not_valid(folder: Path) -> Outcome:
    (folder / "folded.obj").write_text(
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\nf 1 2 3 4\nf 2 3 6 5\n"
    )
    return neurframe(folder, "check", "folded.obj", "--against", CUBE)


def timed_out(folder: Path) -> Outcome:
    return neurframe(folder, "tetize", CUBE, "--timeout", "0.01")


def interrupted(folder: Path) -> Outcome:
    command = [sys.executable, "-m", "neurframe_cli", "tetize", str(ROOT / "samples" / "bracket.stl")]
    running = subprocess.Popen(command, cwd=folder, stderr=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 120
    while not psutil.Process(running.pid).children() and time.monotonic() < deadline:
        time.sleep(0.05)
    running.send_signal(signal.SIGINT)
    said = running.communicate()[1]
    return running.returncode, said


MAKERS: dict[str, Callable[[Path], Outcome]] = {
    "done": done,
    "UsageError": usage,
    "UnreadableFile": unreadable,
    "UnsupportedFormat": unsupported,
    "TooNewFile": too_new,
    "InvalidMesh": invalid_mesh,
    "StageError": stage_error,
    "ChildCrashed": child_crashed,
    "ChildOutOfMemory": child_out_of_memory,
    "NotEnoughMemory": not_enough_memory,
    "WorkspaceBusy": workspace_busy,
    "NotValid": not_valid,
    "TimedOut": timed_out,
    "interrupted": interrupted,
}

# outcomes that share an exit code, told apart by what is said
SAYS = {
    "StageError": "the disk is gone",
    "ChildCrashed": "SIGSEGV",
    "ChildOutOfMemory": "allowed are 1000 MiB",
    "NotEnoughMemory": "would need about",
    "WorkspaceBusy": "in use by another neurframe process",
}


@pytest.mark.parametrize("outcome", MAKERS)
def test_outcome(outcome: str, tmp_path: Path) -> None:
    code, said = MAKERS[outcome](tmp_path)
    assert code == TABLE[outcome], said
    assert SAYS.get(outcome, "") in said
    assert "Traceback" not in said
    assert "internal error" not in said


def test_the_page_lists_every_outcome() -> None:
    assert set(TABLE) == set(MAKERS)
    concrete = {
        name
        for name, kind in vars(errors).items()
        if isinstance(kind, type) and issubclass(kind, errors.NeurframeError)
    }
    # bases that are never raised themselves, and what stands for Ctrl-C where no signal reaches
    assert concrete - {"NeurframeError", "InputError", "Cancelled"} <= set(TABLE)
    assert all(getattr(errors, name).exit_code == TABLE[name] for name in concrete & set(TABLE))


MISTAKES = {
    "a command that is not there": ["tetrahedralize"],
    "an option that is not there": ["quad", "--sacle", "30"],
    "an option without its value": ["hex", "--scale"],
    "a word for a number": ["train", "--sigma", "ten"],
    "a number out of range": ["--threads", "0", "train"],
    "a value that is no choice": ["run", "part.stl", "--quality", "best"],
    "no input": ["tetize"],
    "an input too many": ["tetize", "a.stl", "b.stl"],
    "an option that must be given": ["check", "mesh.vtk"],
    "a file name with a line end and a terminal control": ["tetize", "part\n\x1b[2J.stl"],
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_wrong_usage_is_one_line_and_what_to_try(mistake: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run_command_line(MISTAKES[mistake]) == TABLE["UsageError"]
    error, *hints = capsys.readouterr().err.splitlines()
    assert error.startswith("neurframe: error: ")
    assert error.isprintable()
    assert len(hints) <= 1
    assert all(hint.startswith("  try: ") for hint in hints)


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_says_what_is_wrong_with_an_option(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run_command_line([name, "--no-such-option"]) == TABLE["UsageError"]
    error, hint = capsys.readouterr().err.splitlines()
    assert error.startswith("neurframe: error: No such option '--no-such-option'")
    assert f"neurframe {name} --help" in hint

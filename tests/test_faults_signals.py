"""Ctrl-C, SIGTERM and programs that do not want to end, in every stage: 130, nothing left behind, and it goes on."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import psutil
import pytest
from faults import (
    STAGES,
    Ended,
    assert_clear,
    assert_same,
    assert_whole,
    clean_environment,
    command,
    copy_of,
    neurframe,
    words,
)

from neurframe_cli.errors import Cancelled, NeurframeError, StageError, TimedOut
from neurframe_cli.pipeline.manifest import read_manifest

PATIENCE_S = 180.0
# what makes a stage last until the signal comes: more work, or a program that never ends by itself
LONG = {"train": ["--iterations", "2000"], "discretize": ["--pictures"]}
ENDLESS = {"quad": "NEURFRAME_MIQ", "hex": "NEURFRAME_CUBECOVER"}


STUBBORN = """#!/bin/sh
trap '' TERM INT
echo $$ > "{folder}/pid"
while :; do sleep 1; done
"""

PATIENT = """#!/bin/sh
echo $$ > "{folder}/pid"
exec sleep 100000
"""


def program(folder: Path, text: str) -> str:
    """An executable of its own with that text; it writes its process id to `folder`/pid."""
    path = folder / "program.sh"
    path.write_text(text.format(folder=folder))
    path.chmod(0o755)
    return str(path)


def stubborn(folder: Path) -> str:
    """A program that ignores every signal that can be ignored."""
    return program(folder, STUBBORN)


def endless(folder: Path) -> str:
    """A program that ends when it is told to, and never before."""
    return program(folder, PATIENT)


def is_gone(pid: int) -> bool:
    return not psutil.pid_exists(pid) or psutil.Process(pid).status() == psutil.STATUS_ZOMBIE


def begun(folder: Path) -> bool:
    return (folder / "pid").exists() and (folder / "pid").read_text().strip() != ""


def wait_for(event: Callable[[], bool]) -> None:
    deadline = time.monotonic() + PATIENCE_S
    while not event():
        assert time.monotonic() < deadline, "what was waited for did not happen"
        time.sleep(0.01)


def is_running(stage: str, workspace: Path) -> bool:
    try:
        return read_manifest(workspace).stages[stage].status == "running"
    except (NeurframeError, KeyError):
        return False


def is_at_work(stage: str, workspace: Path) -> bool:
    return begun(workspace.parent) if stage in ENDLESS else is_running(stage, workspace)


def interrupted(stage: str, workspace: Path, number: signal.Signals) -> tuple[Ended, list[psutil.Process]]:
    """The command, sent a signal as soon as the stage is at work; and its children at that moment."""
    folder = workspace.parent
    child = subprocess.Popen(
        command(*words(stage, workspace), *LONG.get(stage, [])),
        env=clean_environment(**{ENDLESS[stage]: endless(folder)} if stage in ENDLESS else {}),
        stdin=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    wait_for(lambda: is_at_work(stage, workspace) or child.poll() is not None)
    children = psutil.Process(child.pid).children(recursive=True) if child.poll() is None else []
    child.send_signal(number)
    said = child.communicate(timeout=PATIENCE_S)[1]
    return Ended(child.returncode, said), children


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("stage", STAGES)
def test_interruption(stage: str, number: signal.Signals, staged: dict[str, Path], tmp_path: Path) -> None:
    for attempt in range(5):
        workspace = copy_of(staged[stage], tmp_path / str(attempt))
        ended, children = interrupted(stage, workspace, number)
        if ended.code != 0:  # or it was done before the signal came, which a busy machine may delay
            break
    assert_clear(ended, Cancelled.exit_code)
    assert "neurframe: interrupted" in ended.said
    assert psutil.wait_procs(children, timeout=PATIENCE_S)[1] == []
    # "running": the signal came between the manifest and the work
    assert read_manifest(workspace).stages[stage].status in ("interrupted", "running")
    assert_whole(stage, workspace, staged["done"])
    if number == signal.SIGTERM:  # once is enough
        assert neurframe(*words(stage, workspace)).code == 0
        assert_same(stage, workspace, staged["done"])


@pytest.mark.slow
@pytest.mark.parametrize("stage", ["quad", "hex"])
def test_a_program_that_ignores_term_is_ended_all_the_same(
    stage: str, staged: dict[str, Path], tmp_path: Path
) -> None:
    workspace = copy_of(staged[stage], tmp_path)
    environment = clean_environment(**{ENDLESS[stage]: stubborn(tmp_path)})
    child = subprocess.Popen(
        command(*words(stage, workspace)), env=environment, stderr=subprocess.PIPE, text=True
    )
    wait_for(lambda: begun(tmp_path))
    child.send_signal(signal.SIGTERM)
    said = child.communicate(timeout=PATIENCE_S)[1]
    assert_clear(Ended(child.returncode, said), Cancelled.exit_code)
    wait_for(lambda: is_gone(int((tmp_path / "pid").read_text())))


@pytest.mark.slow
def test_a_program_that_ignores_term_runs_into_the_time_limit(
    staged: dict[str, Path], tmp_path: Path
) -> None:
    workspace = copy_of(staged["hex"], tmp_path)
    environment = clean_environment(NEURFRAME_CUBECOVER=stubborn(tmp_path))
    ended = neurframe(*words("hex", workspace), "--timeout", "5", env=environment)
    assert_clear(ended, TimedOut.exit_code)
    wait_for(lambda: not begun(tmp_path) or is_gone(int((tmp_path / "pid").read_text())))


@pytest.mark.slow
def test_of_two_runs_in_one_workspace_one_is_refused(staged: dict[str, Path], tmp_path: Path) -> None:
    workspace = copy_of(staged["hex"], tmp_path)
    environment = clean_environment(NEURFRAME_CUBECOVER=stubborn(tmp_path))
    first = subprocess.Popen(
        command(*words("hex", workspace)), env=environment, stderr=subprocess.DEVNULL, start_new_session=True
    )
    try:
        wait_for(lambda: begun(tmp_path))
        for stage in ("tetize", "quad", "hex"):
            ended = neurframe(*words(stage, workspace))
            assert_clear(ended, StageError.exit_code)
            assert f"(pid {first.pid})" in ended.said
        report = neurframe("report", "-w", str(workspace))  # it only reads, and may be asked for at any time
        assert report.code == 0
        assert "unfinished" in (workspace / "report.html").read_text(encoding="utf-8")
    finally:
        os.kill(first.pid, signal.SIGKILL)
        first.wait()
    wait_for(lambda: is_gone(int((tmp_path / "pid").read_text())))
    assert neurframe(*words("hex", workspace)).code == 0
    assert_same("hex", workspace, staged["done"])


INTERRUPTED_TEXT = """
import neurframe_cli.cli.main as command_line
from neurframe_cli.__main__ import main

def interrupted(arguments):
    try:
        exec("import os, signal, time; os.kill(os.getpid(), signal.SIGINT); time.sleep(60)", {})
    except KeyboardInterrupt:
        print("caught")
        return 130

command_line.run_command_line = interrupted
main()
"""


def test_the_exit_code_is_130_where_the_signal_came_in_the_exec_of_a_text(tmp_path: Path) -> None:
    (tmp_path / "interrupted_text.py").write_text(INTERRUPTED_TEXT)
    environment = clean_environment()
    environment["PYTHONPATH"] = os.pathsep.join(filter(None, [str(tmp_path), environment.get("PYTHONPATH")]))
    ended = subprocess.run(
        [sys.executable, "-m", "interrupted_text"],
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (ended.returncode, ended.stdout) == (Cancelled.exit_code, "caught\n")

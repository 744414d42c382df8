"""`neurframe run` as a user meets it: plan, table, result lines, presets, interruption."""

from __future__ import annotations

import contextlib
import os
import pty
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import click
import psutil
import pytest

from neurframe_cli.cli.main import group, run_command_line
from neurframe_cli.pipeline.manifest import read_manifest

CUBE = Path(__file__).parent.parent / "samples" / "cube.stl"
OPTIONS = ["--quad", "--scale", "10", "--tet-edge-length", "0.2", "--iterations", "40", "--no-pictures"]
OPTIONS += ["--no-report", "--threads", "1"]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The workspace of the sample cube after `run --quad`."""
    workspace = tmp_path_factory.mktemp("run") / "cube.neurframe"
    assert run_command_line(["run", str(CUBE), "-w", str(workspace), *OPTIONS, "-q"]) == 0
    return workspace


def arguments(workspace: Path, *more: str) -> list[str]:
    return ["run", str(CUBE), "-w", str(workspace), *OPTIONS, *more]


def test_result_says_what_was_made_how_good_and_where(made: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run_command_line(arguments(made)) == 0
    said = capsys.readouterr().out
    numbers = read_manifest(made).stages["quad"].report["mesh"]
    assert "quads: valid" in said
    assert f"{numbers['cells']} quads" in said
    assert f"{numbers['min_scaled_jacobian']:.3f} (worst)" in said
    assert str(made / "quad.obj") in said


def test_plain_lines_elsewhere_and_none_with_quiet(made: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run_command_line(arguments(made)) == 0
    assert "tetize: unchanged, skipped" in capsys.readouterr().err
    assert run_command_line(arguments(made, "-q")) == 0
    assert capsys.readouterr().err == ""


def test_plan_tells_cached_stages_from_those_to_run(
    made: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    expected = ("tetize", "train", "discretize", "quad")
    before = (made / "manifest.json").stat().st_mtime_ns
    assert run_command_line(arguments(made, "--dry-run")) == 0
    cached = capsys.readouterr().out
    assert [line.split() for line in cached.splitlines()[:4]] == [[name, "cached"] for name in expected]
    assert run_command_line(arguments(made, "--dry-run", "--sigma", "5")) == 0
    changed = capsys.readouterr().out.splitlines()
    assert "cached" in changed[0]
    assert all("would run, about" in line for line in changed[1:4])
    assert "scaled by 2 earlier stages" in changed[4]
    nowhere = tmp_path / "new.neurframe"
    assert run_command_line(arguments(nowhere, "--dry-run")) == 0
    assert capsys.readouterr().out.count("would run") == 4
    assert not nowhere.exists()
    assert (made / "manifest.json").stat().st_mtime_ns == before


def test_plan_of_a_missing_input_is_a_clear_error(capsys: pytest.CaptureFixture[str]) -> None:
    assert run_command_line(["run", "missing.stl", "--dry-run"]) == 2
    assert "missing.stl" in capsys.readouterr().err


def test_terminal_shows_one_table_of_stages(made: Path) -> None:
    shown = on_terminal(arguments(made))
    for name in ("tetize", "train", "discretize", "quad"):
        assert re.search(rf"{name} +cached", shown)
    assert re.search(r"stage +state +progress +eta +time +peak MiB", shown)
    assert "unchanged, skipped" not in shown
    assert "cached" not in on_terminal(arguments(made, "-q"))


def on_terminal(command: list[str]) -> str:
    """What `neurframe COMMAND` writes to a terminal of 120 columns, without the control sequences."""
    terminal, inner = pty.openpty()
    process = subprocess.Popen(
        [sys.executable, "-m", "neurframe_cli", *command],
        stdin=inner,
        stdout=inner,
        stderr=inner,
        env={**os.environ, "TERM": "xterm", "COLUMNS": "120", "LINES": "40"},
    )
    os.close(inner)
    written = b""
    with os.fdopen(terminal, "rb", buffering=0) as screen, contextlib.suppress(OSError):
        while chunk := screen.read(1 << 16):  # Linux reports the end of a terminal as an OSError
            written += chunk
    assert process.wait() == 0
    return re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", written.decode())


def test_report_is_written_once_and_a_failing_one_spoils_no_mesh(
    made: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with monkeypatch.context() as patch:

        def broken(folder: Path) -> Path:
            raise ZeroDivisionError("what a pity")

        patch.setattr("neurframe_cli.pipeline.report_step.write_report", broken)
        assert run_command_line(arguments(made, "--report")) == 0
        assert "report.html was not written: ZeroDivisionError: what a pity" in capsys.readouterr().err
    assert run_command_line(arguments(made, "--report")) == 0
    assert str(made / "report.html") in capsys.readouterr().out
    written = (made / "report.html").stat().st_mtime_ns
    assert run_command_line(arguments(made, "--report")) == 0
    assert (made / "report.html").stat().st_mtime_ns == written


def parameters(*given: str) -> dict[str, Any]:
    """What the callback of `run` would get."""
    command = group.get_command(click.Context(group), "run")
    assert command is not None
    seen: dict[str, Any] = {}
    command.callback = lambda **values: seen.update(values)
    with command.make_context("run", ["part.stl", *given], click.Context(group)) as context:
        command.invoke(context)
    return seen


@pytest.fixture
def _restored_command() -> Any:
    command = group.get_command(click.Context(group), "run")
    assert command is not None
    callback = command.callback
    yield
    command.callback = callback


@pytest.mark.usefixtures("_restored_command")
def test_quality_sets_options_that_nobody_has_set(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    sizes = [parameters("--quality", name)["tet_edge_length"] for name in ("draft", "normal", "high")]
    assert sizes == sorted(sizes, reverse=True)
    assert len(set(sizes)) == 3
    assert parameters()["tet_edge_length"] == sizes[1]
    chosen = parameters("--quality", "draft", "--tet-edge-length", "0.03")
    assert (chosen["tet_edge_length"], chosen["pictures"]) == (0.03, False)
    # 0.025 is the default, but here it was asked for
    assert parameters("--quality", "draft", "--tet-edge-length", "0.025")["tet_edge_length"] == 0.025
    Path("neurframe.toml").write_text('[run]\nquality = "draft"\nepsilon = 0.01\n')
    configured = parameters()
    assert (configured["tet_edge_length"], configured["epsilon"]) == (sizes[0], 0.01)


@pytest.mark.slow
def test_interrupted_run_leaves_no_process_and_goes_on_where_it_was(tmp_path: Path) -> None:
    workspace = tmp_path / "cube.neurframe"
    command = [sys.executable, "-m", "neurframe_cli", *arguments(workspace, "--iterations", "400")]
    victim = subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL)
    deadline = time.monotonic() + 300
    while not (workspace / "train.checkpoint").exists() and time.monotonic() < deadline:
        time.sleep(0.02)
    children = psutil.Process(victim.pid).children(recursive=True)
    victim.send_signal(signal.SIGINT)
    _, said = victim.communicate(timeout=120)
    assert victim.returncode == 130
    assert b"interrupted" in said
    assert b"Traceback" not in said
    assert psutil.wait_procs(children, timeout=60)[1] == []
    assert read_manifest(workspace).stages["train"].status == "interrupted"
    assert run_command_line([*arguments(workspace, "--iterations", "400"), "-q"]) == 0
    assert '"event": "resumed"' in (workspace / "train.jsonl").read_text()

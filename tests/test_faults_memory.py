"""Memory: every stage says how much it takes, refuses what does not fit, and stops at its limit; peaks are its own."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import pytest
from faults import CUBE, STAGES, Ended, assert_clear, assert_same, assert_whole, copy_of, words

from neurframe_cli.cli.main import run_command_line
from neurframe_cli.errors import NotEnoughMemory
from neurframe_cli.mesh.arrays import silent
from neurframe_cli.pipeline import memory
from neurframe_cli.pipeline.forecast import Amount
from neurframe_cli.pipeline.manifest import read_manifest
from neurframe_cli.pipeline.memory import expected_mib, refuse_too_large
from neurframe_cli.pipeline.runner import StageContext, Step, run_stage
from neurframe_cli.pipeline.workspace import Workspace
from neurframe_cli.process import run_child
from neurframe_cli.process.memory import free_mib, high_water_mib


@pytest.mark.parametrize("stage", STAGES)
def test_a_stage_that_does_not_fit_is_not_begun(
    stage: str, staged: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    workspace = copy_of(staged[stage], tmp_path)
    said = Ended(run_command_line([*words(stage, workspace), "--memory", "64"]), capsys.readouterr().err)
    assert_clear(said, NotEnoughMemory.exit_code)
    assert f"{stage} would need about" in said.said
    assert "64 MiB are allowed" in said.said
    assert "--memory" in said.said.splitlines()[1]
    assert_whole(stage, workspace, staged["done"])
    assert run_command_line(words(stage, workspace)) == 0
    assert_same(stage, workspace, staged["done"])


@pytest.mark.parametrize("stage", STAGES)
def test_a_stage_stops_at_its_limit(
    stage: str,
    staged: dict[str, Path],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Where the estimate was too low: this process has more than 64 MiB already."""
    monkeypatch.setattr(memory, "_NEEDS", {name: {"constant": 1.0} for name in STAGES})
    workspace = copy_of(staged[stage], tmp_path)
    ended = Ended(run_command_line([*words(stage, workspace), "--memory", "64"]), capsys.readouterr().err)
    assert_clear(ended, NotEnoughMemory.exit_code)
    assert f"{stage} was stopped: it used" in ended.said
    assert_whole(stage, workspace, staged["done"])


@pytest.mark.parametrize("stage", STAGES)
def test_the_manifest_has_estimate_and_peak(stage: str, staged: dict[str, Path]) -> None:
    record = read_manifest(staged["done"]).stages[stage]
    assert record.expected_mib > 0
    assert record.peak_mib > 0


def test_estimates_grow_with_the_amount_and_stay_finite() -> None:
    for stage in STAGES:
        small, large = (expected_mib(stage, Amount(n, n, n, n)) for n in (1e3, 1e6))
        assert 0 < small < large < 1e6
    passed_through = Amount(1e6, is_surface=False)
    assert expected_mib("tetize", passed_through) < expected_mib("tetize", Amount(1e6, 1e6))


def test_what_is_free_decides_where_nobody_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(memory, "free_mib", lambda: 1000.0)
    monkeypatch.setattr(memory, "resident_now_mib", lambda: 200.0)
    refuse_too_large("hex", 1100.0, None)
    with pytest.raises(NotEnoughMemory, match="1200 MiB are free"):
        refuse_too_large("hex", 1300.0, None)
    refuse_too_large("hex", 1300.0, 2000.0)  # whoever says more gets more


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="control groups are Linux's")
def test_a_control_group_s_limit_counts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A container of 100 MiB, of which 60 are taken, 10 of them by files that nobody has open."""
    from neurframe_cli.process import memory as process_memory

    machine = free_mib()
    group = next(
        (line[3:] for line in Path("/proc/self/cgroup").read_text().splitlines() if line.startswith("0::")),
        None,
    )
    if group is None:
        pytest.skip("this system has no control groups of version 2")
    (tmp_path / "memory.max").write_text(f"{100 << 20}\n")
    (tmp_path / "memory.current").write_text(f"{60 << 20}\n")
    (tmp_path / "memory.stat").write_text(f"anon 5\ninactive_file {10 << 20}\n")
    monkeypatch.setattr(process_memory, "_CGROUPS", tmp_path)
    assert free_mib() == 50.0 < machine


def stage_of(name: str, mib: int) -> Step:
    """A stage whose child takes so much memory."""

    def work(context: StageContext) -> dict[str, int]:
        run_child([sys.executable, "-c", f"block = bytearray({mib} << 20)"], name="child")
        return {}

    return Step(name, 1, {}, (), {}, work)


def test_each_stage_has_the_peak_of_its_own_children(tmp_path: Path) -> None:
    """The system knows only the largest child that there ever was."""
    for name, mib in (("large", 600), ("small", 50)):
        run_stage(Workspace(tmp_path), stage_of(name, mib), silent)
    stages = read_manifest(tmp_path).stages
    assert stages["large"].peak_mib - stages["small"].peak_mib > 500


def test_a_child_is_not_charged_with_the_memory_of_its_parent() -> None:
    """Between fork and exec it is a copy of us, which the system counts as its own."""
    block = bytearray(400 << 20)
    block[:: 1 << 12] = b"x" * len(block[:: 1 << 12])
    assert high_water_mib() > 400
    assert run_child([sys.executable, "-c", "import time; time.sleep(0.5)"], name="child").peak_mib < 200
    assert len(block) == 400 << 20


def test_the_plan_says_how_much_memory(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copyfile(CUBE, tmp_path / "cube.stl")
    workspace = str(tmp_path / "new.neurframe")
    assert run_command_line(["run", str(tmp_path / "cube.stl"), "-w", workspace, "--dry-run"]) == 0
    stages = [line for line in capsys.readouterr().out.splitlines() if "would run" in line]
    assert len(stages) == 5
    assert all(line.endswith(" MiB") for line in stages)

"""The live tables: what they say of a stage and of a batch at each moment."""

from __future__ import annotations

import io
import time

import pytest
from rich.console import Console as RichConsole

from neurframe_cli.batch.outcome import Outcome
from neurframe_cli.cli.batch_table import counts, table_lines
from neurframe_cli.cli.stage_table import StageTable
from neurframe_cli.pipeline.manifest import StageRecord


def shown(table: StageTable) -> list[str]:
    screen = io.StringIO()
    RichConsole(width=120, file=screen).print(table)
    return screen.getvalue().splitlines()


def test_a_stage_waits_runs_and_ends() -> None:
    table = StageTable(["tetize", "train"])
    row = table.rows["train"]
    assert "waiting" in shown(table)[2]
    with table.running("train") as progress:
        row.began = time.monotonic() - 10
        assert row.eta_s() is None  # nothing is known yet
        progress(0.25, "round [1]")
        assert row.eta_s() == pytest.approx(30, rel=0.1)
        line = shown(table)[2]
        assert "running" in line
        assert "round [1]" in line  # no markup of rich's
        assert row.peak_mib > 10
        assert row.peak_mib < 1e5
    table.ended(
        "train", StageRecord("done", "key", seconds=75.4, peak_mib=1234.0), skipped=False, said="good"
    )
    line = shown(table)[2]
    assert all(part in line for part in ("done", "0:01:15", "1,234", "good"))
    assert row.eta_s() is None


@pytest.mark.parametrize(
    ("status", "skipped", "state"),
    [("done", False, "done"), ("done", True, "cached"), ("invalid", False, "not valid")],
)
def test_results_have_states(status: str, skipped: bool, state: str) -> None:
    table = StageTable(["hex"])
    table.ended("hex", StageRecord(status, "key"), skipped=skipped, said="")
    assert state in shown(table)[1]


@pytest.mark.parametrize(("error", "state"), [(ValueError, "failed"), (KeyboardInterrupt, "interrupted")])
def test_what_ends_a_stage_early_is_seen(error: type[BaseException], state: str) -> None:
    table = StageTable(["hex"])
    with pytest.raises(error), table.running("hex"):
        raise error
    assert state in shown(table)[1]


def test_batch_table_has_a_line_for_each_model_in_columns() -> None:
    good = Outcome(
        "/m/a.stl", "/w/a", "valid", 0, "", 1, "h", tets=1234, seconds=3.6, peak_mib=99.5,
        meshes={"hex": {"cells": 27, "min_scaled_jacobian": 0.5}},
    )  # fmt: skip
    bad = Outcome("/m/longer.stl", "/w/b", "timed out", None, "too slow", 2, "h")
    head, first, second = table_lines([good, bad])
    assert first.split() == ["a.stl", "valid", "1,234", "27", "0.500", "4", "100"]
    assert second.split() == ["longer.stl", "timed", "out", "0", "0", "too", "slow"]
    assert first.index("27") + 2 == head.index("hexes") + 5
    assert counts([good, bad, good]) == "2 valid, 1 timed out"
    assert table_lines([]) == []

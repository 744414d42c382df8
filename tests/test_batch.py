"""Batches: one outcome for every model, whatever happens to its job."""

from __future__ import annotations

import csv
import dataclasses
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest
from batch_jobs import began, script_job

from neurframe_cli.batch.inputs import Shard, find_models, parse_shard, take_shard, workspace_names
from neurframe_cli.batch.job import run_job
from neurframe_cli.batch.outcome import Outcome, from_line, to_line
from neurframe_cli.batch.pool import PoolOptions
from neurframe_cli.batch.results import open_results, read_results
from neurframe_cli.batch.run_batch import run_batch
from neurframe_cli.cli.main import run_command_line
from neurframe_cli.errors import (
    Cancelled,
    NeurframeError,
    TooNewFile,
    UnreadableFile,
    UsageError,
    WorkspaceBusy,
)

CUBE = Path(__file__).parent.parent / "samples" / "cube.stl"
OUTCOME = Outcome(
    "/m/a.stl", "/w/a.neurframe", "valid", 0, "", 1, "here", ["--quad"], 3.5, meshes={"quad": {"cells": 6}}
)


def test_inputs_become_one_list_without_repetition(tmp_path: Path) -> None:
    for name in ("a.stl", "b.obj", "deep/c.off", "notes.md"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    (tmp_path / "deep" / "list.txt").write_text("# of models\nc.off\n../*.stl  # a glob\nmissing.stl\n")
    everything = [tmp_path / name for name in ("a.stl", "b.obj", "deep/c.off")]
    assert find_models([str(tmp_path)]) == everything
    assert find_models([str(tmp_path / "**/*.o*"), str(tmp_path / "b.obj")]) == everything[1:]
    listed = find_models([str(tmp_path / "deep" / "list.txt")])
    assert listed == [everything[0], everything[2], tmp_path / "deep" / "missing.stl"]


@pytest.mark.parametrize("wrong", ["nothing/*.stl", "empty", "thingi10k:cube", "missing.txt"])
def test_inputs_that_stand_for_nothing_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, wrong: str
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("empty").mkdir()
    with pytest.raises(NeurframeError, match=wrong.replace("*", r"\*")):
        find_models([wrong])


def test_thingi10k_models_are_found_by_number(tmp_path: Path) -> None:
    (tmp_path / "more").mkdir()
    for name in ("65004.stl", "more/thingi10k_472042.obj", "165004.stl"):
        (tmp_path / name).touch()
    found = find_models(["thingi10k:65004", "thingi10k:472042", "thingi10k:7"], tmp_path)
    assert found == [tmp_path / name for name in ("65004.stl", "7.stl", "more/thingi10k_472042.obj")]
    with pytest.raises(UsageError, match="no folder"):
        find_models(["thingi10k:65004"], tmp_path / "missing")


def test_shards_share_the_models_out() -> None:
    models = [Path(f"/m/{i}.stl") for i in range(7)]
    parts = [take_shard(models, parse_shard(f"{k}/3")) for k in (1, 2, 3)]
    assert sorted(model for part in parts for model in part) == models
    assert max(map(len, parts)) - min(map(len, parts)) <= 1
    assert take_shard(models, Shard()) == models


@pytest.mark.parametrize("text", ["0/3", "4/3", "1", "1/0", "-1/3", "a/b"])
def test_wrong_shards_are_refused(text: str) -> None:
    with pytest.raises(UsageError, match="k/n"):
        parse_shard(text)


def test_models_of_the_same_name_get_workspaces_of_their_own() -> None:
    models = [Path("/a/x/part.stl"), Path("/b/x/part.stl"), Path("/b/x/part.obj"), Path("/b/other.stl")]
    names = workspace_names(models)
    assert names[models[3]] == "other"
    assert len(set(names.values())) == 4
    assert all(name.startswith("x-part-") for model, name in names.items() if model.stem == "part")


@pytest.mark.parametrize(
    ("script", "outcome", "code", "message"),
    [
        ("", "valid", 0, ""),
        (
            "import sys; print('neurframe: error: two cells', file=sys.stderr); sys.exit(4)",
            "invalid",
            4,
            "two cells",
        ),
        ("import sys; sys.exit('no mesh') if 0 else sys.exit(2)", "unusable", 2, ""),
        ("import sys; sys.exit(3)", "failed", 3, ""),
        ("raise RuntimeError('what a pity')", "crashed", 1, "RuntimeError: what a pity"),
        ("import os, signal; os.kill(os.getpid(), signal.SIGSEGV)", "crashed", -11, ""),
        ("import time; time.sleep(60)", "timed out", None, "stopped after"),
        ("import time; block = b'x' * (300 << 20); time.sleep(60)", "out of memory", None, "allowed are"),
    ],
)
def test_every_end_of_a_job_has_its_outcome(
    tmp_path: Path, script: str, outcome: str, code: int | None, message: str
) -> None:
    # on a loaded machine Python itself may take seconds to start: only the job that shall time out gets few
    limit = 1.0 if outcome == "timed out" else 60.0
    came = run_job(script_job(tmp_path, "job", script, timeout_s=limit, memory_mib=200))
    assert (came.outcome, came.exit_code) == (outcome, code)
    assert message in came.message
    assert from_line(to_line(came), "here") == came


def test_job_that_is_killed_from_outside_is_started_again_but_not_for_ever(tmp_path: Path) -> None:
    once = f"""
        from pathlib import Path; import signal
        mark = Path({str(tmp_path / "mark")!r})
        if not mark.exists():
            mark.touch()
            os.kill(os.getpid(), signal.SIGKILL)
    """
    came = run_job(script_job(tmp_path, "once", once))
    assert (came.outcome, came.attempts) == ("valid", 2)
    always = "import signal; os.kill(os.getpid(), signal.SIGKILL)"
    came = run_job(script_job(tmp_path, "always", always, attempts=3))
    assert (came.outcome, came.exit_code, came.attempts) == ("crashed", -signal.SIGKILL, 3)
    assert len(began(tmp_path, "always")) == 3


def test_all_jobs_of_a_local_batch_end_once(tmp_path: Path) -> None:
    codes = [0, 4, 0, 3, 2, 0]
    jobs = [script_job(tmp_path, f"j{i}", f"raise SystemExit({code})") for i, code in enumerate(codes)]
    came: list[Outcome] = []
    run_batch(jobs, PoolOptions(jobs=3), came.append)
    assert sorted(Path(outcome.model).stem for outcome in came) == [f"j{i}" for i in range(6)]
    assert {Path(o.model).stem: o.exit_code for o in came} == {f"j{i}": code for i, code in enumerate(codes)}


def test_leaving_a_batch_ends_its_children(tmp_path: Path) -> None:
    jobs = [script_job(tmp_path, f"j{i}", "import time; time.sleep(600)", timeout_s=None) for i in range(4)]

    def interrupt_when_two_run() -> None:
        if began(tmp_path, "j0") and began(tmp_path, "j1"):
            raise KeyboardInterrupt

    came: list[Outcome] = []
    with pytest.raises(KeyboardInterrupt):
        run_batch(jobs, PoolOptions(jobs=2), came.append, interrupt_when_two_run)
    assert came == []
    assert not any(psutil.pid_exists(began(tmp_path, name)[0][0]) for name in ("j0", "j1"))
    assert not began(tmp_path, "j2")


def test_stopped_job_is_cancelled(tmp_path: Path) -> None:
    with pytest.raises(Cancelled, match="stopped"):
        run_job(
            script_job(tmp_path, "job", "import time; time.sleep(600)"), lambda: bool(began(tmp_path, "job"))
        )


def test_results_survive_a_torn_last_line(tmp_path: Path) -> None:
    path = tmp_path / "results.jsonl"
    with open_results(path) as results:
        results.append(OUTCOME)
    whole = path.read_bytes()
    path.write_bytes(whole + whole[:40])
    assert read_results([path]) == {OUTCOME.model: OUTCOME}
    other = dataclasses.replace(OUTCOME, model="/m/b.stl")
    with open_results(path) as results:
        results.append(other)
    assert read_results([path]) == {OUTCOME.model: OUTCOME, other.model: other}


def test_results_have_one_writer_and_are_checked(tmp_path: Path) -> None:
    path = tmp_path / "results.jsonl"
    with open_results(path), pytest.raises(WorkspaceBusy, match="another batch"), open_results(path):
        pass
    path.write_text('{"version": 1}\n')
    with pytest.raises(UnreadableFile, match="line 1"):
        read_results([path])
    path.write_text(to_line(OUTCOME).replace('"version": 1', '"version": 2'))
    with pytest.raises(TooNewFile):
        read_results([path])


@pytest.fixture
def models(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A list of a cube, a file that is no mesh, and one that is missing."""
    monkeypatch.chdir(tmp_path)
    Path("bad.stl").write_text("this is no mesh")
    Path("models.txt").write_text(f"{CUBE}\nbad.stl\nmissing.stl\n")
    return Path("models.txt")


TINY = [
    "--quad",
    "--scale",
    "8",
    "--tet-edge-length",
    "0.3",
    "--method",
    "discrete",
    "--no-pictures",
    "--no-report",
]


def test_batch_from_list_to_tables(models: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["batch", str(models), "-o", "out", "--threads", "1", *TINY]
    assert run_command_line(command) == 4
    said = capsys.readouterr()
    assert "1 valid, 2 unusable" in said.out
    assert "2 of 3 models have no valid mesh" in said.err
    outcomes = {Path(o.model).name: o for o in read_results([Path("out/results.jsonl")]).values()}
    assert {name: o.outcome for name, o in outcomes.items()} == {
        "cube.stl": "valid",
        "bad.stl": "unusable",
        "missing.stl": "unusable",
    }
    assert outcomes["cube.stl"].meshes["quad"]["valid"] is True
    assert outcomes["cube.stl"].tets
    with Path("out/results.csv").open() as table:
        rows = {Path(row["model"]).name: row for row in csv.DictReader(table)}
    assert rows["cube.stl"]["quads"] == str(outcomes["cube.stl"].meshes["quad"]["cells"])
    assert "missing.stl" in rows["missing.stl"]["message"]
    assert "cube.stl" in Path("out/summary.html").read_text()
    lines = Path("out/results.jsonl").read_text()
    assert run_command_line(command) == 2  # nothing is done twice by mistake
    assert run_command_line([*command, "--resume", "--scale", "9"]) == 2
    assert run_command_line([*command, "--resume"]) == 4
    assert Path("out/results.jsonl").read_text() == lines


def test_shards_write_files_of_their_own_and_one_table(models: Path) -> None:
    models.write_text("bad.stl\nmissing.stl\n")
    for shard in ("1/2", "2/2"):
        assert run_command_line(["batch", str(models), "-o", "out", "--shard", shard, "-q", *TINY]) == 4
    parts = [Path(f"out/results.{k}-of-2.jsonl") for k in (1, 2)]
    assert [len(read_results([part])) for part in parts] == [1, 1]
    assert len(Path("out/results.csv").read_text().splitlines()) == 3


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--scale", "10"], "two would be made"),
        (["--quad", "--scale", "10", "--edge-length", "1"], "only one of"),
        (["--shard", "3/2"], "k/n"),
        (["--scheduler", "tcp://127.0.0.1:1"], "no Dask scheduler|pip install"),
    ],
)
def test_mistakes_are_one_error_before_any_job(
    models: Path, capsys: pytest.CaptureFixture[str], options: list[str], says: str
) -> None:
    models.write_text("bad.stl\n")
    code = run_command_line(["batch", str(models), "-o", "out", *options])
    said = capsys.readouterr().err
    assert code in (2, 3)
    assert any(part in said for part in says.split("|"))
    assert not list(Path("out").glob("*.neurframe"))


def test_config_file_options_reach_the_jobs(models: Path) -> None:
    models.write_text("bad.stl\n")
    Path("neurframe.toml").write_text('[batch]\nquality = "draft"\npictures = false\n')
    assert run_command_line(["batch", str(models), "-o", "out", "-q"]) == 4
    (outcome,) = read_results([Path("out/results.jsonl")]).values()
    assert outcome.options == ["--quality", "draft", "--no-pictures"]


@pytest.mark.slow
def test_killed_batch_leaves_no_process_and_is_resumed(models: Path) -> None:
    models.write_text(f"bad.stl\n{CUBE}\n")
    command = ["batch", str(models), "-o", "out", "--threads", "1", *TINY, "--iterations", "400"]
    command[command.index("discrete")] = "neural"
    victim = subprocess.Popen([sys.executable, "-m", "neurframe_cli", *command], stderr=subprocess.DEVNULL)
    results, manifest = Path("out/results.jsonl"), Path("out/cube.neurframe/manifest.json")
    deadline = time.monotonic() + 300
    children: list[psutil.Process] = []
    while time.monotonic() < deadline and not (
        children and results.exists() and results.read_text() and manifest.exists()
    ):
        time.sleep(0.05)
        children = psutil.Process(victim.pid).children(recursive=True)
    assert children
    os.kill(victim.pid, signal.SIGKILL)
    victim.wait()
    assert psutil.wait_procs(children, timeout=120)[1] == []
    assert len(read_results([results])) == 1
    assert run_command_line([*command, "--resume", "-q"]) == 4
    assert sorted(o.outcome for o in read_results([results]).values()) == ["unusable", "valid"]
    assert len([json.loads(line) for line in results.read_text().splitlines()]) == 2

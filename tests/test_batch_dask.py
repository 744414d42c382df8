"""Batches on Dask workers of this machine: workers and schedulers die, outcomes do not."""

from __future__ import annotations

import contextlib
import os
import signal
import stat
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import psutil
import pytest

pytest.importorskip("distributed", reason="the extra `batch` (Dask) is not installed")

from batch_jobs import began, script_job
from distributed import Client

from neurframe_cli.batch.outcome import Outcome
from neurframe_cli.batch.pool import PoolOptions, open_pool
from neurframe_cli.batch.run_batch import run_batch
from neurframe_cli.errors import StageError

# tornado and Dask warn of connections that die, which is what these tests are about
pytestmark = [pytest.mark.filterwarnings("default"), pytest.mark.slow]
PATIENCE_S = 120.0


@contextlib.contextmanager
def dask_program(*arguments: str) -> Iterator[subprocess.Popen[bytes]]:
    """`dask scheduler` or `dask worker` for the time of the block."""
    command = [sys.executable, "-m", "dask", *arguments]
    program = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        yield program
    finally:
        program.kill()
        program.wait()


@contextlib.contextmanager
def scheduler(folder: Path, port: int = 0) -> Iterator[tuple[subprocess.Popen[bytes], str]]:
    """A scheduler on loopback and its address."""
    where = folder / "scheduler.json"
    where.unlink(missing_ok=True)
    options = ("--host", "127.0.0.1", "--port", str(port), "--no-dashboard", "--scheduler-file", str(where))
    with dask_program("scheduler", *options) as program:
        until(where.exists)
        yield program, where.read_text().split('"address": "')[1].split('"')[0]


def worker(address: str) -> contextlib.AbstractContextManager[subprocess.Popen[bytes]]:
    """A worker of one thread."""
    return dask_program("worker", address, "--nthreads", "1", "--no-nanny", "--no-dashboard")


def until(happened: Callable[[], bool]) -> None:
    deadline = time.monotonic() + PATIENCE_S
    while not happened():
        assert time.monotonic() < deadline
        time.sleep(0.05)


def names(outcomes: list[Outcome]) -> list[str]:
    return sorted(Path(outcome.model).stem for outcome in outcomes)


def test_a_killed_worker_costs_no_outcome(tmp_path: Path) -> None:
    jobs = [script_job(tmp_path, f"j{i}", "import time; time.sleep(1)") for i in range(8)]
    came: list[Outcome] = []
    killed: list[tuple[str, int, int]] = []

    with scheduler(tmp_path) as (_, address), worker(address) as first, worker(address) as second:

        def kill_the_first_worker_at_work() -> None:
            """SIGKILL, as soon as both work: whichever runs j-something as the first."""
            at_work = {pid for i in range(8) for _, pid in began(tmp_path, f"j{i}")}
            if killed or at_work != {first.pid, second.pid}:
                return
            ended = names(came)
            for name in (f"j{i}" for i in range(8)):
                attempts = began(tmp_path, name)
                if attempts and attempts[-1][1] == first.pid and name not in ended:
                    os.kill(first.pid, signal.SIGKILL)
                    killed.append((name, *attempts[-1]))
                    return

        run_batch(jobs, PoolOptions(address), came.append, kill_the_first_worker_at_work)
    assert killed
    assert names(came) == [f"j{i}" for i in range(8)]
    assert {outcome.outcome for outcome in came} == {"valid"}
    assert not psutil.pid_exists(killed[0][1])


def test_outcomes_outlive_the_scheduler_and_the_rest_is_done_by_the_next(tmp_path: Path) -> None:
    jobs = [script_job(tmp_path, f"j{i}", "import time; time.sleep(1)") for i in range(4)]
    came: list[Outcome] = []
    with contextlib.ExitStack() as stack:
        first, address = stack.enter_context(scheduler(tmp_path))
        stack.enter_context(worker(address))
        port = int(address.rpartition(":")[2])

        def replace_the_scheduler() -> None:
            if came and first.poll() is None:
                first.kill()
                first.wait()
                stack.enter_context(scheduler(tmp_path, port))
                stack.enter_context(worker(address))

        run_batch(jobs, PoolOptions(address), came.append, replace_the_scheduler, patience_s=PATIENCE_S)
    assert first.returncode == -signal.SIGKILL
    assert names(came) == [f"j{i}" for i in range(4)]
    assert {outcome.outcome for outcome in came} == {"valid"}


def test_a_client_that_fails_in_closing_hides_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As it may while it tries to reach a lost scheduler again."""
    close = Client.close

    def close_and_fail(client: Client, *arguments: Any, **options: Any) -> None:
        close(client, *arguments, **options)
        raise RuntimeError("ConnectionPool is closed")

    monkeypatch.setattr(Client, "close", close_and_fail)
    with (
        scheduler(tmp_path) as (_, address),
        pytest.raises(KeyError, match="the reason"),
        open_pool(PoolOptions(address)),
    ):
        raise KeyError("the reason")


def test_without_a_scheduler_the_batch_ends_and_can_be_resumed(tmp_path: Path) -> None:
    jobs = [script_job(tmp_path, f"j{i}", "import time; time.sleep(1)") for i in range(3)]
    came: list[Outcome] = []
    with (
        scheduler(tmp_path) as (program, address),
        worker(address),
        pytest.raises(StageError, match="without an outcome") as raised,
    ):
        run_batch(
            jobs, PoolOptions(address), came.append, lambda: program.kill() if came else None, patience_s=0
        )
    assert "--resume" in (raised.value.hint or "")
    rest = [job for job in jobs if str(job.model) not in {outcome.model for outcome in came}]
    assert rest
    run_batch(rest, PoolOptions(jobs=2), came.append)
    assert names(came) == ["j0", "j1", "j2"]


def test_interrupted_batch_stops_its_jobs_on_the_workers(tmp_path: Path) -> None:
    jobs = [script_job(tmp_path, f"j{i}", "import time; time.sleep(600)", timeout_s=None) for i in range(2)]

    def interrupt_when_one_runs() -> None:
        if began(tmp_path, "j0"):
            raise KeyboardInterrupt

    with scheduler(tmp_path) as (_, address), worker(address):
        with pytest.raises(KeyboardInterrupt):
            run_batch(jobs, PoolOptions(address), lambda outcome: None, interrupt_when_one_runs)
        until(lambda: not psutil.pid_exists(began(tmp_path, "j0")[0][0]))
    assert not began(tmp_path, "j1")


def test_workers_on_loopback_are_started_for_the_batch(tmp_path: Path) -> None:
    jobs = [script_job(tmp_path, f"j{i}") for i in range(3)]
    came: list[Outcome] = []
    run_batch(jobs, PoolOptions("loopback", jobs=2), came.append)
    assert names(came) == ["j0", "j1", "j2"]
    assert os.getpid() not in {pid for i in range(3) for _, pid in began(tmp_path, f"j{i}")}


# what dask-jobqueue needs of Slurm: submit a script, of which Slurm keeps a copy, say its number; cancel by number
SBATCH = """#!/bin/sh
cp "$1" {folder}/script.$$
setsid sh {folder}/script.$$ > /dev/null 2>&1 &
echo $! >> {folder}/submitted
echo "Submitted batch job $!"
"""
SCANCEL = """#!/bin/sh
kill -- -"$1"
"""


@pytest.fixture
def slurm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> PoolOptions:
    """dask-jobqueue and its real scripts; there is no Slurm here, only its two commands."""
    pytest.importorskip("dask_jobqueue", reason="the extra `batch` (dask-jobqueue) is not installed")
    for name, text in (("sbatch", SBATCH), ("scancel", SCANCEL)):
        (tmp_path / name).write_text(text.format(folder=tmp_path))
        (tmp_path / name).chmod(stat.S_IRWXU)
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    monkeypatch.chdir(tmp_path)
    return PoolOptions("slurm", jobs=1, threads=1, memory_mib=500)


def submitted_to_slurm(folder: Path) -> list[int]:
    return [int(pid) for pid in (folder / "submitted").read_text().split()]


def not_for_ever() -> Callable[[], None]:
    deadline = time.monotonic() + 900

    def tick() -> None:
        assert time.monotonic() < deadline, "the batch does not end"

    return tick


def test_slurm_jobs_are_submitted_and_cancelled(tmp_path: Path, slurm: PoolOptions) -> None:
    jobs = [script_job(tmp_path, f"j{i}") for i in range(3)]
    came: list[Outcome] = []
    run_batch(jobs, slurm, came.append, not_for_ever())
    assert names(came) == ["j0", "j1", "j2"]
    (submitted,) = submitted_to_slurm(tmp_path)
    until(lambda: not psutil.pid_exists(submitted))


def test_a_lost_slurm_job_is_submitted_again(tmp_path: Path, slurm: PoolOptions) -> None:
    import dask

    jobs = [script_job(tmp_path, f"j{i}", "import time; time.sleep(3)") for i in range(2)]
    came: list[Outcome] = []
    bounded = not_for_ever()

    def kill_the_first_worker() -> None:
        bounded()
        if began(tmp_path, "j0") and len(submitted_to_slurm(tmp_path)) == 1:
            with contextlib.suppress(ProcessLookupError):  # it takes a while until it is missed
                os.killpg(submitted_to_slurm(tmp_path)[0], signal.SIGKILL)

    with dask.config.set({"distributed.deploy.lost-worker-timeout": "1s"}):
        run_batch(jobs, slurm, came.append, kill_the_first_worker)
    assert names(came) == ["j0", "j1"]
    assert len(submitted_to_slurm(tmp_path)) == 2

"""One model: `neurframe run` in a child under limits, started again where something killed it, and its outcome."""

from __future__ import annotations

import socket
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from neurframe_cli.batch.outcome import Outcome
from neurframe_cli.errors import (
    Cancelled,
    ChildOutOfMemory,
    NeurframeError,
    NotValid,
    TimedOut,
    UnreadableFile,
    WorkspaceBusy,
)
from neurframe_cli.pipeline.lock import exclusive
from neurframe_cli.pipeline.manifest import StageRecord, read_manifest
from neurframe_cli.process import run_child

BUSY_PATIENCE_S = 60.0
_ANY_CODE = range(-64, 256)
_OF_CODE = {
    0: "valid",
    UnreadableFile.exit_code: "unusable",
    NeurframeError.exit_code: "failed",
    NotValid.exit_code: "invalid",
    TimedOut.exit_code: "timed out",
    Cancelled.exit_code: "interrupted",
}
_SIGKILL, _SIGTERM = -9, -15
# someone else ended these: a node that goes down, the system out of memory, a job that is preempted
_WORTH_ANOTHER_TRY = (_SIGKILL, _SIGTERM, Cancelled.exit_code)
_BEFORE_MESHES = ("tetize", "train", "discretize")


@dataclass(frozen=True)
class Job:
    """What a worker needs to know.

    model, workspace, folder (where it runs): absolute; arguments: of `python`; options: those the user chose, for the
    record; timeout_s: wall seconds of an attempt; memory_mib: of its whole process tree; attempts: at most.
    """

    model: Path
    workspace: Path
    folder: Path
    arguments: tuple[str, ...]
    options: tuple[str, ...] = ()
    timeout_s: float | None = None
    memory_mib: float | None = None
    attempts: int = 2


@dataclass(frozen=True)
class _End:
    """How one attempt ended."""

    outcome: str
    exit_code: int | None
    message: str


def run_job(job: Job, should_stop: Callable[[], bool] = lambda: False) -> Outcome:
    """Runs the job to its one outcome; raises Cancelled after should_stop, StageError where its folder is gone."""
    _wait_until_free(job.workspace, should_stop)
    end, attempts = _attempt(job, should_stop), 1
    while end.exit_code in _WORTH_ANOTHER_TRY and attempts < job.attempts:
        end, attempts = _attempt(job, should_stop), attempts + 1
    return _outcome(job, end, attempts)


def lost(job: Job, error: BaseException) -> Outcome:
    """The outcome of a job of which nothing came back."""
    return _outcome(job, _End("lost", None, f"{type(error).__name__}: {error}"), 0)


def _attempt(job: Job, should_stop: Callable[[], bool]) -> _End:
    try:
        ended = run_child(
            [sys.executable, *job.arguments],
            name="the job",
            timeout_s=job.timeout_s,
            memory_mib=job.memory_mib,
            cwd=job.folder,
            accept=_ANY_CODE,
            should_stop=should_stop,
        )
    except Cancelled:
        raise
    except TimedOut as error:
        return _End("timed out", None, str(error))
    except ChildOutOfMemory as error:
        return _End("out of memory", None, str(error))
    except NeurframeError as error:
        return _End("failed", None, str(error))
    code = ended.returncode
    return _End(_OF_CODE.get(code, "crashed"), code, _complaint(ended.last_lines) if code else "")


def _complaint(lines: tuple[str, ...]) -> str:
    """The error line of neurframe among the last words, else the last one."""
    said = [line.strip() for line in lines if line.strip()]
    ours = [line.removeprefix("neurframe: ") for line in said if line.startswith("neurframe: ")]
    return next(reversed(ours or said), "").removeprefix("error: ")


def _wait_until_free(workspace: Path, should_stop: Callable[[], bool]) -> None:
    """The children of a worker that was killed may live a moment longer than it, and hold the workspace."""
    workspace.mkdir(parents=True, exist_ok=True)
    deadline = time.monotonic() + BUSY_PATIENCE_S
    while time.monotonic() < deadline and not should_stop():
        try:
            with exclusive(workspace):
                return
        except WorkspaceBusy:
            time.sleep(0.2)


def _outcome(job: Job, end: _End, attempts: int) -> Outcome:
    try:
        stages = read_manifest(job.workspace).stages
    except NeurframeError:  # the run itself has said what is wrong with it
        stages = {}
    tetize = stages.get("tetize")
    return Outcome(
        model=str(job.model),
        workspace=str(job.workspace),
        outcome=end.outcome,
        exit_code=end.exit_code,
        message=end.message,
        attempts=attempts,
        host=socket.gethostname(),
        options=list(job.options),
        seconds=round(sum(record.seconds for record in stages.values()), 3),
        cpu_seconds=round(sum(record.cpu_seconds for record in stages.values()), 3),
        peak_mib=max((record.peak_mib for record in stages.values()), default=0.0),
        tets=tetize.report.get("tets") if tetize is not None and tetize.status == "done" else None,
        meshes=_meshes(stages),
        stages={name: record.seconds for name, record in stages.items()},
    )


def _meshes(stages: Mapping[str, StageRecord]) -> dict[str, dict[str, Any]]:
    """The numbers of the meshes that stand on stages which have succeeded."""
    if any(name not in stages or stages[name].status != "done" for name in _BEFORE_MESHES):
        return {}
    return {
        name: {"valid": record.status == "done", **record.report["mesh"]}
        for name, record in stages.items()
        if name in ("quad", "hex") and record.status in ("done", "invalid")
    }

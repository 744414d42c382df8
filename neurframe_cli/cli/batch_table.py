"""What a batch shows: while it runs, and at its end."""

from __future__ import annotations

import contextlib
import time
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

from neurframe_cli.batch.job import Job
from neurframe_cli.batch.outcome import OUTCOMES, Outcome
from neurframe_cli.errors import NeurframeError
from neurframe_cli.pipeline.manifest import MANIFEST_NAME, read_manifest

if TYPE_CHECKING:
    from neurframe_cli.cli.console import Console

_POLL_S = 2.0  # between two looks at the manifests of the jobs that run
_LAST = 8  # outcomes that stay in sight
_HEAD = ("model", "outcome", "tets", "quads", "worst SJ", "hexes", "worst SJ", "seconds", "MiB", "")


class BatchDisplay:
    """A live table on a terminal, a line for each outcome elsewhere."""

    def __init__(self, console: Console, total: int, jobs: Sequence[Job], at_once: int) -> None:
        self.console, self.total, self.at_once = console, total, at_once
        self.began, self.began_at = time.monotonic(), time.time()
        self.pending = {str(job.model): job for job in jobs}
        self.ended_here: list[Outcome] = []
        self._running: dict[str, str] = {}  # model -> what it is doing
        self._polled = 0.0
        self._live: Any = None

    def __enter__(self) -> BatchDisplay:
        if self.console.is_live:
            from rich.console import Console as RichConsole
            from rich.live import Live

            self._live = Live(console=RichConsole(stderr=True), auto_refresh=False, redirect_stdout=False)
            self._live.start()
            self.tick()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._live is not None:
            self._live.update("", refresh=True)
            self._live.stop()

    def ended(self, outcome: Outcome) -> None:
        """A model has its outcome."""
        del self.pending[outcome.model]
        self._running.pop(outcome.model, None)
        self.ended_here.append(outcome)
        if self._live is None:
            number = self.total - len(self.pending)
            message = f": {outcome.message}" if outcome.message else ""
            self.console.log.info(
                "%d/%d %s %s%s", number, self.total, outcome.outcome, Path(outcome.model).name, message
            )

    def tick(self) -> None:
        """Draw the table anew."""
        if self._live is None:
            return
        if time.monotonic() - self._polled > _POLL_S:
            self._polled = time.monotonic()
            doing = {model: self._stage_of(job) for model, job in self.pending.items()}
            self._running = {model: line for model, line in doing.items() if line is not None}
        from rich.text import Text

        lines = [*table_lines(self.ended_here[-_LAST:]), *self._running.values(), self._state()]
        self._live.update(Text("\n".join(lines), no_wrap=True, overflow="ellipsis"), refresh=True)

    def _stage_of(self, job: Job) -> str | None:
        """What a job is doing, as its workspace tells, wherever it runs; None where it is not running."""
        with contextlib.suppress(OSError, NeurframeError):
            if (job.workspace / MANIFEST_NAME).stat().st_mtime < self.began_at:
                return None
            stages = read_manifest(job.workspace).stages
            now = [name for name, record in stages.items() if record.status == "running"]
            return f"{job.model.name}: {', '.join(now) or 'between stages'}"
        return None

    def _state(self) -> str:
        ended = len(self.ended_here)
        seconds = time.monotonic() - self.began
        eta = f", about {seconds / ended * len(self.pending):.0f} s to go" if ended and self.pending else ""
        return f"{self.total - len(self.pending)} of {self.total}: {counts(self.ended_here)}{eta}"


def counts(outcomes: Iterable[Outcome]) -> str:
    """How often each outcome came."""
    seen = Counter(outcome.outcome for outcome in outcomes)
    return ", ".join(f"{seen[name]} {name}" for name in OUTCOMES if seen[name]) or "no outcome"


def table_lines(outcomes: Sequence[Outcome]) -> list[str]:
    """A line for each model below a head, in columns."""
    if not outcomes:
        return []
    rows = [_HEAD, *(_cells(outcome) for outcome in outcomes)]
    widths = [max(len(row[column]) for row in rows) for column in range(len(_HEAD))]
    return [_aligned(row, widths) for row in rows]


def _aligned(row: Sequence[str], widths: Sequence[int]) -> str:
    words = [cell.ljust(width) for cell, width in zip(row[:2], widths[:2], strict=True)]
    numbers = [cell.rjust(width) for cell, width in zip(row[2:-1], widths[2:-1], strict=True)]
    return "  ".join([*words, *numbers, row[-1]]).rstrip()


def _cells(outcome: Outcome) -> tuple[str, ...]:
    meshes = [outcome.meshes.get(kind, {}) for kind in ("quad", "hex")]
    numbers = [text for mesh in meshes for text in (_count(mesh.get("cells")), _jacobian(mesh))]
    return (
        Path(outcome.model).name,
        outcome.outcome,
        _count(outcome.tets),
        *numbers,
        f"{outcome.seconds:.0f}",
        f"{outcome.peak_mib:.0f}",
        outcome.message[:80],
    )


def _count(value: int | None) -> str:
    return "" if value is None else f"{value:,}"


def _jacobian(mesh: dict[str, Any]) -> str:
    return f"{mesh['min_scaled_jacobian']:.3f}" if "min_scaled_jacobian" in mesh else ""

"""The live table of `neurframe run` on a terminal: a row for each stage."""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from neurframe_cli.process.process_tree import resident_mib

if TYPE_CHECKING:
    from rich.table import Table

    from neurframe_cli.mesh.arrays import Progress
    from neurframe_cli.pipeline.manifest import StageRecord

SAMPLE_S = 1.0  # between two looks at the memory: a walk over all processes
_BAR = 16  # characters
_LEAST_FRACTION = 0.02  # from here on an ETA means something
_STYLES = {"done": "green", "cached": "dim", "running": "bold", "not valid": "yellow", "failed": "red"}


@dataclass
class StageRow:
    """What is known of one stage; `said` is its progress text, later its result."""

    name: str
    state: str = "waiting"
    fraction: float = 0.0
    said: str = ""
    began: float = 0.0
    seconds: float = 0.0
    peak_mib: float = 0.0
    sampled: float = 0.0

    def elapsed_s(self) -> float:
        return time.monotonic() - self.began if self.state == "running" else self.seconds

    def eta_s(self) -> float | None:
        """Seconds to go, None where nothing can be said."""
        if self.state != "running" or self.fraction < _LEAST_FRACTION:
            return None
        return self.elapsed_s() * (1 - self.fraction) / self.fraction

    def sample_memory(self) -> None:
        """Raise the peak to what this process and its children use now."""
        now = time.monotonic()
        if self.state == "running" and now - self.sampled >= SAMPLE_S:
            self.sampled = now
            self.peak_mib = max(self.peak_mib, resident_mib(os.getpid()))


class StageTable:
    """The rows, and how they look; rich asks for the picture several times a second, from a thread of its own."""

    def __init__(self, names: Sequence[str]) -> None:
        self.rows = {name: StageRow(name) for name in names}

    @contextlib.contextmanager
    def running(self, name: str) -> Iterator[Progress]:
        """The stage runs in the block; what ends the block early ends the stage."""
        row = self.rows[name]
        row.state, row.began = "running", time.monotonic()
        try:
            yield lambda fraction, text: self._advance(row, fraction, text)
        except BaseException as error:
            row.seconds = row.elapsed_s()
            row.state = "failed" if isinstance(error, Exception) else "interrupted"
            raise

    def ended(self, name: str, record: StageRecord, *, skipped: bool, said: str) -> None:
        """The stage has a result: `said` in one line."""
        row = self.rows[name]
        row.seconds, row.peak_mib, row.said = record.seconds, record.peak_mib, said
        row.state = "not valid" if record.status == "invalid" else "cached" if skipped else "done"

    def _advance(self, row: StageRow, fraction: float, text: str) -> None:
        row.fraction, row.said = fraction, text

    def __rich__(self) -> Table:
        from rich.table import Table
        from rich.text import Text

        table = Table(box=None, pad_edge=False)
        for title, width in (("stage", 10), ("state", 11), ("progress", _BAR)):
            table.add_column(title, no_wrap=True, min_width=width)
        for title, width in (("eta", 7), ("time", 7), ("peak MiB", 8)):
            table.add_column(title, no_wrap=True, justify="right", min_width=width)
        table.add_column("", no_wrap=True, overflow="ellipsis")  # what is said gets the room that is left
        for row in self.rows.values():
            row.sample_memory()
            cells = (
                row.name,
                row.state,
                _bar(row),
                _duration(row.eta_s()),
                _duration(_shown(row)),
                _mib(row),
            )
            table.add_row(*cells, Text(row.said), style=_STYLES.get(row.state, ""))
        return table


@contextlib.contextmanager
def live_stages(names: Sequence[str]) -> Iterator[StageTable]:
    """A table on standard error, redrawn in place; other lines to standard error appear above it."""
    from rich.console import Console as RichConsole
    from rich.live import Live

    table = StageTable(names)
    console = RichConsole(stderr=True)
    with Live(table, console=console, refresh_per_second=4, redirect_stdout=False):
        yield table


def _bar(row: StageRow) -> str:
    if row.state in ("waiting", "cached"):
        return ""
    filled = _BAR if row.state in ("done", "not valid") else int(_BAR * row.fraction)
    return "━" * filled + "╌" * (_BAR - filled)


def _shown(row: StageRow) -> float | None:
    return None if row.state in ("waiting", "cached") else row.elapsed_s()


def _duration(seconds: float | None) -> str:
    if seconds is None:
        return ""
    if seconds < 60:
        return f"{seconds:.1f} s"
    return f"{int(seconds) // 3600}:{int(seconds) // 60 % 60:02d}:{int(seconds) % 60:02d}"


def _mib(row: StageRow) -> str:
    return f"{row.peak_mib:,.0f}" if row.peak_mib else ""

"""What a person sees: progress bars with ETA on a terminal, plain lines elsewhere, a JSON log on request."""

from __future__ import annotations

import contextlib
import json
import logging
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING

from neurframe_cli.cli.streams import show, tell
from neurframe_cli.errors import UsageError

if TYPE_CHECKING:  # arrays.py loads numpy, which --help has no time for
    from neurframe_cli.cli.stage_table import StageTable
    from neurframe_cli.mesh.arrays import Progress
    from neurframe_cli.pipeline.manifest import StageRecord

PLAIN_INTERVAL_S = 10.0
_LEVELS = {-1: logging.WARNING, 0: logging.INFO}


class Console:
    """Owner of the log handlers and of the progress display; verbosity -1 quiet, 0 normal, 1 with debugging."""

    def __init__(self, verbosity: int, log_json: Path | None = None) -> None:
        self.verbosity = verbosity
        self.log = logging.getLogger("neurframe")
        self.log.setLevel(logging.DEBUG)
        self.log.propagate = False
        self._table: StageTable | None = None
        self._screen = _ScreenHandler(_LEVELS.get(verbosity, logging.DEBUG))
        self._handlers: list[logging.Handler] = [self._screen]
        if log_json is not None:
            self._handlers.append(_json_handler(log_json))

    def __enter__(self) -> Console:
        for handler in self._handlers:
            self.log.addHandler(handler)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if error is not None:
            self.log.debug("ended by %s: %s", type(error).__name__, error)
        for handler in self._handlers:
            self.log.removeHandler(handler)
            handler.close()

    def result(self, text: str) -> None:
        """What the command was asked for, on stdout."""
        show(text)

    @property
    def is_live(self) -> bool:
        """Whether lines can be drawn anew: on a terminal, and not where nothing shall be shown."""
        return self.verbosity >= 0 and sys.stderr.isatty()

    @contextlib.contextmanager
    def stages(self, names: Sequence[str]) -> Iterator[None]:
        """Within the block these stages share one live table, where there is a terminal to show it."""
        if not self.is_live:
            yield
            return
        from neurframe_cli.cli.stage_table import live_stages

        level = self._screen.level
        with live_stages(names) as self._table:
            # the table shows what the lines would say
            self._screen.setLevel(logging.WARNING if self.verbosity == 0 else level)
            try:
                yield
            finally:
                self._table = None
                self._screen.setLevel(level)

    def ended(self, stage: str, record: StageRecord, *, skipped: bool, said: str) -> None:
        """Put a stage's result into the table, if there is one."""
        if self._table is not None:
            self._table.ended(stage, record, skipped=skipped, said=said)

    @contextlib.contextmanager
    def progress(self, title: str) -> Iterator[Progress]:
        """A progress callback for the stage `title`, shown as this console shows progress."""
        if self._table is not None:
            with self._table.running(title) as update:
                yield update
        elif self.verbosity < 0:
            yield lambda fraction, text: None
        elif self.is_live:
            with _progress_bar(title) as update:
                yield update
        else:
            yield _PlainProgress(title)


@contextlib.contextmanager
def _progress_bar(title: str) -> Iterator[Progress]:
    from rich.console import Console as RichConsole
    from rich.progress import (
        BarColumn,
        TaskProgressColumn,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )
    from rich.progress import Progress as RichProgress

    columns = (
        TextColumn("{task.fields[title]:<12}"),
        BarColumn(bar_width=30),
        TaskProgressColumn(),
        TimeElapsedColumn(),
        TextColumn("eta"),
        TimeRemainingColumn(),
        TextColumn("{task.description}", markup=False),
    )
    with RichProgress(*columns, console=RichConsole(stderr=True)) as bars:
        task = bars.add_task("", total=1.0, title=title)
        yield lambda fraction, text: bars.update(task, completed=fraction, description=text)


class _PlainProgress:
    """Progress as an occasional line, for logs and pipes."""

    def __init__(self, title: str) -> None:
        self.title = title
        self.started = time.monotonic()
        self.last = self.started

    def __call__(self, fraction: float, text: str) -> None:
        now = time.monotonic()
        if now - self.last < PLAIN_INTERVAL_S:
            return
        self.last = now
        elapsed = now - self.started
        eta = f", eta {elapsed * (1 - fraction) / fraction:.0f} s" if fraction > 0 else ""
        tell(f"{self.title}: {fraction:.0%} {text} ({elapsed:.0f} s{eta})")


class _ScreenFormatter(logging.Formatter):
    def format(self, record: logging.LogRecord) -> str:
        prefix = "" if record.levelno <= logging.INFO else f"{record.levelname.lower()}: "
        return prefix + record.getMessage()


class _ScreenHandler(logging.Handler):
    """Lines on what standard error is at that moment: while a live table is shown, rich puts them above it."""

    def __init__(self, level: int) -> None:
        super().__init__(level)
        self.setFormatter(_ScreenFormatter())

    def emit(self, record: logging.LogRecord) -> None:
        tell(self.format(record))


class _JsonFormatter(logging.Formatter):
    def format(self, record: logging.LogRecord) -> str:
        line = {
            "time": round(record.created, 3),
            "level": record.levelname.lower(),
            "message": record.getMessage(),
        }
        return json.dumps(line)


class _JsonHandler(logging.FileHandler):
    """A log that cannot be written any more is no reason to stop the work: it is said once."""

    def handleError(self, record: logging.LogRecord) -> None:
        self.addFilter(lambda record: False)
        tell(f"warning: the log {self.baseFilename} ends here: {sys.exc_info()[1]}")

    def close(self) -> None:
        with contextlib.suppress(OSError):  # what is still in the buffer, when the disk is full
            super().close()


def _json_handler(path: Path) -> logging.Handler:
    try:
        handler = _JsonHandler(path, encoding="utf-8")
    except OSError as error:
        raise UsageError(f"cannot write the log file {path}: {error.strerror}") from error
    handler.setFormatter(_JsonFormatter())
    return handler

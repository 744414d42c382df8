"""What a person sees: progress bars with ETA on a terminal, plain lines elsewhere, a JSON log on request."""

from __future__ import annotations

import contextlib
import json
import logging
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING

import click

from neurframe_cli.errors import UsageError

if TYPE_CHECKING:  # arrays.py loads numpy, which --help has no time for
    from neurframe_cli.mesh.arrays import Progress

PLAIN_INTERVAL_S = 10.0
_LEVELS = {-1: logging.WARNING, 0: logging.INFO}


class Console:
    """Owner of the log handlers and of the progress display; verbosity -1 quiet, 0 normal, 1 with debugging."""

    def __init__(self, verbosity: int, log_json: Path | None = None) -> None:
        self.verbosity = verbosity
        self.log = logging.getLogger("neurframe")
        self.log.setLevel(logging.DEBUG)
        self.log.propagate = False
        self._handlers: list[logging.Handler] = [_screen_handler(_LEVELS.get(verbosity, logging.DEBUG))]
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
        click.echo(text)

    @contextlib.contextmanager
    def progress(self, title: str) -> Iterator[Progress]:
        """A progress callback for the stage `title`, shown as this console shows progress."""
        if self.verbosity < 0:
            yield lambda fraction, text: None
        elif sys.stderr.isatty():
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
        click.echo(f"{self.title}: {fraction:.0%} {text} ({elapsed:.0f} s{eta})", err=True)


class _ScreenFormatter(logging.Formatter):
    def format(self, record: logging.LogRecord) -> str:
        prefix = "" if record.levelno <= logging.INFO else f"{record.levelname.lower()}: "
        return prefix + record.getMessage()


def _screen_handler(level: int) -> logging.Handler:
    handler = logging.StreamHandler(sys.stderr)
    handler.setLevel(level)
    handler.setFormatter(_ScreenFormatter())
    return handler


class _JsonFormatter(logging.Formatter):
    def format(self, record: logging.LogRecord) -> str:
        line = {
            "time": round(record.created, 3),
            "level": record.levelname.lower(),
            "message": record.getMessage(),
        }
        return json.dumps(line)


def _json_handler(path: Path) -> logging.Handler:
    try:
        handler = logging.FileHandler(path, encoding="utf-8")
    except OSError as error:
        raise UsageError(f"cannot write the log file {path}: {error.strerror}") from error
    handler.setFormatter(_JsonFormatter())
    return handler

"""results.jsonl: one line for each outcome, on the disk before the next job is looked at; and the tables made of it."""

from __future__ import annotations

import contextlib
import csv
import fcntl
import os
from collections.abc import Iterable, Iterator
from pathlib import Path

from neurframe_cli.batch.outcome import Outcome, from_line, row, to_line
from neurframe_cli.errors import UnreadableFile, WorkspaceBusy
from neurframe_cli.pipeline.atomic import atomic_path, write_error
from neurframe_cli.pipeline.report_step import REPORT, write_summary


class ResultsFile:
    """The file, held open for appending by one batch at a time."""

    def __init__(self, path: Path, handle: int) -> None:
        self.path, self._handle = path, handle

    def append(self, outcome: Outcome) -> None:
        """Write the line and wait until it is on the disk; raises StageError."""
        try:
            line = to_line(outcome).encode()
            while line:
                line = line[os.write(self._handle, line) :]
            os.fsync(self._handle)
        except OSError as error:
            raise write_error(self.path, error) from error


@contextlib.contextmanager
def open_results(path: Path) -> Iterator[ResultsFile]:
    """The results file for appending, without the torn line of a batch that was killed while it wrote.

    Raises WorkspaceBusy where another batch holds it, StageError where it cannot be written.
    """
    try:
        handle = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC | os.O_NOFOLLOW, 0o666)
    except OSError as error:
        raise write_error(path, error) from error
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise WorkspaceBusy(
                f"another batch writes to {path}", hint="choose another folder with -o"
            ) from error
        os.ftruncate(handle, _whole_bytes(path))
        yield ResultsFile(path, handle)
    finally:
        os.close(handle)


def read_results(paths: Iterable[Path]) -> dict[str, Outcome]:
    """The outcomes by model; a torn last line is no outcome.  Raises UnreadableFile or TooNewFile."""
    found: dict[str, Outcome] = {}
    for path in paths:
        for number, line in enumerate(_whole(path).splitlines(), 1):
            outcome = from_line(line.decode("utf-8", "replace"), f"{path}, line {number},")
            found[outcome.model] = outcome
    return found


def write_tables(folder: Path, outcomes: Iterable[Outcome]) -> list[Path]:
    """results.csv and summary.html of all outcomes, in the order of their models; returns their paths."""
    ordered = sorted(outcomes, key=lambda outcome: outcome.model)
    table, page = folder / "results.csv", folder / "summary.html"
    rows = [row(outcome) for outcome in ordered]
    with atomic_path(table) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(rows[0]) if rows else ["model"])
        writer.writeheader()
        writer.writerows(rows)
    reports = [_report_of(outcome, folder) for outcome in ordered]
    write_summary([{**cells, "report": report} for cells, report in zip(rows, reports, strict=True)], page)
    return [table, page]


def _report_of(outcome: Outcome, folder: Path) -> str | None:
    """The path of a model's own report, relative to the summary; None where there is none."""
    report = Path(outcome.workspace) / REPORT
    return os.path.relpath(report, folder.resolve()) if report.is_file() else None


def _whole(path: Path) -> bytes:
    """The file up to its last line end."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise UnreadableFile(f"cannot read {path}: {error.strerror}") from error
    return content[: content.rfind(b"\n") + 1]


def _whole_bytes(path: Path) -> int:
    return len(_whole(path))

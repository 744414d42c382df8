"""Running one of the four programs: a child under limits, its statistics as a dictionary."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from neurframe_cli.errors import InputError, NotValid, StageError
from neurframe_cli.mesh.arrays import Progress
from neurframe_cli.pipeline.executables import find_executable
from neurframe_cli.process import run_child
from neurframe_cli.process.memory import usable_mib


@dataclass(frozen=True)
class Limits:
    """What a child process may use: wall seconds, MiB of memory, threads; None is no limit, of memory what is free."""

    timeout_s: float | None = None
    memory_mib: float | None = None
    threads: int | None = None


@dataclass(frozen=True)
class ProgramResult:
    """complete is False where the program wrote its output but says that it is not valid (exit code 4)."""

    complete: bool
    statistics: dict[str, Any]
    seconds: float
    peak_mib: float
    last_words: str


def run_program(
    program: str, arguments: Sequence[str | os.PathLike[str]], limits: Limits, progress: Progress
) -> ProgramResult:
    """Run miq, qex, cubecover or hexex with `arguments`; raises what run_child raises, no InputError."""
    executable = find_executable(program)
    threads = [] if limits.threads is None else ["--threads", str(limits.threads)]
    try:
        ended = run_child(
            [executable, *map(_never_an_option, arguments), *threads],
            name=executable.name,
            timeout_s=limits.timeout_s,
            memory_mib=limits.memory_mib or usable_mib(),
            threads=limits.threads,
            on_progress=progress,
            accept=(0, NotValid.exit_code),
        )
    except InputError as error:
        # what it cannot use is our own artifact, not the user's file
        raise StageError(
            str(error), hint="the artifacts so far are kept; try another scale or other tets"
        ) from error
    words = next((line.strip() for line in reversed(ended.last_lines) if line.strip()), "")
    statistics = _statistics(ended.stdout, executable.name)
    return ProgramResult(ended.returncode == 0, statistics, ended.seconds, ended.peak_mib, words)


def _never_an_option(argument: str | os.PathLike[str]) -> str:
    """A path as one that begins with the root: a folder may be called `-o`."""
    return argument if isinstance(argument, str) else os.path.abspath(argument)


def _statistics(stdout: bytes, name: str) -> dict[str, Any]:
    """The JSON object on standard output; published programs print none, which is fine."""
    text = stdout.decode("utf-8", "replace").strip()
    if not text.startswith("{"):
        return {}
    try:
        found = json.loads(text)
    except ValueError as error:
        raise StageError(f"{name} printed statistics that are no JSON: {error}") from error
    return found if isinstance(found, dict) else {}

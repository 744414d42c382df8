"""The options that every command takes, before or after its name."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

_THREAD_VARIABLES = ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS")


def GLOBAL_OPTIONS() -> list[click.Option]:
    """Fresh option objects (click binds an option to one command)."""
    return [
        click.Option(
            ["-v", "--verbose"], is_flag=True, help="Say more: what is skipped or done again, and why."
        ),
        click.Option(["-q", "--quiet"], is_flag=True, help="No progress, only warnings and errors."),
        click.Option(
            ["--log-json"],
            type=click.Path(path_type=Path),
            help="Append every log record to this file as JSON.",
        ),
        click.Option(
            ["--config"],
            type=click.Path(path_type=Path),
            help="TOML file with options; the command line wins.",
        ),
        click.Option(["--threads"], type=click.IntRange(1), help="Processor threads to use.  [default: all]"),
    ]


@dataclass(frozen=True)
class Settings:
    """Values of the global options; verbosity: -1 quiet, 0 normal, 1 with debugging."""

    verbosity: int = 0
    log_json: Path | None = None
    config: Path | None = None
    threads: int | None = None

    @classmethod
    def from_options(cls, values: dict[str, Any]) -> Settings:
        verbosity = -1 if values.get("quiet") else int(bool(values.get("verbose")))
        return cls(verbosity, values.get("log_json"), values.get("config"), values.get("threads"))

    def merged(self, later: Settings) -> Settings:
        """These settings, with what was given after the command's name in place of what came before it."""
        return Settings(
            later.verbosity or self.verbosity,
            later.log_json or self.log_json,
            later.config or self.config,
            later.threads or self.threads,
        )

    def apply_threads(self) -> int:
        """Limit the numeric libraries that are not loaded yet; returns the number of threads to use."""
        threads = self.threads or len(os.sched_getaffinity(0))
        for variable in _THREAD_VARIABLES:
            os.environ[variable] = str(threads)
        # threads that spin at a barrier cost ten times the work itself where other processes want the cores
        os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")
        return threads

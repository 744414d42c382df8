"""From the options of `neurframe batch` to the command line of each job."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import click
import psutil
from click.core import ParameterSource

from neurframe_cli.batch.job import Job
from neurframe_cli.batch.pool import LOOPBACK, PoolOptions
from neurframe_cli.cli.command import StageCommand, settings_of
from neurframe_cli.cli.configuration import config_key
from neurframe_cli.cli.run import command as run
from neurframe_cli.pipeline.workspace import SUFFIX

_FREE_SHARE = 0.9  # of the free memory, dealt out to the jobs
_OWN = {"output", "timeout", "memory"}  # options of both commands that mean something else here


def share_of(
    ctx: click.Context, scheduler: str | None, jobs: int, threads: int, memory_mib: int | None
) -> tuple[int | None, float | None]:
    """Threads and MiB of a job: as given, else its share of this machine, if it runs on this one."""
    given = settings_of(ctx).threads
    if scheduler not in (None, LOOPBACK):
        return given, memory_mib
    free = psutil.virtual_memory().available / 2**20
    return given or max(1, threads // jobs), memory_mib or _FREE_SHARE * free / jobs


class JobTemplate:
    """What all jobs have in common."""

    def __init__(
        self, ctx: click.Context, output: Path, pool: PoolOptions, timeout_s: float, attempts: int
    ) -> None:
        self.output, self.pool, self.timeout_s, self.attempts = output, pool, timeout_s, attempts
        self.options = list(_chosen_options(ctx))
        config = settings_of(ctx).config
        self.config = ["--config", str(config.resolve())] if config is not None else []

    def job(self, model: Path, name: str) -> Job:
        """`neurframe run` of a model, in the workspace `name` of the output folder."""
        workspace = (self.output / (name + SUFFIX)).resolve()
        threads = ["--threads", str(self.pool.threads)] if self.pool.threads is not None else []
        # -P: a file in the current folder is no module of ours
        start = ["-P", "-m", "neurframe_cli", "run", str(model), "-w", str(workspace), "-q"]
        limits = ["--timeout", str(self.timeout_s), *threads, *self.config]
        return Job(
            model=model,
            workspace=workspace,
            folder=Path.cwd(),
            arguments=(*start, *limits, *self.options),
            options=tuple(self.options),
            timeout_s=self.timeout_s,
            memory_mib=self.pool.memory_mib,
            attempts=self.attempts,
        )


def _chosen_options(ctx: click.Context) -> Iterator[str]:
    """The options of `run` that were given, by command line or config file, as its command line takes them."""
    names = (
        {option.name for option in run.params} - {option.name for option in StageCommand("").params} - _OWN
    )
    for option in ctx.command.params:
        value = ctx.params.get(option.name or "")
        given = ctx.get_parameter_source(option.name or "") is not ParameterSource.DEFAULT
        if not isinstance(option, click.Option) or option.name not in names:
            continue
        if not given or value is None or (value is False and not option.secondary_opts):
            continue
        if isinstance(value, bool):
            yield option.opts[0] if value else option.secondary_opts[0]
        else:
            yield f"--{config_key(option)}"
            yield str(value.resolve() if isinstance(value, Path) else value)

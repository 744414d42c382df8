"""`neurframe batch INPUTS...`: many models, one table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from neurframe_cli.cli.command import StageCommand
from neurframe_cli.cli.options import limit_options, run_options
from neurframe_cli.errors import NotValid, UsageError

if TYPE_CHECKING:
    from neurframe_cli.batch.inputs import Shard
    from neurframe_cli.batch.job import Job
    from neurframe_cli.batch.outcome import Outcome
    from neurframe_cli.batch.pool import PoolOptions
    from neurframe_cli.cli.console import Console

_RESULTS = "results"


@click.command(name="batch", cls=StageCommand)
@click.argument("inputs", nargs=-1, required=True)
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    default="batch",
    show_default=True,
    help="Folder for the workspaces, results.jsonl, results.csv and summary.html.",
)
@click.option("--jobs", type=click.IntRange(1), default=1, show_default=True, help="Models at the same time.")
@click.option("--resume", is_flag=True, help="Go on: models that have an outcome are left alone.")
@click.option(
    "--shard", metavar="K/N", help="Only the K-th of N parts; each part can run on its own machine."
)
@click.option(
    "--scheduler",
    metavar="WHERE",
    help="Dask workers: the address of a scheduler, `loopback` (started here) or `slurm`.",
)
@click.option(
    "--attempts",
    type=click.IntRange(1),
    default=2,
    show_default=True,
    help="Starts of a job that something outside kills.",
)
@click.option(
    "--thingi10k",
    type=click.Path(path_type=Path),
    envvar="THINGI10K",
    help="Folder with a copy of Thingi10K, for inputs thingi10k:ID.  [default: the extra `thingi10k`]",
)
@limit_options(3600.0, "a whole job", "a whole job")
@run_options
@click.pass_context
def command(
    ctx: click.Context,
    /,
    inputs: tuple[str, ...],
    output: Path,
    jobs: int,
    resume: bool,
    shard: str | None,
    scheduler: str | None,
    attempts: int,
    thingi10k: Path | None,
    threads: int,
    console: Console,
    **values: Any,
) -> None:
    """Run the pipeline on many models: each INPUT is a folder, a glob in quotes, a list file (.txt) or a model.

    Every model gets exactly one outcome, whatever happens to it: a line of results.jsonl.  --threads and --memory are
    those of a job.  Exit code 4 where not every model has valid meshes.
    """
    from neurframe_cli.batch.inputs import Shard, find_models, parse_shard, take_shard, workspace_names
    from neurframe_cli.batch.pool import PoolOptions
    from neurframe_cli.cli.batch_jobs import JobTemplate, share_of

    _check(values, threads)
    part = parse_shard(shard) if shard is not None else Shard()
    models = find_models(inputs, thingi10k)
    names = workspace_names(models)
    pool = PoolOptions(scheduler, jobs, *share_of(ctx, scheduler, jobs, threads, values["memory"]))
    template = JobTemplate(ctx, output, pool, values["timeout"], attempts)
    todo = [template.job(model, names[model]) for model in take_shard(models, part)]
    outcomes = _carry_out(todo, output, part, pool, console, resume=resume)
    console.result(_conclusion(outcomes, output))
    bad = [outcome for outcome in outcomes if outcome.outcome != "valid"]
    if bad:
        raise NotValid(f"{len(bad)} of {len(outcomes)} models have no valid mesh of every kind asked for")


def _check(values: Mapping[str, Any], threads: int) -> None:
    """Mistakes in the options of `run` are one error here, not one for each model."""
    from neurframe_cli.cli.chain import mesh_request
    from neurframe_cli.cli.run import kinds_of, refuse_ambiguous

    kinds = kinds_of(values["quad"], values["hexes"])
    refuse_ambiguous(kinds, values)
    mesh_request(kinds, {**values, "output": None}, threads)


def _carry_out(
    jobs: Sequence[Job], folder: Path, part: Shard, pool: PoolOptions, console: Console, *, resume: bool
) -> list[Outcome]:
    """Run what has no outcome yet; returns the outcomes of `jobs`, after the tables of all parts are written."""
    from neurframe_cli.batch.results import open_results, read_results, write_tables
    from neurframe_cli.batch.run_batch import run_batch
    from neurframe_cli.cli.batch_table import BatchDisplay
    from neurframe_cli.pipeline.atomic import write_error

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise write_error(folder, error) from error
    name = f"{_RESULTS}.jsonl" if part.count == 1 else f"{_RESULTS}.{part}.jsonl"
    with open_results(folder / name) as results:
        done = read_results([folder / name])
        _refuse_other_results(done, jobs, folder / name, resume=resume)
        rest = [job for job in jobs if str(job.model) not in done]
        with BatchDisplay(console, len(jobs), rest, pool.jobs) as display:

            def record(outcome: Outcome) -> None:
                results.append(outcome)
                done[outcome.model] = outcome
                display.ended(outcome)

            try:
                run_batch(rest, pool, record, display.tick)
            finally:
                every = read_results(sorted(folder.glob(f"{_RESULTS}*.jsonl")))
                write_tables(folder, every.values())
    return [done[str(job.model)] for job in jobs]


def _refuse_other_results(
    done: Mapping[str, Outcome], jobs: Sequence[Job], path: Path, *, resume: bool
) -> None:
    """Raises UsageError where there are outcomes and --resume is not given, or they are from other options."""
    if done and not resume:
        raise UsageError(
            f"{path} has {len(done)} outcomes already",
            hint="--resume goes on, -o FOLDER begins another batch",
        )
    for job in jobs:
        earlier = done.get(str(job.model))
        if earlier is not None and earlier.options != list(job.options):
            raise UsageError(
                f"{path} is of a batch with the options {' '.join(earlier.options) or '(none)'}",
                hint="give the same ones, or choose another folder with -o",
            )


def _conclusion(outcomes: Sequence[Outcome], folder: Path) -> str:
    from neurframe_cli.cli.batch_table import counts, table_lines

    return "\n".join(
        [
            *table_lines(outcomes),
            counts(outcomes),
            f"{folder / 'summary.html'}, {_RESULTS}.csv, {_RESULTS}.jsonl",
        ]
    )

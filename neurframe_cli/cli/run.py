"""`neurframe run INPUT`: the whole chain."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from neurframe_cli.cli.command import StageCommand
from neurframe_cli.cli.options import (
    force_option,
    input_argument,
    limit_options,
    output_option,
    run_options,
    workspace_option,
)
from neurframe_cli.cli.quality import apply_quality
from neurframe_cli.errors import NeurframeError, NotValid, UsageError

if TYPE_CHECKING:
    from neurframe_cli.cli.chain import Kind
    from neurframe_cli.cli.console import Console
    from neurframe_cli.pipeline.mesh_step import MeshRequest
    from neurframe_cli.pipeline.runner import Step
    from neurframe_cli.pipeline.workspace import Workspace


class RunCommand(StageCommand):
    """Lays --quality under the options before the callback sees them."""

    def invoke(self, ctx: click.Context) -> Any:
        apply_quality(ctx)
        return super().invoke(ctx)


@click.command(name="run", cls=RunCommand)
@input_argument
@run_options
@output_option
@workspace_option
@limit_options(1800.0, "each child process")
@force_option
@click.option("--dry-run", is_flag=True, help="Say what would be done and about how long it takes.")
def command(
    model: Path,
    quad: bool,
    hexes: bool,
    workspace: Path | None,
    force: bool,
    dry_run: bool,
    threads: int,
    console: Console,
    **values: Any,
) -> None:
    """Run the whole pipeline on INPUT: tets, field, frames, and the quad mesh and hex mesh.

    Stages whose inputs and options have not changed are skipped; a killed run goes on where it was.
    """
    from neurframe_cli.cli.chain import mesh_request
    from neurframe_cli.cli.run_summary import result_lines
    from neurframe_cli.pipeline.workspace import Workspace, workspace_folder, workspace_for_input

    kinds = kinds_of(quad, hexes)
    refuse_ambiguous(kinds, values)
    requests = mesh_request(kinds, values, threads)
    if dry_run:
        found = Workspace(workspace_folder(model, workspace))
        _say_plan(Job(found, model, values, requests, threads, force), console)
        return
    job = Job(workspace_for_input(model, workspace), model, values, requests, threads, force)
    with console.stages([*job.steps(), *requests]):
        failure = _run_all(job, console)
    if values["report"]:
        _write_report(job.workspace, console)
    console.result("\n".join(result_lines(job.workspace, kinds)))
    if failure is not None:
        raise failure


@dataclass(frozen=True)
class Job:
    """What one call of `neurframe run` has to do."""

    workspace: Workspace
    model: Path
    values: dict[str, Any]
    requests: dict[Kind, MeshRequest]
    threads: int
    force: bool

    def steps(self) -> dict[str, Callable[[], Step]]:
        """The stages before the meshes; a step can be made when those before it have run."""
        from neurframe_cli.cli.chain import discretize_of, tetize_of, train_of

        return {
            "tetize": lambda: tetize_of(self.model, self.values),
            "train": lambda: train_of(self.workspace, self.values, self.threads, fresh=self.force),
            "discretize": lambda: discretize_of(self.workspace, self.values),
        }


def kinds_of(quad: bool, hexes: bool) -> list[Kind]:
    """What is to be made: both where neither was asked for."""
    asked: list[Kind] = ["quad"] if quad else []
    asked += ["hex"] if hexes else []
    return asked or ["quad", "hex"]


def refuse_ambiguous(kinds: list[Kind], values: Mapping[str, Any]) -> None:
    """Raises UsageError where a size or a file name is given for two meshes."""
    for name in ("scale", "edge_length", "output"):
        if values.get(name) is not None and len(kinds) > 1:
            option = name.replace("_", "-")
            raise UsageError(
                f"--{option} is for one mesh, two would be made", hint=f"add --quad or --hex to --{option}"
            )


def _run_all(job: Job, console: Console) -> NeurframeError | None:
    """Every stage; a mesh that fails does not keep the next from being made, and its error is returned."""
    from neurframe_cli.cli.chain import mesh_stage, run_step

    for make in job.steps().values():
        run_step(job.workspace, make(), console, force=job.force)
    failed: list[NeurframeError] = []
    for kind, request in job.requests.items():
        try:
            mesh_stage(kind, job.workspace, request, job.values["output"], console, force=job.force)
        except NeurframeError as error:
            failed.append(error)
    for earlier in failed[:-1]:
        console.log.error("%s", earlier)
    # one that could not be made says more than one that is not valid
    return next(
        (error for error in failed if not isinstance(error, NotValid)), failed[-1] if failed else None
    )


def _write_report(workspace: Workspace, console: Console) -> None:
    """report.html, unless nothing has changed since it was written; a report that fails spoils no mesh."""
    from neurframe_cli.pipeline.manifest import MANIFEST_NAME
    from neurframe_cli.pipeline.report_step import REPORT, write_report

    path = workspace / REPORT
    if path.is_file() and path.stat().st_mtime_ns >= (workspace / MANIFEST_NAME).stat().st_mtime_ns:
        return
    try:
        write_report(workspace.folder)
    except Exception as error:  # whatever it is, the meshes are there, and they are what the user asked for
        console.log.warning("%s was not written: %s: %s", path, type(error).__name__, error)


def _say_plan(job: Job, console: Console) -> None:
    from neurframe_cli.cli.chain import mesh_of
    from neurframe_cli.cli.run_summary import plan_lines
    from neurframe_cli.pipeline.forecast import amount_of, measured_speed
    from neurframe_cli.pipeline.plan import plan
    from neurframe_cli.pipeline.workspace import manifests_beside

    steps = job.steps()
    for kind, request in job.requests.items():
        steps[kind] = partial(mesh_of, kind, job.workspace, request)
    planned = plan(job.workspace, steps, force=job.force)
    quads = job.requests.get("quad")
    hexes = job.requests.get("hex")
    amount = amount_of(
        job.model,
        job.values["tet_edge_length"],
        quads.size if quads else None,
        hexes.size if hexes else None,
    )
    speed, earlier = measured_speed(manifests_beside(job.workspace))
    console.result("\n".join(plan_lines(planned, amount, speed, earlier)))

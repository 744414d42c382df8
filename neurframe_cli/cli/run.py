"""`neurframe run INPUT`: the whole chain."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from neurframe_cli.cli.command import StageCommand
from neurframe_cli.cli.options import (
    discretize_options,
    edge_length_option,
    feature_angle_option,
    force_option,
    input_argument,
    limit_options,
    output_option,
    scale_option,
    seed_option,
    tetize_options,
    train_options,
    workspace_option,
)
from neurframe_cli.errors import NeurframeError, NotValid, UsageError

if TYPE_CHECKING:
    from neurframe_cli.cli.chain import Kind
    from neurframe_cli.cli.console import Console
    from neurframe_cli.pipeline.mesh_step import MeshRequest
    from neurframe_cli.pipeline.workspace import Workspace


@click.command(name="run", cls=StageCommand)
@input_argument
@click.option("--quad", is_flag=True, help="Make quads.  [default: quads and hexes]")
@click.option("--hex", "hexes", is_flag=True, help="Make hexes.  [default: quads and hexes]")
@scale_option
@edge_length_option
@output_option
@workspace_option
@tetize_options("--tet-edge-length")
@feature_angle_option
@train_options
@discretize_options
@limit_options(1800.0, "each child process")
@seed_option
@force_option
def command(
    model: Path,
    quad: bool,
    hexes: bool,
    workspace: Path | None,
    force: bool,
    threads: int,
    console: Console,
    **values: Any,
) -> None:
    """Run the whole pipeline on INPUT: tets, field, frames, and the quad mesh and hex mesh.

    Stages whose inputs and options have not changed are skipped; a killed run goes on where it was.
    """
    from neurframe_cli.cli.chain import discretize_stage, mesh_request, tetize_stage, train_stage
    from neurframe_cli.pipeline.workspace import workspace_for_input

    kinds = _kinds(quad, hexes)
    _refuse_ambiguous(kinds, values)
    requests = mesh_request(kinds, values, threads)
    found = workspace_for_input(model, workspace)
    tetize_stage(found, model, values, console, force=force)
    train_stage(found, values, threads, console, force=force)
    discretize_stage(found, values, console, force=force)
    _make_meshes(requests, found, values["output"], console, force)
    console.result(str(found.folder))


def _kinds(quad: bool, hexes: bool) -> list[Kind]:
    asked: list[Kind] = ["quad"] if quad else []
    asked += ["hex"] if hexes else []
    return asked or ["quad", "hex"]


def _refuse_ambiguous(kinds: list[Kind], values: dict[str, Any]) -> None:
    """A size or a file name means one mesh."""
    for name in ("scale", "edge_length", "output"):
        if values[name] is not None and len(kinds) > 1:
            option = name.replace("_", "-")
            raise UsageError(
                f"--{option} is for one mesh, two would be made", hint=f"add --quad or --hex to --{option}"
            )


def _make_meshes(
    requests: dict[Kind, MeshRequest],
    workspace: Workspace,
    output: Path | None,
    console: Console,
    force: bool,
) -> None:
    """Every mesh that was asked for; one that fails does not keep the next from being made."""
    from neurframe_cli.cli.chain import mesh_stage

    failed: list[NeurframeError] = []
    for kind, request in requests.items():
        try:
            mesh_stage(kind, workspace, request, output, console, force=force)
        except NeurframeError as error:
            failed.append(error)
    for earlier in failed[:-1]:
        console.log.error("%s", earlier)
    if failed:
        raise next((failure for failure in failed if not isinstance(failure, NotValid)), failed[-1])

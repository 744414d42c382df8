"""Options that several commands share."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

Command = TypeVar("Command", bound=Callable[..., Any])

input_argument = click.argument("model", metavar="INPUT", type=click.Path(path_type=Path))
workspace_option = click.option(
    "-w",
    "--workspace",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Workspace folder.  [default: STEM.neurframe]",
)
force_option = click.option("--force", is_flag=True, help="Do it again even if nothing has changed.")
seed_option = click.option(
    "--seed", type=click.IntRange(0), default=0, show_default=True, help="Random seed."
)


def options(*decorators: Callable[[Command], Command]) -> Callable[[Command], Command]:
    """Several option decorators as one, in the order in which the help shows them."""

    def apply(command: Command) -> Command:
        for decorator in reversed(decorators):
            command = decorator(command)
        return command

    return apply


tetize_options = options(
    click.option(
        "--edge-length",
        type=click.FloatRange(1e-4, 1.0),
        default=0.025,
        show_default=True,
        help="Edge length of the tets, in bounding-box diagonals.",
    ),
    click.option(
        "--epsilon",
        type=click.FloatRange(1e-6, 0.1),
        default=1e-3,
        show_default=True,
        help="How far the surface may move, in bounding-box diagonals.",
    ),
    click.option(
        "--feature-angle",
        type=click.FloatRange(0, 180),
        default=45.0,
        show_default=True,
        help="Edges that bend by more degrees are features.",
    ),
    click.option(
        "--features",
        type=click.Path(path_type=Path),
        help="Feature edges instead of the angle: features.json, or a VTK or OBJ file with lines.",
    ),
    click.option(
        "--timeout",
        type=click.FloatRange(0, min_open=True),
        default=600.0,
        show_default=True,
        help="Seconds for the tetrahedral meshing.",
    ),
    click.option("--memory", type=click.IntRange(64), help="MiB that a child process may use.  [default: what is free]"),
    seed_option,
)

"""Options that several commands share."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

from neurframe_cli.cli.quality import quality_option

Command = TypeVar("Command", bound=Callable[..., Any])


class FiniteRange(click.FloatRange):
    """A range of floats without infinities and NaN, which pass every comparison of click's."""

    name = "number"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        number = super().convert(value, param, ctx)
        if not math.isfinite(number):
            self.fail(f"{value} is not a finite number.", param, ctx)
        return number


_positive = FiniteRange(0, min_open=True)

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


device_option = click.option(
    "--device",
    type=click.Choice(["auto", "cpu", "cuda"]),
    default="auto",
    show_default=True,
    help="auto: the GPU if there is one.",
)


def options(*decorators: Callable[[Command], Command]) -> Callable[[Command], Command]:
    """Several option decorators as one, in the order in which the help shows them."""

    def apply(command: Command) -> Command:
        for decorator in reversed(decorators):
            command = decorator(command)
        return command

    return apply


def tetize_options(edge_length_name: str) -> Callable[[Command], Command]:
    """Options of tetize; `run` calls the edge length of the tets by a longer name."""
    return options(
        click.option(
            edge_length_name,
            "tet_edge_length",
            type=FiniteRange(1e-4, 1.0),
            default=0.025,
            show_default=True,
            help="Edge length of the tets, in bounding-box diagonals.",
        ),
        click.option(
            "--epsilon",
            type=FiniteRange(1e-6, 0.1),
            default=1e-3,
            show_default=True,
            help="How far the surface may move, in bounding-box diagonals.",
        ),
        click.option(
            "--features",
            type=click.Path(path_type=Path),
            help="Feature edges instead of the angle: features.json, or a file with lines (OBJ, VTK, .sharp).",
        ),
    )


A_STAGE = "a stage, and for each program in it"


def memory_option(what: str = A_STAGE) -> Callable[[Command], Command]:
    """--memory."""
    return click.option("--memory", type=click.IntRange(64), help=f"MiB for {what}.  [default: what is free]")


def limit_options(timeout_s: float, what: str, memory: str = A_STAGE) -> Callable[[Command], Command]:
    """--timeout of child processes, and --memory."""
    timeout = click.option(
        "--timeout", type=_positive, default=timeout_s, show_default=True, help=f"Seconds for {what}."
    )
    return options(timeout, memory_option(memory))


feature_angle_option = click.option(
    "--feature-angle",
    type=FiniteRange(0, 180),
    default=45.0,
    show_default=True,
    help="Edges that bend by more degrees are features.",
)
output_option = click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    help="A further file for the mesh; its extension is the format.",
)

_share = FiniteRange(0, 1, min_open=True)

train_options = options(
    click.option(
        "--preset",
        type=click.Choice(["fast", "paper"]),
        default="fast",
        show_default=True,
        help="fast: discrete solution distilled into the network; paper: Adam on the loss, 10,000 iterations.",
    ),
    click.option(
        "--method",
        type=click.Choice(["neural", "discrete"]),
        default="neural",
        show_default=True,
        help="discrete: the baseline without a network.",
    ),
    click.option(
        "--iterations", type=click.IntRange(1), help="Steps of the optimizer.  [default: the preset's]"
    ),
    click.option(
        "--batch-fraction", type=_share, help="Share of the tets in a step.  [default: the preset's]"
    ),
    click.option("--learning-rate", type=_positive, help="[default: the preset's]"),
    click.option("--time-budget", type=_positive, help="Seconds after which training ends with what it has."),
    click.option(
        "--lambda-smooth",
        type=FiniteRange(0),
        default=1.0,
        show_default=True,
        help="Weight of smoothness.",
    ),
    click.option(
        "--lambda-boundary",
        type=FiniteRange(0),
        default=20.0,
        show_default=True,
        help="Weight of normals.",
    ),
    click.option(
        "--lambda-feature",
        type=FiniteRange(0),
        default=1.0,
        show_default=True,
        help="Weight of features.",
    ),
    click.option(
        "--sigma", type=FiniteRange(0), default=10.0, show_default=True, help="Decay away from features."
    ),
    device_option,
    click.option(
        "--precision",
        type=click.Choice(["auto", "fp32", "tf32", "bf16"]),
        default="auto",
        show_default=True,
        help="Of the hidden layers while training.",
    ),
    click.option(
        "--project/--no-project",
        default=False,
        show_default=True,
        help="Pull the discrete solution to true frames before it is distilled.",
    ),
)

pictures_option = click.option(
    "--pictures/--no-pictures", default=True, show_default=True, help="Draw PNG pictures."
)

discretize_options = options(
    click.option(
        "--surface",
        type=click.Choice(["auto", "input", "tets"]),
        default="auto",
        show_default=True,
        help="Triangles for the crosses: the input's or the tets'; auto: the input's where they are good enough.",
    ),
    pictures_option,
)


quad_options = options(
    click.option(
        "--adaptive",
        type=FiniteRange(0, 1),
        is_flag=False,
        flag_value=0.5,
        help="Smaller quads where the surface bends, by this much: from 0 (equal quads) to 1; 0.5 without a number.",
    ),
    click.option(
        "--symmetry",
        type=click.Choice(["x", "y", "z"]),
        help="Make the quads an exact mirror image of themselves across this axis.",
    ),
    click.option(
        "--field",
        type=click.Choice(["neural", "surface"]),
        default="neural",
        show_default=True,
        help="surface: the smoothest crosses of the surface alone, the baseline without a trained field.",
    ),
)

hex_options = options(
    click.option(
        "--padding/--no-padding",
        default=None,
        help="A layer of hexes along the boundary, where that makes nothing worse.  [default: where hexes are poor]",
    ),
    click.option(
        "--split/--no-split",
        "splitting",
        default=True,
        show_default=True,
        help="Finer hexes of the same map where these are off the surface by more than 1 % of the diagonal.",
    ),
    click.option(
        "--grid/--no-grid",
        default=None,
        help="Where no map gives valid hexes, those of a regular grid in the solid.  [default: unless --fill]",
    ),
    click.option(
        "--fill",
        is_flag=True,
        help="Where the hexes are not valid, write a conforming mesh with pyramids and tets in their voids, too.",
    ),
)

scale_option = click.option(
    "--scale",
    type=_positive,
    help="Edge length = bounding-box diagonal / SCALE.  [default: quads 100, hexes 30]",
)
edge_length_option = click.option(
    "--edge-length", type=_positive, help="Edge length of the elements, in input units."
)


def count_option(name: str, elements: str) -> Callable[[Command], Command]:
    """How many elements there shall be."""
    return click.option(name, "count", type=click.IntRange(1), help=f"About how many {elements}.")


def mesh_options(count_name: str, elements: str) -> Callable[[Command], Command]:
    """What `quad` and `hex` can be told."""
    return options(
        scale_option,
        edge_length_option,
        count_option(count_name, elements),
        feature_angle_option,
        output_option,
        pictures_option,
        limit_options(1800.0, "each program"),
    )


def continuous_options(samples: int, what: str) -> Callable[[Command], Command]:
    """What `singularities` and `streamlines` can be told; `what` the samples are."""
    return options(
        workspace_option,
        click.option("--samples", type=click.IntRange(1), default=samples, show_default=True, help=what),
        pictures_option,
        seed_option,
        force_option,
    )


run_options = options(
    click.option("--quad", is_flag=True, help="Make quads.  [default: quads and hexes]"),
    click.option("--hex", "hexes", is_flag=True, help="Make hexes.  [default: quads and hexes]"),
    scale_option,
    edge_length_option,
    quality_option,
    tetize_options("--tet-edge-length"),
    feature_angle_option,
    train_options,
    discretize_options,
    quad_options,
    hex_options,
    seed_option,
    click.option("--report/--no-report", default=True, show_default=True, help="Write report.html."),
)

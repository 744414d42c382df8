"""`neurframe check MESH --against SURFACE`: validity and quality of a quad or hex mesh."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from neurframe_cli.cli.command import StageCommand
from neurframe_cli.cli.options import feature_angle_option
from neurframe_cli.errors import NotValid

if TYPE_CHECKING:
    from neurframe_cli.cli.console import Console


@click.command(name="check", cls=StageCommand)
@click.argument("mesh", type=click.Path(path_type=Path))
@click.option(
    "--against", type=click.Path(path_type=Path), required=True, help="The surface or tets it was made from."
)
@feature_angle_option
@click.option(
    "--pictures",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="Draw the mesh there: outside, cut, singular graph, all coloured by quality.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the numbers as one JSON object.")
def command(
    mesh: Path,
    against: Path,
    feature_angle: float,
    pictures: Path | None,
    as_json: bool,
    threads: int,
    console: Console,
) -> None:
    """Check a quad or hex mesh: topology, scaled Jacobian, distance and sharp edges against the input.

    Of a mesh of hexes, pyramids and tets, as --fill writes it: conformity, quality, volume and distance.

    Exit code 0 where it is valid, 4 where it is not.
    """
    from neurframe_cli.pipeline.checking import check_file_against, draw_file

    verdict = check_file_against(mesh, against, feature_angle)
    if as_json:
        console.result(
            json.dumps({**verdict.numbers, "valid": verdict.valid, "problems": verdict.problems}, indent=1)
        )
    else:
        for name, value in verdict.numbers.items():
            console.result(f"{name.replace('_', ' '):<26}{_shown(value)}")
        console.result(f"{'valid':<26}{'yes' if verdict.valid else 'no: ' + '; '.join(verdict.problems)}")
    if pictures is not None:
        for path in draw_file(mesh, pictures):
            console.log.info("%s", path)
    if not verdict.valid:
        raise NotValid(f"{mesh} is not valid: {'; '.join(verdict.problems)}")


def _shown(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)

"""`--quality`: sets of options under one name; any of them can still be given on its own."""

from __future__ import annotations

from typing import Any

import click
from click.core import ParameterSource

# parameter name -> value; what is not named keeps its default
QUALITIES: dict[str, dict[str, Any]] = {
    "draft": {
        "tet_edge_length": 0.05,
        "epsilon": 2e-3,
        "iterations": 200,
        "batch_fraction": 0.1,
        "pictures": False,
    },
    "normal": {},
    "high": {"tet_edge_length": 0.0175, "epsilon": 5e-4, "iterations": 1200, "batch_fraction": 0.08},
}

quality_option = click.option(
    "--quality",
    type=click.Choice(list(QUALITIES)),
    default="normal",
    show_default=True,
    help="draft: coarser tets, shorter training, no pictures; high: finer tets, longer training.",
)


def apply_quality(ctx: click.Context) -> None:
    """Put the values of --quality in place of the defaults; what the command line or a config file says stays."""
    for name, value in QUALITIES[ctx.params["quality"]].items():
        if ctx.get_parameter_source(name) is ParameterSource.DEFAULT:
            ctx.params[name] = value

"""The pictures of a workspace for its report."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from neurframe_cli.pipeline.workspace import Workspace
from neurframe_cli.report.image import data_uri
from neurframe_cli.report.page import Picture

# file -> stage that draws it, section of the report that shows it, caption
_PICTURES = {
    "tets.png": ("discretize", "tetize", "The tets behind a cut"),
    "field-crosses.png": ("discretize", "discretize", "Crosses on the surface, coloured by direction"),
    "field-frames.png": ("discretize", "discretize", "Frames at the middle height of the volume"),
    "field-singular.png": ("discretize", "discretize", "Singular edges of the field"),
    "singularities.png": ("singularities", "singularities", "Singular points of the continuous field"),
    "streamlines.png": ("streamlines", "streamlines", "Streamlines of the continuous field"),
    "quad.png": ("quad", "quad", "Quads, coloured by quality, and irregular vertices"),
    "hex.png": ("hex", "hex", "Hexes from outside, coloured by quality"),
    "hex-cut.png": ("hex", "hex", "Hexes behind a cut, and singular edges"),
    "hex-singular.png": ("hex", "hex", "The singular graph of the hexes"),
    "hex-trouble.png": ("hex", "hex", "Inverted hexes, and what is wrong with the map"),
    "filled.png": ("hex", "hex", "Hexes, pyramids and tets behind a cut"),
}


def report_pictures(workspace: Workspace, document: Mapping[str, Any]) -> list[Picture]:
    """Every picture that a finished stage has drawn; one that cannot be read is noted in the document instead."""
    found = []
    for name, (maker, section, caption) in _PICTURES.items():
        if (
            name not in document["stages"].get(maker, {}).get("outputs", {})
            or not (workspace / name).is_file()
        ):
            continue
        try:
            found.append(Picture(name, section, caption, data_uri(workspace / name)))
        except (OSError, SyntaxError, ValueError) as error:  # what Pillow raises for damaged files
            document["notes"].append(f"{workspace / name} cannot be shown: {error}")
    return found

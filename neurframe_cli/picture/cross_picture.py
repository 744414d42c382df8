"""The surface with its feature edges and the crosses on it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from neurframe_cli.mesh.arrays import Floats
from neurframe_cli.mesh.measure import surface_area
from neurframe_cli.mesh.surface_edges import face_normals
from neurframe_cli.picture.field_data import FieldData
from neurframe_cli.picture.scene import FEATURE_COLOR, Scene, polydata, spread_sample

# crosses along the longest side of the bounding box
CELLS = 50
# a stroke is coloured by the mixture of these that its direction is of x, y and z
AXIS_COLORS = np.array([[200, 55, 45], [40, 130, 60], [40, 80, 190]])


def draw_crosses(path: Path, data: FieldData) -> None:
    """PNG of crosses as strokes, evenly spread, coloured by direction: red x, green y, blue z."""
    scene = Scene(data.surface.V)
    scene.surface(data.surface.V, data.surface.F)
    scene.lines(data.tets.V, data.feature_edges, color=FEATURE_COLOR, width=2.5)
    ends, colors = _strokes(data)
    segments = np.arange(len(ends)).reshape(-1, 2)
    mesh = polydata(ends, lines=segments)
    mesh.cell_data["color"] = colors
    scene.plotter.add_mesh(mesh, scalars="color", rgb=True, line_width=3.0, lighting=False)
    label_axes(scene)
    scene.save(path)


def label_axes(scene: Scene) -> None:
    """The legend of colours by direction."""
    for name, color in zip("xyz", AXIS_COLORS, strict=True):
        scene.label("#{:02x}{:02x}{:02x}".format(*color), f"along {name}")


def _strokes(data: FieldData) -> tuple[Floats, Floats]:
    """End points (2k,3) of strokes, lifted off the surface a little, and colours (k,3) uint8."""
    centroids = data.surface.V[data.surface.F].mean(axis=1)
    chosen = spread_sample(centroids, CELLS)
    half = 0.36 * np.sqrt(surface_area(data.surface.V, data.surface.F) / len(chosen))
    normals = face_normals(data.surface.V, data.surface.F)[chosen]
    middle = np.repeat(centroids[chosen] + 0.2 * half * normals, 2, axis=0)
    along = data.crosses[chosen].reshape(-1, 3)
    ends = np.stack([middle - half * along, middle + half * along], axis=1)
    return ends.reshape(-1, 3), (along**2 @ AXIS_COLORS).astype(np.uint8)

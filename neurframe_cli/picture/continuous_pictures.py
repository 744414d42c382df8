"""The continuous field: points of its singular graph, and its streamlines."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from neurframe_cli.picture.cross_picture import AXIS_COLORS, label_axes
from neurframe_cli.picture.field_data import FieldData
from neurframe_cli.picture.scene import FEATURE_COLOR, Scene, polydata
from neurframe_cli.picture.singular_picture import KINDS


def draw_singular_points(path: Path, data: FieldData) -> None:
    """PNG of points of the singular graph, coloured by kind, in the outline of the body."""
    scene = Scene(data.surface.V)
    scene.silhouette(data.surface.V, data.surface.F)
    scene.lines(data.tets.V, data.feature_edges, color=FEATURE_COLOR, width=1.2)
    for quarters, (color, name) in KINDS.items():
        points = data.singular_points[data.point_quarters == quarters]
        if len(points):
            scene.plotter.add_mesh(
                polydata(points), color=color, point_size=13.0, render_points_as_spheres=True, ambient=0.25
            )
            scene.label(color, f"{name}: {len(points)} points")
    scene.surface(data.surface.V, data.surface.F, opacity=0.12, color="#8fa6bf")
    if not len(data.singular_points):
        scene.label("#777777", "no singular points found")
    scene.save(path)


def draw_streamlines(path: Path, data: FieldData) -> None:
    """PNG of the streamlines as tubes, coloured by direction: red x, green y, blue z."""
    scene = Scene(data.surface.V)
    scene.lines(data.tets.V, data.feature_edges, color=FEATURE_COLOR, width=1.2)
    ends = np.arange(len(data.streamline_points))
    first = np.delete(ends, np.maximum(data.streamline_offsets[1:] - 1, 0))
    if len(first):
        along = data.streamline_points[first + 1] - data.streamline_points[first]
        along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-300)
        mesh = polydata(data.streamline_points, lines=np.stack([first, first + 1], axis=1))
        mesh.cell_data["color"] = (along**2 @ AXIS_COLORS).astype(np.uint8)
        tubes = mesh.tube(radius=1.2e-3 * scene.diagonal, n_sides=8)
        scene.plotter.add_mesh(tubes, scalars="color", rgb=True, ambient=0.25)
    scene.surface(data.surface.V, data.surface.F, opacity=0.12, color="#8fa6bf")
    label_axes(scene)
    scene.save(path)

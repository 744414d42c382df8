"""The 3D view of a workspace, or of one mesh file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from neurframe_cli.errors import NeurframeError
from neurframe_cli.mesh.arrays import Surface
from neurframe_cli.mesh.features import features_by_angle
from neurframe_cli.mesh.measure import box_diagonal
from neurframe_cli.mesh.read_cells import CellMesh
from neurframe_cli.mesh.read_surface import read_surface
from neurframe_cli.picture.read_vtp import read_vtp
from neurframe_cli.picture.scene import FEATURE_COLOR
from neurframe_cli.picture.singular_picture import KINDS
from neurframe_cli.pipeline.report_document import SURFACE
from neurframe_cli.pipeline.workspace import Workspace
from neurframe_cli.report import scene
from neurframe_cli.report.layers import Layer
from neurframe_cli.report.mesh_quality import cell_quality

SINGULAR_EDGES, SINGULAR_POINTS, STREAMLINES = "singular_edges.vtp", "singularities.vtp", "streamlines.vtp"
TUBE_RADIUS = 0.004  # of the diagonal
_FEATURE_ANGLE_DEG = 45.0


def workspace_scene(
    workspace: Workspace, document: Mapping[str, Any], meshes: Mapping[str, CellMesh]
) -> dict[str, Any] | None:
    """The layers of a workspace: meshes, input, singular graph, streamlines, worst cells, defects.

    An artifact that is damaged is left out, and noted in the document.
    """
    layers: list[Layer] = []
    cut = None
    for kind in ("hex", "quad"):
        if kind in meshes:
            made, cut_of_this = mesh_layers(meshes[kind], shown=not layers)
            layers, cut = layers + made, cut or cut_of_this
    defects = [
        place for trouble in document["troubles"] for one in trouble["defects"] for place in one["places"]
    ]
    if defects:
        layers.append(scene.point_layer(f"defects, {len(defects)}", np.array(defects), scene.DEFECT_COLOR))
    for stage, file, build in (
        ("tetize", SURFACE, _surface_layers),
        ("discretize", SINGULAR_EDGES, _singular_layers),
        ("singularities", SINGULAR_POINTS, _point_layers),
        ("streamlines", STREAMLINES, _streamline_layers),
    ):
        layers += _layers_of(workspace, document, stage, file, build, bool(meshes))
    return scene.scene_document(layers, cut)


def mesh_layers(mesh: CellMesh, *, shown: bool) -> tuple[list[Layer], dict[str, Any] | None]:
    """A quad or hex mesh with its worst cells, and what cutting it takes."""
    quality = cell_quality(mesh)
    worst = scene.worst_layer(mesh, np.argsort(quality, kind="stable")[:10])
    if mesh.kind == "quad":
        return [scene.quad_layer(mesh, quality, shown=shown), worst], None
    faces = scene.hex_faces(mesh.cells)
    layer = scene.hex_layer(mesh, faces, quality)
    return [layer, worst], scene.cut_document(layer.title, faces, quality)


def surface_layers(surface: Surface, *, shown: bool) -> list[Layer]:
    """A surface with its sharp edges."""
    edges = features_by_angle(surface.V, surface.F, _FEATURE_ANGLE_DEG).edges
    return [
        scene.line_layer("sharp edges", surface.V, edges, FEATURE_COLOR),
        scene.surface_layer(surface, shown=shown),
    ]


def _layers_of(
    workspace: Workspace,
    document: Mapping[str, Any],
    stage: str,
    file: str,
    build: Callable[[Workspace, bool], list[Layer]],
    has_mesh: bool,
) -> list[Layer]:
    """The layers of one artifact, none where its stage has not left it."""
    record = document["stages"].get(stage, {})
    if record.get("status") not in ("done", "invalid") or file not in record["outputs"]:
        return []
    try:
        return build(workspace, has_mesh)
    except NeurframeError as error:
        document["notes"].append(f"not in the 3D view: {error}")
        return []


def _surface_layers(workspace: Workspace, has_mesh: bool) -> list[Layer]:
    return surface_layers(read_surface(workspace / SURFACE), shown=not has_mesh)


def _singular_layers(workspace: Workspace, has_mesh: bool) -> list[Layer]:
    """The singular edges as tubes, a layer for each kind."""
    graph = read_vtp(workspace / SINGULAR_EDGES)
    radius = TUBE_RADIUS * _diagonal(workspace, graph.points)
    quarters = graph.data.get("quarters", np.zeros(0))
    return [
        scene.tube_layer(
            f"singular edges {name}", graph.points, graph.segments[quarters == kind], color, radius
        )
        for kind, (color, name) in KINDS.items()
        if (quarters == kind).any()
    ]


def _diagonal(workspace: Workspace, points: Any) -> float:
    """Of the input, or of the points where that is not there."""
    if (workspace / SURFACE).is_file():
        points = read_surface(workspace / SURFACE).V
    return box_diagonal(points)


def _point_layers(workspace: Workspace, has_mesh: bool) -> list[Layer]:
    found = read_vtp(workspace / SINGULAR_POINTS)
    quarters = found.data.get("quarters", np.zeros(0))
    return [
        scene.point_layer(f"singular points {name}", found.points[quarters == kind], color, shown=False)
        for kind, (color, name) in KINDS.items()
        if (quarters == kind).any()
    ]


def _streamline_layers(workspace: Workspace, has_mesh: bool) -> list[Layer]:
    found = read_vtp(workspace / STREAMLINES)
    on_surface = found.data["on_surface"][found.line] > 0
    return [
        scene.line_layer(title, found.points, found.segments[chosen], color, shown=False)
        for title, chosen, color in (
            ("streamlines inside", ~on_surface, "#2463b0"),
            ("streamlines on the surface", on_surface, "#1d7a46"),
        )
        if chosen.any()
    ]

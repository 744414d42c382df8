"""Looks inside: frames as boxes on a plane, and the tets behind a cut."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from neurframe_cli.mesh.arrays import Bools, Floats, Ints
from neurframe_cli.mesh.tet_adjacency import tet_adjacency
from neurframe_cli.picture.containing_tets import containing_tets
from neurframe_cli.picture.field_data import FieldData
from neurframe_cli.picture.scene import FEATURE_COLOR, SURFACE_COLOR, Scene, polydata

CUT_COLOR = "#f2c572"
BOX_COLOR = "#6ea3dc"
BOX_CELLS = 40  # boxes along the longest side


def draw_frames(path: Path, data: FieldData) -> None:
    """PNG of frames as boxes along their axes, on a regular grid at the middle height of the volume."""
    scene = Scene(data.surface.V)
    spacing = float(np.ptp(data.tets.V, axis=0).max()) / BOX_CELLS
    points = _grid_in_the_middle(data, spacing)
    tets = containing_tets(data.tets.V, data.tets.T, points)
    boxes = _boxes(points[tets >= 0], data.frames[tets[tets >= 0]], 0.6 * spacing)
    scene.plotter.add_mesh(
        boxes, color=BOX_COLOR, show_edges=True, edge_color="#1d3b5c", line_width=1.2, ambient=0.25
    )
    scene.surface(data.surface.V, data.surface.F, opacity=0.12, color="#8fa6bf")
    scene.lines(data.tets.V, data.feature_edges, color=FEATURE_COLOR, width=1.5)
    scene.label(BOX_COLOR, "frames at middle height")
    scene.save(path)


def draw_tets(path: Path, data: FieldData) -> None:
    """PNG of the tets behind the cut: boundary faces light, faces that the cut lays open in yellow."""
    scene = Scene(data.tets.V)
    centroids = data.tets.V[data.tets.T].mean(axis=1)
    kept = np.flatnonzero(centroids @ _cut_normal(scene) <= _cut_height(data, scene))
    shell = tet_adjacency(data.tets.T[kept])
    outer = _is_boundary_face(data.tets.T, kept[shell.boundary_tets], shell.boundary_faces)
    for faces, color in ((outer, SURFACE_COLOR), (~outer, CUT_COLOR)):
        scene.surface(
            data.tets.V,
            shell.boundary_faces[faces],
            color=color,
            show_edges=True,
            edge_color="#5a6572",
            line_width=0.8,
        )
    scene.label(SURFACE_COLOR, f"boundary, {len(data.tets.T)} tets")
    scene.label(CUT_COLOR, "cut")
    scene.save(path)


def _cut_normal(scene: Scene) -> Floats:
    """The horizontal coordinate axis that points at the viewer most: what is on that side is cut away."""
    axis = int(np.abs(scene.toward_viewer[:2]).argmax())
    return np.asarray(np.eye(3)[axis] * np.sign(scene.toward_viewer[axis]))


def _cut_height(data: FieldData, scene: Scene) -> float:
    along = data.tets.V @ _cut_normal(scene)
    return float(along.max() + along.min()) / 2


def _grid_in_the_middle(data: FieldData, spacing: float) -> Floats:
    """Points (n,3) of a square grid across z over the bounding box, with half of the volume above and below."""
    corners = data.tets.V[data.tets.T]
    volume = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1]))
    height = corners[:, :, 2].mean(axis=1)
    upward = np.argsort(height)
    middle = height[upward][np.searchsorted(np.cumsum(volume[upward]), volume.sum() / 2)]
    low, high = data.tets.V.min(axis=0), data.tets.V.max(axis=0)
    x, y = (np.arange(low[k] + spacing / 2, high[k], spacing) for k in range(2))
    return np.stack(np.meshgrid(x, y, [middle], indexing="ij"), axis=-1).reshape(-1, 3)


def _boxes(centers: Floats, frames: Floats, side: float) -> Any:
    """Cubes of the given side along the axes of frames (n,3,3)."""
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    quads = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
    V = centers[:, None] + side * np.einsum("nij,cj->nci", frames, corners)
    faces = (quads[None] + 8 * np.arange(len(centers))[:, None, None]).reshape(-1, 4)
    return polydata(V.reshape(-1, 3), faces=faces)


def _is_boundary_face(T: Ints, tets: Ints, faces: Ints) -> Bools:
    """Which faces (k,3) of the tets (k,) are boundary in the whole mesh T."""
    neighbors = tet_adjacency(T).neighbors
    opposite = (~(T[tets][:, :, None] == faces[:, None, :]).any(axis=2)).argmax(axis=1)
    return np.asarray(neighbors[tets, opposite] < 0)

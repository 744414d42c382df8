"""Quad and hex meshes coloured by quality: from outside, behind a cut, and with what is irregular in them."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from neurframe_cli.mesh.arrays import Floats, Ints
from neurframe_cli.mesh.hex_shell import hex_shell
from neurframe_cli.mesh.quality.hex_singular_graph import HexSingularGraph, hex_singular_graph
from neurframe_cli.mesh.quality.polygons import triangulated, unique_edges, valences
from neurframe_cli.mesh.quality.scaled_jacobian import hex_scaled_jacobians, quad_scaled_jacobians
from neurframe_cli.picture.mesh_data import MeshData
from neurframe_cli.picture.scene import Scene, polydata

# colour of a cell by its worst scaled Jacobian, linear in between; below 0 it is inverted
QUALITY_RAMP = ((0.0, "#b2182b"), (0.3, "#ef8a62"), (0.6, "#fddbc7"), (0.8, "#e9eef4"), (1.0, "#c3d5ea"))
FEW_COLOR, MANY_COLOR = "#2f6fd0", "#c8322b"
EDGE_COLOR = "#39424d"
# of the places in a mesh that is not valid, in the order in which they are named
PLACE_COLORS = ("#2f6fd0", "#e0912f", "#3a9a5b", "#8b5fbf", "#222222")


def draw_quads(path: Path, data: MeshData) -> None:
    """PNG of the quads, coloured by quality, with vertices of valence below four blue and above four red."""
    quality = quad_scaled_jacobians(data.V, data.cells).min(axis=1)
    scene = Scene(data.V[np.unique(data.cells)])
    _faces(scene, data.V, data.cells, quality)
    edges, use = unique_edges(data.cells)
    found = valences(edges, len(data.V))
    interior = np.setdiff1d(np.unique(edges), edges[use == 1])
    few, many = interior[found[interior] < 4], interior[found[interior] > 4]
    for chosen, color, name in (
        (few, FEW_COLOR, "fewer than four quads"),
        (many, MANY_COLOR, "more than four quads"),
    ):
        if len(chosen):
            scene.plotter.add_mesh(
                polydata(_raised(scene, data.V[chosen])),
                color=color,
                point_size=15,
                render_points_as_spheres=True,
            )
            scene.label(color, f"{name}: {len(chosen)} vertices")
    _label_quality(scene, quality, "quads")
    scene.save(path)


def draw_hexes(path: Path, data: MeshData) -> None:
    """PNG of the hexes from outside, coloured by quality."""
    quality = hex_scaled_jacobians(data.V, data.cells).min(axis=1)
    scene = Scene(data.V[np.unique(data.cells)])
    shell = hex_shell(data.cells)
    _faces(scene, data.V, shell.quads, quality[shell.owner])
    _label_quality(scene, quality, "hexes")
    scene.save(path)


def draw_hexes_cut(path: Path, data: MeshData) -> None:
    """PNG of the hexes behind a cut, with the interior edges where other than four hexes meet."""
    quality = hex_scaled_jacobians(data.V, data.cells).min(axis=1)
    points = data.V[np.unique(data.cells)]
    scene = Scene(points)
    axis = int(np.abs(scene.toward_viewer[:2]).argmax())
    side = np.sign(scene.toward_viewer[axis])
    centroids = side * data.V[data.cells].mean(axis=1)[:, axis]
    kept = np.flatnonzero(centroids <= side * (points[:, axis].max() + points[:, axis].min()) / 2)
    shell = hex_shell(data.cells[kept])
    _faces(scene, data.V, shell.quads, quality[kept][shell.owner])
    _draw_singular_edges(scene, data, hex_singular_graph(data.cells))
    _label_quality(scene, quality, "hexes")
    scene.save(path)


def draw_hexes_trouble(path: Path, data: MeshData) -> None:
    """PNG of the inverted hexes in the outline of all of them, with the places that the data name."""
    quality = hex_scaled_jacobians(data.V, data.cells).min(axis=1)
    scene = Scene(data.V[np.unique(data.cells)])
    shell = hex_shell(data.cells).quads
    scene.surface(data.V, triangulated(shell), opacity=0.18)
    scene.lines(data.V, unique_edges(shell)[0], color="#c4ccd6", width=0.6)
    inverted = data.cells[quality <= 0]
    if len(inverted):
        quads = hex_shell(inverted).quads
        scene.surface(data.V, triangulated(quads), color=QUALITY_RAMP[0][1])
        scene.lines(data.V, unique_edges(quads)[0], color=EDGE_COLOR, width=1.2)
        scene.label(QUALITY_RAMP[0][1], f"{len(inverted)} of {len(quality)} hexes inverted")
    for color, (what, points) in zip(itertools.cycle(PLACE_COLORS), data.places.items(), strict=False):
        if len(points):
            marks = polydata(points)
            scene.plotter.add_mesh(marks, color=color, point_size=13, render_points_as_spheres=True)
        scene.label(color, what)
    scene.save(path)


def draw_hexes_singular(path: Path, data: MeshData) -> None:
    """PNG of the singular graph in the outline of the hexes, its nodes as balls."""
    scene = Scene(data.V[np.unique(data.cells)])
    shell = hex_shell(data.cells).quads
    scene.surface(data.V, triangulated(shell), opacity=0.15)
    scene.silhouette(data.V, triangulated(shell))
    graph = hex_singular_graph(data.cells)
    _draw_singular_edges(scene, data, graph)
    if len(graph.nodes):
        nodes = polydata(data.V[graph.nodes])
        scene.plotter.add_mesh(nodes, color=EDGE_COLOR, point_size=16, render_points_as_spheres=True)
    scene.label(EDGE_COLOR, f"{graph.summary()['singular_arcs']} arcs, {len(graph.nodes)} nodes")
    scene.save(path)


def _draw_singular_edges(scene: Scene, data: MeshData, graph: HexSingularGraph) -> None:
    """Interior edges of fewer and of more than four hexes."""
    for color, chosen, name in (
        (FEW_COLOR, graph.valence < 4, "fewer than four hexes"),
        (MANY_COLOR, graph.valence > 4, "more than four hexes"),
    ):
        scene.lines(data.V, graph.edges[chosen], color=color, width=3.0, tubes=True)
        if chosen.any():
            scene.label(color, f"{name}: {int(chosen.sum())} edges")


def _faces(scene: Scene, V: Floats, quads: Ints, quality: Floats) -> None:
    """Flat quads with their edges; drawn as triangles, so that warped ones show as they are measured."""
    mesh = polydata(V, faces=triangulated(quads))
    mesh.cell_data["color"] = np.tile(quality_colors(quality), (2, 1))
    scene.plotter.add_mesh(mesh, scalars="color", rgb=True, smooth_shading=False, ambient=0.5, diffuse=0.65)
    scene.lines(
        _raised(scene, V), unique_edges(quads)[0], color=EDGE_COLOR, width=1.2 if len(quads) < 20_000 else 0.5
    )


def _raised(scene: Scene, V: Floats) -> Floats:
    """Points a little nearer to the viewer, so that what is drawn there is not half inside the faces."""
    return np.asarray(V + 2e-3 * scene.diagonal * scene.toward_viewer)


def quality_colors(quality: Floats) -> NDArray[np.uint8]:
    """Colours (m,3) uint8 of cells by their worst scaled Jacobian (m,), from QUALITY_RAMP."""
    stops = np.array([stop for stop, _ in QUALITY_RAMP])
    table = np.array([[int(color[i : i + 2], 16) for i in (1, 3, 5)] for _, color in QUALITY_RAMP])
    return np.stack([np.interp(quality, stops, table[:, k]) for k in range(3)], axis=1).astype(np.uint8)


def _label_quality(scene: Scene, quality: Floats, name: str) -> None:
    worst, mean = float(quality.min()), float(quality.mean())
    scene.label(QUALITY_RAMP[-1][1], f"{len(quality)} {name}, scaled Jacobian {mean:.3f} (mean)")
    color = QUALITY_RAMP[int(np.searchsorted([stop for stop, _ in QUALITY_RAMP[1:]], worst))][1]
    scene.label(color, f"{worst:.3f} (worst)")

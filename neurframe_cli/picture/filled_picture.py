"""A mesh of hexes, pyramids and tets behind a cut, coloured by kind."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints
from neurframe_cli.mesh.filling.hybrid_mesh import HybridMesh, cell_faces
from neurframe_cli.mesh.quality.polygons import triangulated, unique_edges
from neurframe_cli.picture.mesh_data import HybridData
from neurframe_cli.picture.mesh_pictures import EDGE_COLOR
from neurframe_cli.picture.scene import Scene

HEX_COLOR, PYRAMID_COLOR, TET_COLOR = "#c3d5ea", "#f2c572", "#a8d5ae"


def draw_filled(path: Path, data: HybridData) -> None:
    """PNG of the cells whose centre lies behind a plane through the middle."""
    mesh = data.mesh
    points = mesh.V[np.unique(np.concatenate([block.ravel() for block in _blocks(mesh)]))]
    scene = Scene(points)
    axis = int(np.abs(scene.toward_viewer[:2]).argmax())
    side = float(np.sign(scene.toward_viewer[axis]))
    limit = side * float(points[:, axis].max() + points[:, axis].min()) / 2
    behind = [block[side * mesh.V[block].mean(axis=1)[:, axis] <= limit] for block in _blocks(mesh)]
    seen = _outside(HybridMesh(mesh.V, *behind))
    kinds = zip(
        ("hexes", "pyramids", "tets"), (HEX_COLOR, PYRAMID_COLOR, TET_COLOR), _blocks(mesh), strict=True
    )
    for kind, (name, color, block) in enumerate(kinds):
        quads, triangles = seen[kind]
        scene.surface(mesh.V, np.concatenate([triangulated(quads), triangles]), color=color)
        for faces in (quads, triangles):
            if len(faces):
                _lines(scene, mesh.V, unique_edges(faces)[0])
        scene.label(color, f"{len(block)} {name}")
    scene.save(path)


def _lines(scene: Scene, V: Floats, edges: Ints) -> None:
    raised = V + 2e-3 * scene.diagonal * scene.toward_viewer
    scene.lines(raised, edges, color=EDGE_COLOR, width=0.9)


def _blocks(mesh: HybridMesh) -> tuple[Ints, Ints, Ints]:
    return mesh.hexes, mesh.pyramids, mesh.tets


def _outside(mesh: HybridMesh) -> list[tuple[Ints, Ints]]:
    """Quads and triangles of exactly one cell, for each kind of cell."""
    hexes, pyramids, tets = _blocks(mesh)
    faces = [
        cell_faces(HybridMesh(mesh.V, hexes, pyramids[:0], tets[:0])),
        cell_faces(HybridMesh(mesh.V, hexes[:0], pyramids, tets[:0])),
        cell_faces(HybridMesh(mesh.V, hexes[:0], pyramids[:0], tets)),
    ]
    quads, triangles = (_single([pair[part] for pair in faces]) for part in (0, 1))
    return list(zip(quads, triangles, strict=True))


def _single(groups: list[Ints]) -> list[Ints]:
    """Of each group of faces those that no other face of any group equals."""
    faces = np.concatenate(groups)
    _, which, use = np.unique(np.sort(faces, axis=1), axis=0, return_inverse=True, return_counts=True)
    single = use[which.reshape(-1)] == 1
    ends = np.cumsum([len(group) for group in groups])[:-1]
    return [group[kept] for group, kept in zip(groups, np.split(single, ends), strict=True)]

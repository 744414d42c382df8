"""The layers of the 3D view from meshes, lines and points."""

from __future__ import annotations

import base64
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints, Surface
from neurframe_cli.mesh.hex_shell import HEX_FACES
from neurframe_cli.mesh.read_cells import CellMesh
from neurframe_cli.picture.mesh_pictures import quality_colors
from neurframe_cli.picture.scene import FEATURE_COLOR
from neurframe_cli.report.layers import MOST_CELLS, MOST_CELLS_TOGETHER, Layer, ViewFrame
from neurframe_cli.report.tubes import tubes
from neurframe_cli.report.vtkjs import scene_archive

WORST_COLOR, DEFECT_COLOR = "#d6006c", "#d6006c"


@dataclass(frozen=True)
class HexFaces:
    """Every face of a hex mesh once: corners (f,4), and the hexes on its two sides (f,2), -1 for none."""

    corners: Ints
    owners: Ints

    @property
    def shell(self) -> Ints:
        """Indices of the faces of one hex only."""
        return np.flatnonzero(self.owners[:, 1] < 0)


def hex_faces(H: Ints) -> HexFaces:
    """The faces of hexes H (m,8) in VTK order, corners as the first owner sees them from outside.

    A face of three hexes or more is listed with two of them.
    """
    faces = H[:, HEX_FACES].reshape(-1, 4)
    _, first, which = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_inverse=True)
    owners = np.full((len(first), 2), -1, np.int64)
    owners[:, 0] = first // len(HEX_FACES)
    again = np.setdiff1d(np.arange(len(faces)), first)
    owners[which.reshape(-1)[again], 1] = again // len(HEX_FACES)
    return HexFaces(faces[first], owners)


def quad_layer(mesh: CellMesh, quality: Floats, *, shown: bool) -> Layer:
    """Quads coloured by quality."""
    title = f"quad mesh, {len(mesh.cells):,} quads"
    return Layer(title, mesh.V, mesh.cells, colors=quality_colors(quality), edges=True, shown=shown)


def hex_layer(mesh: CellMesh, faces: HexFaces, quality: Floats) -> Layer:
    """The outside of the hexes, coloured by quality."""
    shell = faces.shell
    colors = quality_colors(quality[faces.owners[shell, 0]])
    return Layer(
        f"hex mesh, {len(mesh.cells):,} hexes", mesh.V, faces.corners[shell], colors=colors, edges=True
    )


def worst_layer(mesh: CellMesh, worst: Ints) -> Layer:
    """Some cells by their number, as they are."""
    cells = mesh.cells[worst]
    faces = cells if mesh.kind == "quad" else cells[:, HEX_FACES].reshape(-1, 4)
    name = "hexes" if mesh.kind == "hex" else "quads"
    return Layer(
        f"worst {len(worst)} {name}", *_compact(mesh.V, faces), color=WORST_COLOR, edges=True, shown=False
    )


def surface_layer(surface: Surface, *, shown: bool) -> Layer:
    """The input, to be seen through."""
    return Layer("input surface", surface.V, surface.F, color="#8fa6bf", opacity=0.25, shown=shown)


def line_layer(title: str, V: Floats, edges: Ints, color: str, *, shown: bool = True) -> Layer:
    """Segments (k,2) one pixel wide."""
    return Layer(title, *_compact(V, edges), color=color, shown=shown, lit=False)


def tube_layer(title: str, V: Floats, edges: Ints, color: str, radius: float, *, shown: bool = True) -> Layer:
    """Segments (k,2) as tubes: WebGL draws no line wider than a pixel."""
    points, sides = tubes(V, edges, radius)
    return Layer(title, points, sides, color=color, shown=shown)


def point_layer(title: str, points: Floats, color: str, *, shown: bool = True) -> Layer:
    """Points (k,3)."""
    return Layer(title, points, np.arange(len(points))[:, None], color=color, shown=shown, lit=False)


def scene_document(layers: Sequence[Layer], cut: dict[str, Any] | None = None) -> dict[str, Any] | None:
    """What the script of the page needs: archive, controls, frame, cut; None where there is nothing to see.

    Layers that are too large for a page, the first ones having the first claim, are left out and named in `left_out`.
    """
    drawn = _that_fit(layers)
    if not drawn:
        return None
    frame = ViewFrame.around(np.concatenate([layer.V for layer in drawn]))
    return {
        "archive": scene_archive(drawn, frame),
        "layers": [
            {"title": layer.title, "shown": layer.shown, "ink": layer.color == FEATURE_COLOR}
            for layer in drawn
        ],
        "center": frame.center.tolist(),
        "diagonal": frame.diagonal,
        "cut": cut,
        "colored": any(layer.colors is not None for layer in drawn),
        "left_out": [layer.title for layer in layers if len(layer.cells) and layer not in drawn],
    }


def _that_fit(layers: Sequence[Layer]) -> list[Layer]:
    drawn: list[Layer] = []
    room = MOST_CELLS_TOGETHER
    for layer in layers:
        if 0 < len(layer.cells) <= min(room, MOST_CELLS):
            drawn.append(layer)
            room -= len(layer.cells)
    return drawn


def cut_document(title: str, faces: HexFaces, quality: Floats) -> dict[str, Any] | None:
    """What the page needs to cut the hexes of the layer `title`; None where they are too many for that."""
    if len(faces.corners) > MOST_CELLS:
        return None
    return {
        "layer": title,
        "corners": _packed(faces.corners, np.uint32),
        "owners": _packed(faces.owners, np.int32),
        "colors": _packed(quality_colors(quality), np.uint8),
    }


def _compact(V: Floats, cells: Ints) -> tuple[Floats, Ints]:
    """The vertices that the cells use, and the cells over them."""
    used, local = np.unique(cells, return_inverse=True)
    return V[used], local.reshape(cells.shape)


def _packed(values: Any, kind: Any) -> str:
    """The numbers row by row, little-endian, deflated, in base 64."""
    return base64.b64encode(zlib.compress(values.astype(kind).tobytes(), 9)).decode()

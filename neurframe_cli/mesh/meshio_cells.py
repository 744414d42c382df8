"""VTK, VTU and Gmsh files through meshio."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from neurframe_cli.errors import UnreadableFile
from neurframe_cli.mesh.arrays import Ints
from neurframe_cli.mesh.cells import Cells, no_cells
from neurframe_cli.mesh.open_file import foreign_reader

MESHIO_NAMES = {"vtk": "vtk", "vtu": "vtu", "msh": "gmsh"}
# cells of second order count as their corners
CORNERS = {"vertex": 1, "line": 2, "line3": 2, "triangle": 3, "triangle6": 3, "tetra": 4, "tetra10": 4}
# where the programs that write tagged meshes keep the number of the model's face or curve
TAG_ARRAYS = ("CellEntityIds", "gmsh:geometrical", "gmsh:physical", "medit:ref", "color", "colour", "tag")


def meshio_cells(path: Path, file_format: str) -> Cells:
    """Cells of a file in one of MESHIO_NAMES.

    HexMe and Gmsh write the model's corners, curves and faces as vertex, line and triangle cells: these become
    corners, edges and triangles with their tags.  Raises UnreadableFile.
    """
    import meshio

    if file_format == "vtu":
        _refuse_entities(path)
    with foreign_reader(path, "meshio"):
        mesh = meshio.read(path, file_format=MESHIO_NAMES[file_format])
        V = np.asarray(mesh.points, np.float64)
        blocks = {width: _blocks(mesh, width) for width in (1, 2, 3, 4)}
        tags = _triangle_tags(mesh)
    if V.ndim != 2 or V.shape[1] not in (2, 3):
        raise UnreadableFile(f"{path}: the points have the shape {V.shape}, (n, 3) is allowed")
    if V.shape[1] == 2:
        V = np.column_stack([V, np.zeros(len(V))])
    return Cells(
        V=V,
        edges=blocks[2],
        triangles=blocks[3],
        triangle_refs=tags,
        tets=blocks[4],
        corners=blocks[1][:, 0],
        other=tuple(sorted({block.type for block in mesh.cells} - set(CORNERS))),
    )


def _blocks(mesh: Any, width: int) -> Ints:
    """All cells with `width` corners, one below the other."""
    found = [np.asarray(b.data, np.int64)[:, :width] for b in mesh.cells if CORNERS.get(b.type) == width]
    return np.concatenate(found) if found else no_cells(width)


def _triangle_tags(mesh: Any) -> Ints:
    """Tag of each triangle by the first of TAG_ARRAYS that the file has, else -1."""
    name = next((name for name in TAG_ARRAYS if name in mesh.cell_data), None)
    tags = [
        np.full(len(block.data), -1, np.int64)
        if name is None
        else np.asarray(mesh.cell_data[name][i], np.int64).reshape(len(block.data))
        for i, block in enumerate(mesh.cells)
        if CORNERS.get(block.type) == 3
    ]
    return np.concatenate(tags) if tags else np.zeros(0, np.int64)


def _refuse_entities(path: Path) -> None:
    """A mesh needs no XML entities; a file that defines them may blow up to any size when it is parsed."""
    with path.open("rb") as file:
        if b"<!ENTITY" in file.read(1 << 16):
            raise UnreadableFile(f"{path}: the XML defines entities, which a mesh file does not need")

"""Reading quad and hex meshes: OFF, OVM, and whatever format meshio knows."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from neurframe_cli.errors import InvalidMesh, UnreadableFile
from neurframe_cli.mesh.arrays import Floats, Ints
from neurframe_cli.mesh.off import read_off_polygons
from neurframe_cli.mesh.open_file import check_file, foreign_reader, read_bytes
from neurframe_cli.mesh.ovm_hexes import hexes_of_ovm


@dataclass(frozen=True)
class CellMesh:
    """A quad mesh (cells (m,4)) or a hex mesh (cells (m,8), VTK order); kind is "quad" or "hex"."""

    kind: str
    V: Floats
    cells: Ints


_END_OF_PLY_HEADER = re.compile(rb"^\s*end_header\s*$", re.MULTILINE)
_PLY_ELEMENT = re.compile(rb"^\s*element\s+(\w{1,40})\s+(\d+)", re.MULTILINE)
# what may stand beside the cells without being part of the mesh: hex files often list their boundary
_ACCOMPANYING = {"hex": {"vertex", "line", "triangle", "quad"}, "quad": {"vertex", "line"}}


def read_cells(path: Path) -> CellMesh:
    """The quads or hexes of a file.

    Raises UnreadableFile, or InvalidMesh where there are none, where other cells are mixed in, or where an index or a
    coordinate is no use.
    """
    check_file(path)
    own = {".off": _off_blocks, ".ovm": _ovm_blocks}
    V, blocks = own.get(path.suffix.lower(), _meshio_blocks)(path)
    kind, name = ("hex", "hexahedron") if "hexahedron" in blocks else ("quad", "quad")
    if name not in blocks:
        raise InvalidMesh(f"{path}: no quads and no hexahedra, only {', '.join(sorted(blocks)) or 'nothing'}")
    others = {k: len(b) for k, b in blocks.items() if k != name and k not in _ACCOMPANYING[kind]}
    if others:
        raise InvalidMesh(f"{path}: beside {len(blocks[name])} {name}s there are other cells: {others}")
    if V.ndim != 2 or V.shape[1] not in (2, 3) or not np.isfinite(V).all():
        raise InvalidMesh(f"{path}: positions must be finite, with 2 or 3 coordinates")
    cells = blocks[name]
    if cells.size == 0 or cells.min() < 0 or cells.max() >= len(V):
        raise InvalidMesh(f"{path}: a cell names a vertex that is not there (the file has {len(V)})")
    return CellMesh(kind, np.pad(V, ((0, 0), (0, 3 - V.shape[1]))), cells)


def _meshio_blocks(path: Path) -> tuple[Floats, dict[str, Ints]]:
    """Positions, and the cells by meshio's name of their kind."""
    import meshio

    if path.suffix.lower() == ".ply":
        _check_ply(path)
    with foreign_reader(path, "meshio"):
        mesh = meshio.read(path)
        blocks = {kind: np.asarray(cells, np.int64) for kind, cells in mesh.cells_dict.items()}
        return np.asarray(mesh.points, np.float64), blocks


def _ovm_blocks(path: Path) -> tuple[Floats, dict[str, Ints]]:
    """The same of an OpenVolumeMesh, which meshio does not know."""
    V, hexes = hexes_of_ovm(path)
    return V, {"hexahedron": hexes}


def _check_ply(path: Path) -> None:
    """Raises UnreadableFile for what meshio takes for ever to read: a header without end, counts beyond all bounds."""
    content = read_bytes(path)
    end = _END_OF_PLY_HEADER.search(content)
    if end is None:
        raise UnreadableFile(f"{path}: the header does not end")
    for name, count in _PLY_ELEMENT.findall(content[: end.start()]):
        if len(count) > 18 or int(count) > len(content):  # an element takes a byte at least
            raise UnreadableFile(
                f"{path}: {count[:40].decode()} elements {name.decode()} in {len(content)} bytes"
            )


def _off_blocks(path: Path) -> tuple[Floats, dict[str, Ints]]:
    """The same of an OFF file, of which meshio reads triangles only."""
    V, polygons = read_off_polygons(path)
    names = {2: "line", 3: "triangle", 4: "quad"}
    blocks = {}
    for corners in sorted({len(polygon) for polygon in polygons}):
        rows = [polygon for polygon in polygons if len(polygon) == corners]
        blocks[names.get(corners, f"polygon of {corners} corners")] = np.array(rows, np.int64)
    return V, blocks

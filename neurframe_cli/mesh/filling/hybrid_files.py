"""Meshes of hexes, pyramids and tets as files."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from neurframe_cli.errors import InputError, InvalidMesh, UnsupportedFormat
from neurframe_cli.mesh.arrays import Ints
from neurframe_cli.mesh.filling.hybrid_mesh import HybridMesh
from neurframe_cli.mesh.open_file import check_file, foreign_reader, quiet

# meshio's name of the format; Gmsh's 2.2 is the one that every program reads
MESHIO_FORMATS = {".vtu": "vtu", ".vtk": "vtk", ".msh": "gmsh22"}
KINDS = {"hexahedron": 8, "pyramid": 5, "tetra": 4}


def check_hybrid_output(path: Path) -> None:
    """Raises UnsupportedFormat unless write_hybrid can write to `path`."""
    if path.suffix.lower() not in MESHIO_FORMATS:
        raise UnsupportedFormat(
            f"{path}: no mesh of hexes, pyramids and tets is written as "
            f"{path.suffix or 'a file without extension'}",
            hint="formats with --fill: " + ", ".join(MESHIO_FORMATS),
        )


def write_hybrid(path: Path, mesh: HybridMesh) -> None:
    """Write to `path`, the format by its extension."""
    import meshio

    check_hybrid_output(path)
    blocks = zip(KINDS, (mesh.hexes, mesh.pyramids, mesh.tets), strict=True)
    cells = [(name, cells) for name, cells in blocks if len(cells)]
    with quiet():
        meshio.Mesh(mesh.V, cells).write(path, file_format=MESHIO_FORMATS[path.suffix.lower()])


def is_hybrid(path: Path) -> bool:
    """Whether the file holds hexes together with pyramids or tets; False for what cannot be read."""
    try:
        mesh = read_hybrid(path) if path.suffix.lower() in MESHIO_FORMATS else None
    except InputError:
        return False
    return mesh is not None and len(mesh.hexes) > 0 and len(mesh.pyramids) + len(mesh.tets) > 0


def read_hybrid(path: Path) -> HybridMesh:
    """What write_hybrid wrote; raises UnreadableFile, or InvalidMesh where there are other cells."""
    import meshio

    check_file(path)
    with foreign_reader(path, "meshio"):
        found = meshio.read(path)
        blocks = {name: np.asarray(cells, np.int64) for name, cells in found.cells_dict.items()}
        V = np.asarray(found.points, np.float64)
    others = sorted(blocks.keys() - KINDS.keys())
    if others:
        raise InvalidMesh(f"{path}: cells that are neither hexes, pyramids nor tets: {', '.join(others)}")
    hexes, pyramids, tets = (_block(blocks, name, width) for name, width in KINDS.items())
    for cells in (hexes, pyramids, tets):
        if cells.size and (cells.min() < 0 or cells.max() >= len(V)):
            raise InvalidMesh(f"{path}: a cell names a vertex that is not there (the file has {len(V)})")
    return HybridMesh(V, hexes, pyramids, tets)


def _block(blocks: dict[str, Ints], name: str, width: int) -> Ints:
    return blocks.get(name, np.zeros((0, width), np.int64))

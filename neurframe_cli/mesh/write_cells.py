"""Writing quad and hex meshes, in any format that meshio writes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neurframe_cli.errors import UnsupportedFormat
from neurframe_cli.mesh.read_cells import CellMesh

# what the writers of meshio cannot do with quads or hexes is refused by name here instead of half done
FORMATS = {
    "quad": (".obj", ".ply", ".off", ".vtk", ".vtu", ".mesh", ".msh", ".inp", ".bdf", ".xdmf", ".glb"),
    "hex": (".vtk", ".vtu", ".mesh", ".msh", ".inp", ".bdf", ".xdmf"),
}


def check_output(path: Path, kind: str) -> None:
    """Raises UnsupportedFormat unless write_cells can write a mesh of this kind to `path`."""
    if path.suffix.lower() not in FORMATS[kind]:
        raise UnsupportedFormat(
            f"{path}: no {kind} mesh is written as {path.suffix or 'a file without extension'}",
            hint="formats: " + ", ".join(FORMATS[kind]),
        )


def write_cells(path: Path, mesh: CellMesh) -> None:
    """Write to `path`, the format by its extension; the same mesh gives the same bytes."""
    check_output(path, mesh.kind)
    suffix = path.suffix.lower()
    if suffix == ".obj":
        path.write_text(_obj(mesh), encoding="ascii")
    elif suffix == ".off":
        path.write_text(_off(mesh), encoding="ascii")
    elif suffix == ".glb":
        _write_glb(path, mesh)
    else:
        _through_meshio(path, mesh)


def _through_meshio(path: Path, mesh: CellMesh) -> None:
    import meshio

    name = "hexahedron" if mesh.kind == "hex" else "quad"
    # meshio's PLY writer wants 32-bit indices
    cells = mesh.cells.astype(np.int32) if path.suffix.lower() == ".ply" else mesh.cells
    meshio.Mesh(mesh.V, [(name, cells)]).write(path)


def _lines(rows: NDArray[Any], start: str = "") -> str:
    return "".join(start + " ".join(map(repr, row)) + "\n" for row in rows.tolist())


def _obj(mesh: CellMesh) -> str:
    return _lines(mesh.V, "v ") + _lines(mesh.cells + 1, "f ")


def _off(mesh: CellMesh) -> str:
    return f"OFF\n{len(mesh.V)} {len(mesh.cells)} 0\n" + _lines(mesh.V) + _lines(mesh.cells, "4 ")


def _write_glb(path: Path, mesh: CellMesh) -> None:
    """glTF knows triangles only: each quad becomes two, in order."""
    import trimesh

    from neurframe_cli.mesh.quality.polygons import triangulated

    path.write_bytes(trimesh.Trimesh(mesh.V, triangulated(mesh.cells), process=False).export(file_type="glb"))

"""Writing quad and hex meshes, in any format that meshio writes."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from neurframe_cli.errors import UnsupportedFormat
from neurframe_cli.mesh.ovm_hexes import ovm_of_hexes
from neurframe_cli.mesh.read_cells import CellMesh

EXODUS_EXTENSIONS = (".e", ".exo", ".ex2")

# what the writers of meshio cannot do with quads or hexes is refused by name here instead of half done
FORMATS = {
    "quad": (".obj", ".ply", ".off", ".vtk", ".vtu", ".mesh", ".msh", ".inp", ".bdf", ".glb"),
    "hex": (".vtk", ".vtu", ".mesh", ".msh", ".inp", ".bdf", ".ovm", *EXODUS_EXTENSIONS),
}


def check_output(path: Path, kind: str) -> None:
    """Raises UnsupportedFormat unless write_cells can write a mesh of this kind to `path`."""
    if path.suffix.lower() not in FORMATS[kind]:
        raise UnsupportedFormat(
            f"{path}: no {kind} mesh is written as {path.suffix or 'a file without extension'}",
            hint="formats: " + ", ".join(FORMATS[kind]),
        )
    if path.suffix.lower() in EXODUS_EXTENSIONS and importlib.util.find_spec("netCDF4") is None:
        raise UnsupportedFormat(
            f"{path}: Exodus needs netCDF4, which is not installed", hint="pip install 'neurframe[exodus]'"
        )


def write_cells(path: Path, mesh: CellMesh) -> None:
    """Write to `path`, the format by its extension; the same mesh gives the same bytes."""
    check_output(path, mesh.kind)
    suffix = path.suffix.lower()
    if suffix == ".obj":
        path.write_text(_obj(mesh), encoding="ascii")
    elif suffix == ".off":
        path.write_text(_off(mesh), encoding="ascii")
    elif suffix == ".bdf":
        path.write_text(_bdf(mesh), encoding="ascii")
    elif suffix == ".ply":
        path.write_bytes(_ply(mesh))
    elif suffix == ".glb":
        _write_glb(path, mesh)
    elif suffix == ".ovm":
        path.write_text(ovm_of_hexes(mesh.V, mesh.cells), encoding="ascii")
    elif suffix in EXODUS_EXTENSIONS:
        # 32 bits: VTK's reader, and so ParaView, takes connectivity of 64 bits for zeros
        _through_meshio(path, CellMesh(mesh.kind, mesh.V, mesh.cells.astype(np.int32)))
    else:
        _through_meshio(path, mesh)


def _through_meshio(path: Path, mesh: CellMesh) -> None:
    import meshio

    name = "hexahedron" if mesh.kind == "hex" else "quad"
    meshio.Mesh(mesh.V, [(name, mesh.cells)]).write(path)


def _lines(rows: NDArray[Any], start: str = "") -> str:
    return "".join(start + " ".join(map(repr, row)) + "\n" for row in rows.tolist())


def _obj(mesh: CellMesh) -> str:
    return _lines(mesh.V, "v ") + _lines(mesh.cells + 1, "f ")


def _off(mesh: CellMesh) -> str:
    return f"OFF\n{len(mesh.V)} {len(mesh.cells)} 0\n" + _lines(mesh.V) + _lines(mesh.cells, "4 ")


def _bdf(mesh: CellMesh) -> str:
    """Nastran bulk data, points in columns of 16; meshio's writer has no room for a negative number below 1 there."""
    points = (
        f"GRID*   {number:16d}{'':16}{x:16.9E}{y:16.9E}\n*       {z:16.9E}\n"
        for number, (x, y, z) in enumerate(mesh.V.tolist(), 1)
    )
    name = "CHEXA" if mesh.kind == "hex" else "CQUAD4"
    cells = (
        f"{name:8}{number:8d}{1:8d}"
        + "".join(f"{v:8d}" for v in corners[:6])
        + "\n"
        + _continued(corners[6:])
        for number, corners in enumerate((mesh.cells + 1).tolist(), 1)
    )
    return "BEGIN BULK\n" + "".join(points) + "".join(cells) + "ENDDATA\n"


def _continued(corners: list[int]) -> str:
    return "+" + " " * 7 + "".join(f"{v:8d}" for v in corners) + "\n" if corners else ""


def _ply(mesh: CellMesh) -> bytes:
    """Binary PLY with double coordinates; meshio's has the date in it."""
    head = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(mesh.V)}\nproperty double x\nproperty double y\nproperty double z\n"
        f"element face {len(mesh.cells)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    corners = mesh.cells.shape[1]
    faces = np.zeros(len(mesh.cells), [("count", "u1"), ("vertices", "<i4", corners)])
    faces["count"], faces["vertices"] = corners, mesh.cells
    return head.encode("ascii") + mesh.V.astype("<f8").tobytes() + faces.tobytes()


def _write_glb(path: Path, mesh: CellMesh) -> None:
    """glTF knows triangles only: each quad becomes two, in order."""
    import trimesh

    from neurframe_cli.mesh.quality.polygons import triangulated

    path.write_bytes(trimesh.Trimesh(mesh.V, triangulated(mesh.cells), process=False).export(file_type="glb"))

"""Writes surfaces and tet meshes; the extension chooses the format."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from neurframe_cli.errors import UnsupportedFormat
from neurframe_cli.mesh.arrays import Features, Surface, TetMesh
from neurframe_cli.mesh.medit import write_medit
from neurframe_cli.mesh.open_file import quiet

SURFACE_EXTENSIONS = (".ply", ".stl", ".obj", ".off", ".vtk", ".vtu")
TET_EXTENSIONS = (".mesh", ".vtk", ".vtu", ".msh")
MESHIO_NAMES = {".vtk": "vtk", ".vtu": "vtu", ".msh": "gmsh22"}


def write_surface(path: Path, surface: Surface) -> None:
    """Writes a surface in one of SURFACE_EXTENSIONS: PLY and STL binary (STL in float32), the others as text or
    as meshio writes them.  Raises UnsupportedFormat."""
    extension = path.suffix.lower()
    if extension not in SURFACE_EXTENSIONS:
        raise _unsupported(path, SURFACE_EXTENSIONS)
    if extension == ".ply":
        path.write_bytes(_ply(surface))
    elif extension == ".obj":
        path.write_text(_vertex_lines("v ", surface) + _face_lines("f ", surface, 1), encoding="ascii")
    elif extension == ".off":
        head = f"OFF\n{len(surface.V)} {len(surface.F)} 0\n"
        path.write_text(head + _vertex_lines("", surface) + _face_lines("3 ", surface, 0), encoding="ascii")
    elif extension == ".stl":
        path.write_bytes(_stl(surface))
    else:
        _write_meshio(path, surface.V, {"triangle": surface.F})


def write_tets(path: Path, mesh: TetMesh, features: Features | None = None) -> None:
    """Writes a tet mesh in one of TET_EXTENSIONS; feature edges become line cells.  Raises UnsupportedFormat."""
    extension = path.suffix.lower()
    if extension not in TET_EXTENSIONS:
        raise _unsupported(path, TET_EXTENSIONS)
    if extension == ".mesh":
        write_medit(path, mesh, features)
        return
    lines = {"line": features.edges} if features is not None and len(features.edges) else {}
    _write_meshio(path, mesh.V, {**lines, "tetra": mesh.T})


def _write_meshio(path: Path, V: object, cells: dict[str, object]) -> None:
    import meshio

    with quiet():
        meshio.Mesh(V, cells).write(path, file_format=MESHIO_NAMES[path.suffix.lower()])


def _unsupported(path: Path, allowed: tuple[str, ...]) -> UnsupportedFormat:
    return UnsupportedFormat(
        f"{path}: no writer for {path.suffix or 'a name without extension'}", hint=" ".join(allowed)
    )


def _vertex_lines(start: str, surface: Surface) -> str:
    return "".join(f"{start}{x!r} {y!r} {z!r}\n" for x, y, z in surface.V.tolist())


def _face_lines(start: str, surface: Surface, first: int) -> str:
    return "".join(f"{start}{a} {b} {c}\n" for a, b, c in (surface.F + first).tolist())


def _ply(surface: Surface) -> bytes:
    """Binary PLY with double coordinates, so that what is read back is what was written."""
    head = (
        "ply\nformat binary_little_endian 1.0\n"
        f"element vertex {len(surface.V)}\nproperty double x\nproperty double y\nproperty double z\n"
        f"element face {len(surface.F)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    faces = np.zeros(len(surface.F), [("count", "u1"), ("vertices", "<i4", 3)])
    faces["count"], faces["vertices"] = 3, surface.F
    return head.encode("ascii") + surface.V.astype("<f8").tobytes() + faces.tobytes()


def _stl(surface: Surface) -> bytes:
    """Binary STL; readers compute the normals themselves, so they stay zero."""
    triangles = np.zeros(
        len(surface.F), [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("unused", "<u2")]
    )
    triangles["corners"] = surface.V[surface.F]
    return b"neurframe".ljust(80) + np.uint32(len(surface.F)).tobytes() + triangles.tobytes()

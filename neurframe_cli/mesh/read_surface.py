"""Triangle surfaces from files."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from neurframe_cli.errors import InvalidMesh, UnreadableFile
from neurframe_cli.mesh.arrays import Surface, as_surface
from neurframe_cli.mesh.cells import Cells
from neurframe_cli.mesh.check_tets import check_indices
from neurframe_cli.mesh.file_format import CELL_FORMATS, file_format
from neurframe_cli.mesh.off import read_off
from neurframe_cli.mesh.open_archive import check_archive
from neurframe_cli.mesh.open_file import foreign_reader, refuse_empty
from neurframe_cli.mesh.read_step import read_step
from neurframe_cli.mesh.read_tets import CELL_READERS
from neurframe_cli.mesh.tet_adjacency import tet_adjacency


def read_surface(path: Path) -> Surface:
    """The triangles of a surface file as they stand there, or the boundary of a tet mesh.

    Polygons are triangulated, the parts of a scene put together.  Vertices keep the file's order where the format
    has one; nothing is welded or repaired (that is clean_surface).  Raises UnreadableFile, UnsupportedFormat,
    InvalidMesh.
    """
    name = file_format(path)
    if name in CELL_FORMATS:
        return surface_from_cells(path, CELL_READERS[name](path))
    surface = SURFACE_READERS[name](path)
    refuse_empty(path, "triangles", len(surface.F))
    check_indices(surface.V, surface.F, path, "triangle")
    return surface


def surface_from_cells(path: Path, cells: Cells) -> Surface:
    """The triangles of a volume file, else the boundary of its tets; raises InvalidMesh."""
    check_indices(cells.V, cells.triangles, path, "triangle")
    check_indices(cells.V, cells.tets, path, "tet")
    if len(cells.tets):
        try:
            return as_surface(cells.V, tet_adjacency(cells.tets).boundary_faces)
        except ValueError as error:
            raise InvalidMesh(f"{path}: {error}") from error
    if cells.other:
        raise InvalidMesh(f"{path}: the file has cells that are neither triangles nor tets: {cells.other}")
    refuse_empty(path, "triangles or tets", len(cells.triangles))
    return as_surface(cells.V, cells.triangles)


def _through_trimesh(path: Path, file_type: str) -> Surface:
    import trimesh

    with foreign_reader(path, "trimesh"), path.open("rb") as file:
        loaded = trimesh.load_scene(file, file_type=file_type, **_options(file_type))
        mesh = _single_mesh(loaded)
        V, F = np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces, np.int64)
    if V.ndim != 2 or V.shape[1] != 3 or F.ndim != 2 or F.shape[1] != 3:
        raise UnreadableFile(f"{path}: points {V.shape} and faces {F.shape}, (n, 3) and (m, 3) are allowed")
    return as_surface(V, F)


def _options(file_type: str) -> dict[str, Any]:
    """trimesh as a plain reader: no merging, no materials, OBJ vertices in the order of the file."""
    options: dict[str, Any] = {"process": False, "allow_remote": False}
    if file_type == "obj":
        options |= {"maintain_order": True, "skip_materials": True}
    return options


def _single_mesh(scene: Any) -> Any:
    """One mesh of all parts of a scene, in world coordinates."""
    import trimesh

    parts = [part for part in scene.dump() if isinstance(part, trimesh.Trimesh)]
    if not parts:
        raise ValueError("it holds no triangle mesh")
    return parts[0] if len(parts) == 1 else trimesh.util.concatenate(parts)


def _read_3mf(path: Path) -> Surface:
    """A 3MF file is a ZIP archive of XML."""
    with foreign_reader(path, "zipfile"), zipfile.ZipFile(path) as archive:
        entries = check_archive(path, archive)
        models = [entry for entry in entries if entry.filename.lower().endswith(".model")]
        for model in models:
            with archive.open(model) as file:
                if b"<!ENTITY" in file.read(1 << 16):
                    raise UnreadableFile(f"{path}: {model.filename} defines XML entities")
    if not models:
        raise UnreadableFile(f"{path}: a ZIP archive without a 3D model in it")
    return _through_trimesh(path, "3mf")


SURFACE_READERS: dict[str, Callable[[Path], Surface]] = {
    **{name: partial(_through_trimesh, file_type=name) for name in ("stl", "obj", "ply", "glb", "gltf")},
    "off": read_off,
    "3mf": _read_3mf,
    "step": read_step,
}

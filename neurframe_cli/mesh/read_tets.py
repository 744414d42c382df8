"""Tet meshes from files, with the feature edges that they carry."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

from neurframe_cli.errors import InvalidMesh, UnsupportedFormat
from neurframe_cli.mesh.arrays import Bools, Features, Floats, Ints, TetMesh
from neurframe_cli.mesh.cells import Cells
from neurframe_cli.mesh.check_tets import check_indices, checked_tets
from neurframe_cli.mesh.features import features_from_edges
from neurframe_cli.mesh.file_format import CELL_FORMATS, file_format
from neurframe_cli.mesh.medit import medit_cells
from neurframe_cli.mesh.meshio_cells import meshio_cells
from neurframe_cli.mesh.ovm import ovm_cells
from neurframe_cli.mesh.surface_edges import surface_edges
from neurframe_cli.mesh.tet_adjacency import tet_adjacency

SEAM_ANGLE_DEG = 30.0

CELL_READERS: dict[str, Callable[[Path], Cells]] = {
    "medit": medit_cells,
    "ovm": ovm_cells,
    **{name: partial(meshio_cells, file_format=name) for name in ("vtk", "vtu", "msh")},
}


def read_tets(path: Path) -> tuple[TetMesh, Features]:
    """The tets of a MEDIT, VTK, VTU, MSH or OVM file and the feature edges that the file names.

    Tets come in positive orientation and without unused vertices.  Raises UnreadableFile, UnsupportedFormat,
    InvalidMesh.
    """
    name = file_format(path)
    if name not in CELL_FORMATS:
        raise UnsupportedFormat(f"{path}: a surface ({name}), a tet mesh was expected")
    return tets_from_cells(path, CELL_READERS[name](path))


def read_medit(path: Path) -> tuple[TetMesh, Features]:
    """The tets and features of a MEDIT text file; raises UnreadableFile, InvalidMesh."""
    return tets_from_cells(path, medit_cells(path))


def tets_from_cells(path: Path, cells: Cells) -> tuple[TetMesh, Features]:
    """Checked tets and features of what was read; `path` is for messages.  Raises InvalidMesh."""
    if cells.other:
        raise InvalidMesh(
            f"{path}: the file has cells that are no tets ({', '.join(cells.other)})",
            hint="split the cells into tets, or give neurframe the surface",
        )
    mesh, new_number = checked_tets(cells.V, cells.tets, path)
    listed_cells = {"edge": cells.edges, "triangle": cells.triangles, "corner": cells.corners[:, None]}
    for kind, listed in listed_cells.items():
        check_indices(cells.V, listed, path, kind)
    is_seam = _is_seam(cells)
    edges = new_number[cells.edges[~is_seam]]
    # a curve may run through vertices of no tet, as Gmsh writes the centres of arcs
    edges = edges[(edges >= 0).all(axis=1)]
    edges = _on_boundary(mesh, edges)
    # where a seam meets a smooth curve, the file has a corner that the shape has not
    corners = new_number[np.setdiff1d(cells.corners, cells.edges[is_seam])]
    return mesh, features_from_edges(mesh.V, edges, corners[corners >= 0])


def _is_seam(cells: Cells) -> Bools:
    """(k,) which of the file's edges are seams.

    CAD kernels cut closed faces (cylinder, torus, sphere) open along a seam; such a curve has the same face of the
    model on both sides, smoothly, and is no feature of the shape.
    """
    tagged = len(cells.triangle_refs) == len(cells.triangles) > 0 and bool((cells.triangle_refs >= 0).all())
    if len(cells.edges) == 0 or not tagged:
        return np.zeros(len(cells.edges), np.bool_)
    smooth = _smooth_inside_one_face(cells.V, cells.triangles, cells.triangle_refs)
    return _among(np.sort(cells.edges, axis=1), smooth)


def _smooth_inside_one_face(V: Floats, triangles: Ints, refs: Ints) -> Ints:
    """(s,2) edges between two triangles of the same face of the model that meet at less than SEAM_ANGLE_DEG."""
    if len(np.unique(refs)) == 1 and (surface_edges(V, triangles).angles_deg > SEAM_ANGLE_DEG).any():
        # one number for a whole surface with sharp edges says nothing about faces
        return np.zeros((0, 2), np.int64)
    inside = [surface_edges(V, triangles[refs == ref]) for ref in np.unique(refs)]
    return np.concatenate([e.edges[(e.face_count == 2) & (e.angles_deg < SEAM_ANGLE_DEG)] for e in inside])


def _on_boundary(mesh: TetMesh, edges: Ints) -> Ints:
    """Those of `edges` that are edges of the boundary; none where the file lists the whole wireframe.

    TetGen and libigl write every edge of the mesh into the file, which says nothing about features.
    """
    if len(edges) == 0:
        return edges
    faces = tet_adjacency(mesh.T).boundary_faces
    boundary = np.unique(np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
    edges = np.unique(np.sort(edges, axis=1), axis=0)
    edges = edges[_among(edges, boundary)]
    return edges if len(edges) < len(boundary) else edges[:0]


def _among(edges: Ints, others: Ints) -> Bools:
    """(k,) whether each edge is in `others`; both sorted within their rows."""
    size = 1 + max(int(edges.max(initial=0)), int(others.max(initial=0)))
    return np.isin(edges[:, 0] * size + edges[:, 1], others[:, 0] * size + others[:, 1])

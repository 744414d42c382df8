"""Is this a tet mesh that one can compute on?"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from neurframe_cli.errors import InvalidMesh
from neurframe_cli.mesh.arrays import Floats, Ints, TetMesh, as_tets
from neurframe_cli.mesh.tet_adjacency import TET_FACES, tet_adjacency

# the third powers of lengths, and their sums, stay in the range of float64
LARGEST_COORDINATE = 1e90


def tet_volumes(V: Floats, T: Ints) -> Floats:
    """(m,) signed volumes, positive for det(v1-v0, v2-v0, v3-v0) > 0."""
    a, b, c = (V[T[:, i]] - V[T[:, 0]] for i in (1, 2, 3))
    return np.asarray(np.einsum("ij,ij->i", np.cross(a, b), c) / 6.0)


def check_indices(V: Floats, cells: Ints, name: str | Path, kind: str) -> None:
    """Raises InvalidMesh for a vertex that is not finite, and for a cell with a vertex that does not exist."""
    unfit = ~(np.abs(V) < LARGEST_COORDINATE).all(axis=1)
    if unfit.any():
        first = int(np.flatnonzero(unfit)[0])
        raise InvalidMesh(
            f"{name}: vertex {first} is {V[first].tolist()}, finite numbers below {LARGEST_COORDINATE:g} are allowed"
        )
    outside = ((cells < 0) | (cells >= len(V))).any(axis=1)
    if outside.any():
        first = int(np.flatnonzero(outside)[0])
        raise InvalidMesh(
            f"{name}: {kind} {first} has the vertices {cells[first].tolist()}, there are only {len(V)}"
        )


def checked_tets(V: Floats, T: Ints, name: str | Path = "tet mesh") -> tuple[TetMesh, Ints]:
    """The tets in positive orientation without unused vertices, and for each old vertex its new number or -1.

    Raises InvalidMesh naming the first element that is wrong: indices, coordinates, a repeated vertex, zero volume,
    a face of more than two tets, two tets that lie on the same side of their common face.
    """
    if len(T) == 0:
        raise InvalidMesh(f"{name}: the mesh has no tets")
    check_indices(V, T, name, "tet")
    repeated = (np.diff(np.sort(T, axis=1), axis=1) == 0).any(axis=1)
    if repeated.any():
        first = int(np.flatnonzero(repeated)[0])
        raise InvalidMesh(f"{name}: tet {first} has a vertex twice: {T[first].tolist()}")
    volumes = tet_volumes(V, T)
    _refuse_flat(V, T, volumes, name)
    T = np.where((volumes < 0)[:, None], T[:, [0, 1, 3, 2]], T)
    _refuse_overlap(T, name)
    used = np.unique(T)
    new_number = np.full(len(V), -1, np.int64)
    new_number[used] = np.arange(len(used))
    return as_tets(V[used], new_number[T]), new_number


def _refuse_flat(V: Floats, T: Ints, volumes: Floats, name: str | Path) -> None:
    # the rounding error of the determinant: below it the sign is noise
    size = np.ptp(V[T], axis=1).max(axis=1)
    flat = ~(np.abs(volumes) > 1e-15 * size**3)
    if flat.any():
        first = int(np.flatnonzero(flat)[0])
        raise InvalidMesh(
            f"{name}: {int(flat.sum())} tets have no volume, the first is tet {first}: {T[first].tolist()}",
            hint="repair the tet mesh, or give neurframe its surface",
        )


def _refuse_overlap(T: Ints, name: str | Path) -> None:
    """Two positive tets on the two sides of a face see its vertices in opposite order."""
    try:
        adjacency = tet_adjacency(T)
    except ValueError as error:
        raise InvalidMesh(f"{name}: {error}") from error
    tet, neighbor = adjacency.dual_edges.T
    opposite = T[neighbor][:, TET_FACES]
    shared = (np.sort(opposite, axis=2) == np.sort(adjacency.dual_faces, axis=1)[:, None]).all(axis=2)
    theirs = opposite[np.arange(len(neighbor)), shared.argmax(axis=1)]
    position = (adjacency.dual_faces == theirs[:, :1]).argmax(axis=1)
    following = adjacency.dual_faces[np.arange(len(tet)), (position + 1) % 3]
    overlap = following == theirs[:, 1]
    if overlap.any():
        first = int(np.flatnonzero(overlap)[0])
        raise InvalidMesh(
            f"{name}: tets {int(tet[first])} and {int(neighbor[first])} overlap: both lie on the same side of "
            f"face {adjacency.dual_faces[first].tolist()}"
        )

"""Hex meshes as OpenVolumeMesh text (.ovm): cells as half-faces of half-edges.

Format: Kremer, Bommes, Kobbelt, "OpenVolumeMesh", IMR 2012.  Half-edge and half-face 2i runs along edge or face i, 2i+1
against it; the half-faces of a cell look inward, as in the files of OpenVolumeMesh and AlgoHex.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from neurframe_cli.errors import InvalidMesh, UnreadableFile
from neurframe_cli.mesh.arrays import Floats, Ints
from neurframe_cli.mesh.hex_shell import HEX_FACES
from neurframe_cli.mesh.ovm import OvmLines


def ovm_of_hexes(V: Floats, H: Ints) -> str:
    """The text of hexes H (n,8) in VTK order over V (v,3)."""
    quads = H[:, HEX_FACES].reshape(-1, 4)
    _, first, which = np.unique(np.sort(quads, axis=1), axis=0, return_index=True, return_inverse=True)
    which = which.reshape(-1)
    # outward for the hex that has the face first, so that this one looks along its second half-face
    halffaces = 2 * which + (first[which] == np.arange(len(quads)))
    faces = quads[first]
    ends = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
    edges, edge = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True)
    halfedges = 2 * edge.reshape(-1) + (ends[:, 0] > ends[:, 1])
    return "OVM ASCII\n" + "".join(
        [
            _section("Vertices", V),
            _section("Edges", edges),
            _section("Faces", np.insert(halfedges.reshape(-1, 4), 0, 4, axis=1)),
            _section("Polyhedra", np.insert(halffaces.reshape(-1, 6), 0, 6, axis=1)),
        ]
    )


def _section(name: str, rows: Floats | Ints) -> str:
    return f"{name}\n{len(rows)}\n" + "".join(" ".join(map(repr, row)) + "\n" for row in rows.tolist())


def hexes_of_ovm(path: Path) -> tuple[Floats, Ints]:
    """Positions (v,3) and hexes (n,8) in VTK order; raises UnreadableFile, InvalidMesh naming a cell that is none."""
    lines = OvmLines(path)
    lines.expect("OVM ASCII")
    V = np.array([lines.floats(3) for _ in range(lines.count("Vertices"))], np.float64).reshape(-1, 3)
    edges = np.array([lines.integers(2) for _ in range(lines.count("Edges"))], np.int64).reshape(-1, 2)
    faces = _counted(lines, "Faces", 4, "edges")
    cells = _counted(lines, "Polyhedra", 6, "faces")
    _check_range(path, "half-edge", faces, 2 * len(edges))
    _check_range(path, "half-face", cells, 2 * len(faces))
    tails = np.stack([edges, edges[:, ::-1]], axis=1).reshape(-1, 2)[faces, 0]
    # from outside: a half-face that looks inward, turned round
    outward = np.where((cells % 2 == 1)[:, :, None], tails[cells // 2], tails[cells // 2][:, :, ::-1])
    return V, _hexes(path, outward)


def _counted(lines: OvmLines, section: str, wanted: int, of_what: str) -> Ints:
    rows = [lines.counted() for _ in range(lines.count(section))]
    for number, row in enumerate(rows):
        if len(row) != wanted:
            raise InvalidMesh(
                f"{lines.path}: {section.lower()} {number} has {len(row)} {of_what}, {wanted} are those of a hex mesh"
            )
    return np.array(rows, np.int64).reshape(-1, wanted)


def _check_range(path: Path, what: str, indices: Ints, count: int) -> None:
    wrong = (indices < 0) | (indices >= count)
    if wrong.any():
        raise UnreadableFile(f"{path}: {what} {int(indices[wrong][0])} does not exist, there are {count}")


def _hexes(path: Path, outward: Ints) -> Ints:
    """Hexes (n,8) of their six outward faces (n,6,4): the first is the bottom, and above each of its corners is the
    one that a side face has beside it."""
    n = len(outward)
    bottom = outward[:, 0, ::-1]
    ends = np.stack([outward[:, 1:], np.roll(outward[:, 1:], -1, axis=2)], axis=3).reshape(n, 20, 2)
    top = np.full((n, 4), -1, np.int64)
    for corner in range(4):
        starts = ends[:, :, 0] == bottom[:, corner, None]
        upward = starts & (ends[:, :, 1, None] != bottom[:, None, :]).all(axis=2)
        found = np.where(upward.any(axis=1), ends[np.arange(n), upward.argmax(axis=1), 1], -1)
        top[:, corner] = found
    hexes = np.concatenate([bottom, top], axis=1)
    made, given = _in_order(hexes[:, HEX_FACES]), _in_order(outward)
    wrong = (hexes < 0).any(axis=1) | (made != given).any(axis=(1, 2))
    if wrong.any():
        raise InvalidMesh(f"{path}: the faces of cell {int(np.flatnonzero(wrong)[0])} do not close to a hex")
    return hexes


def _in_order(faces: Ints) -> Ints:
    """The faces (n,6,4) with their vertices and then themselves sorted."""
    rows = np.sort(faces, axis=2)
    order = np.lexsort(np.moveaxis(rows, 2, 0)[::-1], axis=1)
    return np.take_along_axis(rows, order[:, :, None], axis=1)

"""OpenVolumeMesh text files (.ovm): cells as half-faces of half-edges, read back into tets.

Format: Kremer, Bommes, Kobbelt, "OpenVolumeMesh", IMR 2012, and the library's file documentation.
Half-edge and half-face 2i runs along edge or face i, 2i+1 against it.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import numpy as np

from neurframe_cli.errors import InvalidMesh, UnreadableFile
from neurframe_cli.mesh.arrays import Bools, Ints
from neurframe_cli.mesh.cells import Cells, no_cells
from neurframe_cli.mesh.open_file import read_bytes

Number = TypeVar("Number", int, float)
EDGE_PROPERTY = ("eprop", "edge_property")


def ovm_cells(path: Path) -> Cells:
    """Cells of an OVM text file.

    An integer edge property with `feature` in its name marks feature edges, as AlgoHex writes it.  Raises
    UnreadableFile for a broken file, InvalidMesh naming the first cell that is no tet.
    """
    lines = OvmLines(path)
    lines.expect("OVM ASCII")
    V = np.array([lines.floats(3) for _ in range(lines.count("Vertices"))]).reshape(-1, 3)
    edges = np.array([lines.integers(2) for _ in range(lines.count("Edges"))], np.int64).reshape(-1, 2)
    faces = [lines.counted() for _ in range(lines.count("Faces"))]
    cells = [lines.counted() for _ in range(lines.count("Polyhedra"))]
    corners_of_face = _face_vertices(path, edges, faces)
    tets = _tets(path, corners_of_face, cells)
    return Cells(V=V, edges=edges[_feature_edges(lines, len(edges))], tets=tets, triangles=corners_of_face)


def _face_vertices(path: Path, edges: Ints, faces: list[list[int]]) -> Ints:
    """(f,3) vertices of the faces; raises InvalidMesh for a face that is no closed triangle."""
    for number, face in enumerate(faces):
        if len(face) != 3:
            raise InvalidMesh(f"{path}: face {number} has {len(face)} edges, only tet meshes are read")
    if not faces:
        return no_cells(3)
    halfedges = np.array(faces, np.int64)
    _check_range(path, "half-edge", halfedges, 2 * len(edges))
    directed = np.stack([edges, edges[:, ::-1]], axis=1).reshape(-1, 2)
    tails, heads = directed[halfedges][..., 0], directed[halfedges][..., 1]
    open_faces = (heads != np.roll(tails, -1, axis=1)).any(axis=1)
    if open_faces.any():
        raise InvalidMesh(f"{path}: the edges of face {int(np.flatnonzero(open_faces)[0])} form no loop")
    return np.asarray(tails, np.int64)


def _tets(path: Path, triangles: Ints, cells: list[list[int]]) -> Ints:
    """(m,4) vertices of the cells: a face and the vertex of the cell that is not on it."""
    for number, cell in enumerate(cells):
        if len(cell) != 4:
            raise InvalidMesh(
                f"{path}: cell {number} has {len(cell)} faces, a tet has 4",
                hint="split the cells into tets first",
            )
    if not cells:
        return no_cells(4)
    halffaces = np.array(cells, np.int64)
    _check_range(path, "half-face", halffaces, 2 * len(triangles))
    corners = np.sort(triangles[halffaces // 2].reshape(-1, 12), axis=1)
    # a closed tet has four vertices, each on three of its faces
    proper = (corners.reshape(-1, 4, 3) == corners[:, ::3, None]).all(axis=(1, 2))
    proper &= (np.diff(corners[:, ::3], axis=1) > 0).all(axis=1)
    if not proper.all():
        raise InvalidMesh(
            f"{path}: the faces of cell {int(np.flatnonzero(~proper)[0])} do not close to a tet"
        )
    return corners[:, ::3]


def _check_range(path: Path, what: str, indices: Ints, count: int) -> None:
    wrong = (indices < 0) | (indices >= count)
    if wrong.any():
        raise InvalidMesh(f"{path}: {what} {int(indices[wrong][0])} does not exist, there are {count}")


def _feature_edges(lines: OvmLines, edge_count: int) -> Bools:
    """Which edges a property marks as features."""
    marked = np.zeros(edge_count, np.bool_)
    while (line := lines.next_or_none()) is not None:
        words = line.split()
        if words[0].lower() not in EDGE_PROPERTY or "feature" not in line.lower():
            continue
        values = [lines.next_or_none() for _ in range(edge_count)]
        try:
            marked |= np.array([int(value or "") != 0 for value in values], np.bool_)
        except ValueError as error:
            raise UnreadableFile(f"{lines.path}: edge property {line!r}: {error}") from error
    return marked


class OvmLines:
    """The lines of a file that say something, one after the other."""

    def __init__(self, path: Path) -> None:
        self.path = path
        text = read_bytes(path).decode("utf-8", "replace")
        stripped = (line.strip() for line in text.splitlines())
        self._lines = [line for line in stripped if line and not line.startswith("#")]
        self._next = 0

    def next_or_none(self) -> str | None:
        if self._next == len(self._lines):
            return None
        self._next += 1
        return self._lines[self._next - 1]

    def next(self) -> str:
        line = self.next_or_none()
        if line is None:
            raise UnreadableFile(f"{self.path}: the file ends too early")
        return line

    def expect(self, words: str) -> None:
        line = self.next()
        if line.lower() != words.lower():
            raise UnreadableFile(f"{self.path}: expected {words!r}, found {line[:40]!r}")

    def count(self, section: str) -> int:
        self.expect(section)
        (count,) = self.integers(1)
        if count < 0 or count > len(self._lines) - self._next:
            raise UnreadableFile(
                f"{self.path}: section {section} announces {count} lines, the file has fewer"
            )
        return count

    def floats(self, width: int) -> list[float]:
        values = [self._number(word, float) for word in self._words(width)]
        if not np.isfinite(values).all():
            raise UnreadableFile(f"{self.path}: a coordinate is {values}, finite numbers are allowed")
        return values

    def integers(self, width: int) -> list[int]:
        return [self._number(word, _index) for word in self._words(width)]

    def counted(self) -> list[int]:
        """The integers of a line that begins with how many follow."""
        count, *values = (self._number(word, _index) for word in self.next().split())
        if count != len(values):
            raise UnreadableFile(f"{self.path}: a line announces {count} indices and has {len(values)}")
        return values

    def _words(self, width: int) -> list[str]:
        line = self.next()
        words = line.split()
        if len(words) != width:
            raise UnreadableFile(f"{self.path}: line {line[:40]!r}: {width} numbers expected")
        return words

    def _number(self, word: str, convert: Callable[[str], Number]) -> Number:
        try:
            return convert(word)
        except ValueError as error:
            raise UnreadableFile(f"{self.path}: {error}") from error


def _index(word: str) -> int:
    """An integer that an array of indices can hold."""
    value = int(word)
    if abs(value) >= 2**62:
        raise ValueError(f"{word[:40]} is no index")
    return value

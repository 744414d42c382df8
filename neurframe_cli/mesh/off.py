"""OFF text files, with polygons of any length and with the colours and normals that some programs add."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from neurframe_cli.errors import UnreadableFile, UnsupportedFormat
from neurframe_cli.mesh.arrays import Floats, Surface, as_surface
from neurframe_cli.mesh.open_file import read_bytes
from neurframe_cli.mesh.polygons import triangulate

COMMENT = re.compile(rb"#[^\n]*")
HEAD = re.compile(rb"\s*(?:ST)?C?N?OFF\b(?P<binary>[ \t]+BINARY)?")


def read_off(path: Path) -> Surface:
    """The triangulated faces of an OFF file; raises UnreadableFile, UnsupportedFormat."""
    V, polygons = read_off_polygons(path)
    return as_surface(V, triangulate(V, polygons))


def read_off_polygons(path: Path) -> tuple[Floats, list[list[int]]]:
    """V (n,3) and the faces of an OFF file as they stand there; raises UnreadableFile, UnsupportedFormat."""
    content = read_bytes(path).removeprefix(b"\xef\xbb\xbf")
    text = COMMENT.sub(b"", content)
    head = HEAD.match(text)
    if head is None or head["binary"]:
        raise UnsupportedFormat(f"{path}: OFF in binary or in other than three dimensions is not read")
    lines = [line for line in text[head.end() :].split(b"\n") if line.strip()]
    counts = _numbers(path, lines[0] if lines else b"")
    vertex_count, face_count = _counts(path, counts, len(lines))
    V = _vertices(path, lines[1 : 1 + vertex_count])
    polygons = [_polygon(path, line) for line in lines[1 + vertex_count : 1 + vertex_count + face_count]]
    if any(max(polygon) >= vertex_count or min(polygon) < 0 for polygon in polygons):
        raise UnreadableFile(f"{path}: a face names a vertex beyond the {vertex_count} of the file")
    return V, polygons


def _counts(path: Path, counts: list[float], line_count: int) -> tuple[int, int]:
    wanted = (*counts, -1.0, -1.0)[:2]
    vertices, faces = (int(count) if 0 <= count < 2**53 and count.is_integer() else -1 for count in wanted)
    if vertices < 0 or faces < 0 or 1 + vertices + faces > line_count:
        raise UnreadableFile(f"{path}: the counts {counts} and the {line_count} lines of the file do not fit")
    return vertices, faces


def _vertices(path: Path, lines: list[bytes]) -> Floats:
    """(n,3): the first three numbers of each line."""
    rows = [_numbers(path, line)[:3] for line in lines]
    if any(len(row) != 3 for row in rows):
        raise UnreadableFile(f"{path}: a vertex has fewer than three coordinates")
    return np.array(rows, np.float64).reshape(-1, 3)


def _polygon(path: Path, line: bytes) -> list[int]:
    words = line.split()
    try:
        count = int(words[0])
        polygon = [int(word) for word in words[1 : 1 + count]]
    except ValueError as error:
        raise UnreadableFile(f"{path}: face {line[:40]!r}: {error}") from error
    if count < 1 or len(polygon) != count:
        raise UnreadableFile(f"{path}: face {line[:40]!r} announces {count} vertices")
    return polygon


def _numbers(path: Path, line: bytes) -> list[float]:
    try:
        return [float(word) for word in line.split()]
    except ValueError as error:
        raise UnreadableFile(f"{path}: line {line[:40]!r}: {error}") from error

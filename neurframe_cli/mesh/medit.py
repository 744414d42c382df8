"""MEDIT text files (.mesh): the project's own reader and writer of tet meshes.

Format: INRIA, "MEDIT: an interactive mesh visualization software", technical report 0253 (2001).
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from neurframe_cli.errors import UnreadableFile
from neurframe_cli.mesh.arrays import Features, Floats, Ints, TetMesh
from neurframe_cli.mesh.cells import Cells, no_cells
from neurframe_cli.mesh.open_file import read_bytes
from neurframe_cli.mesh.tet_adjacency import tet_adjacency

# numbers per entry of the sections that are read, the reference included
WIDTHS = {
    "Edges": 3,
    "Ridges": 1,
    "Corners": 1,
    "Triangles": 4,
    "Quadrilaterals": 5,
    "Tetrahedra": 5,
    "Hexahedra": 9,
}
COMMENT = re.compile(rb"#[^\n]*")
# a word that is no part of a number (1e5, 1.d0) and no spelling of infinity or not-a-number
KEYWORD = re.compile(rb"(?<![\w.+-])(?!nan\b|inf\b|infinity\b)[A-Za-z]\w*", re.IGNORECASE)


def medit_cells(path: Path) -> Cells:
    """Cells of a MEDIT text file; raises UnreadableFile naming the section that is broken."""
    sections = _sections(path, COMMENT.sub(b"", read_bytes(path)))
    dimension = _dimension(path, sections)
    V = _table(path, "Vertices", sections.get("Vertices"), dimension + 1)[:, :dimension]
    if dimension == 2:
        V = np.column_stack([V, np.zeros(len(V))])
    tables = {name: _integers(path, name, sections.get(name), width) for name, width in WIDTHS.items()}
    edges = tables["Edges"][:, :2] - 1
    if "Ridges" in sections:
        ridges = tables["Ridges"][:, 0] - 1
        if len(ridges) and (ridges.min() < 0 or ridges.max() >= len(edges)):
            raise UnreadableFile(f"{path}: section Ridges names an edge that section Edges does not have")
        edges = edges[ridges]
    return Cells(
        V=V,
        edges=edges,
        triangles=tables["Triangles"][:, :3] - 1,
        triangle_refs=tables["Triangles"][:, 3],
        tets=tables["Tetrahedra"][:, :4] - 1,
        corners=tables["Corners"][:, 0] - 1,
        other=tuple(name for name in ("Quadrilaterals", "Hexahedra") if len(tables[name])),
    )


def write_medit(path: Path, mesh: TetMesh, features: Features | None = None) -> None:
    """Writes `mesh` as MEDIT text: vertices, boundary triangles, tets, and features as Edges, Ridges, Corners.

    Numbers are the shortest that read back as the same float64.
    """
    blocks = ["MeshVersionFormatted 2\nDimension 3\n"]
    blocks.append(
        f"Vertices\n{len(mesh.V)}\n" + "".join(f"{x!r} {y!r} {z!r} 0\n" for x, y, z in mesh.V.tolist())
    )
    if features is not None:
        count = len(features.edges)
        blocks.append(_block("Edges", features.edges + 1, reference=1))
        blocks.append(_block("Ridges", np.arange(1, count + 1)[:, None]))
        blocks.append(_block("Corners", features.corners[:, None] + 1))
    blocks.append(_block("Triangles", tet_adjacency(mesh.T).boundary_faces + 1, reference=1))
    blocks.append(_block("Tetrahedra", mesh.T + 1, reference=1))
    path.write_text("".join(blocks) + "End\n", encoding="ascii")


def _block(name: str, table: Ints, reference: int | None = None) -> str:
    """One section; an empty one is left out."""
    if len(table) == 0:
        return ""
    row = " ".join(["%d"] * table.shape[1]) + ("" if reference is None else f" {reference}") + "\n"
    return f"{name}\n{len(table)}\n" + (row * len(table)) % tuple(table.ravel().tolist())


def _sections(path: Path, text: bytes) -> dict[str, bytes]:
    """Text between each keyword and the next, by keyword."""
    marks = list(KEYWORD.finditer(text))
    sections: dict[str, bytes] = {}
    for mark, following in zip(marks, [*marks[1:], None], strict=True):
        name = mark.group().decode("ascii")
        body = text[mark.end() : following.start() if following else len(text)]
        if name in sections and name in ("Vertices", *WIDTHS):
            raise UnreadableFile(f"{path}: section {name} appears twice")
        sections[name] = body
    return sections


def _dimension(path: Path, sections: dict[str, bytes]) -> int:
    word = sections.get("Dimension", b"3").strip()
    if word not in (b"2", b"3"):
        raise UnreadableFile(f"{path}: Dimension is {word[:20]!r}, 2 or 3 is allowed")
    return int(word)


def _table(path: Path, name: str, body: bytes | None, width: int) -> Floats:
    """(count, width) numbers of a section whose body is a count and then that many rows."""
    if body is None:
        if name == "Vertices":
            raise UnreadableFile(f"{path}: section Vertices is missing")
        return np.zeros((0, width))
    numbers = _numbers(path, name, body)
    if len(numbers) == 0 or not np.isfinite(numbers[0]) or numbers[0] != len(numbers[1:]) / width:
        announced = f"{numbers[0]:g}" if len(numbers) else "no count"
        raise UnreadableFile(
            f"{path}: section {name} announces {announced} rows of {width} numbers "
            f"and holds {max(len(numbers) - 1, 0)} numbers"
        )
    return numbers[1:].reshape(-1, width)


def _integers(path: Path, name: str, body: bytes | None, width: int) -> Ints:
    table = _table(path, name, body, width)
    if len(table) == 0:
        return no_cells(width)
    wrong = ~(np.abs(table) < 2**53) | (table != np.floor(table))
    if wrong.any():
        row = int(np.flatnonzero(wrong.any(axis=1))[0])
        raise UnreadableFile(f"{path}: row {row + 1} of section {name} is not made of whole numbers")
    return table.astype(np.int64)


def _numbers(path: Path, name: str, body: bytes) -> Floats:
    words = body.split()
    try:
        return np.array(words, dtype="S").astype(np.float64) if words else np.zeros(0)
    except ValueError as error:
        raise UnreadableFile(f"{path}: section {name}: {error}") from error

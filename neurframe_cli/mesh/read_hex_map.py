"""Integer-grid maps of tets, in the text format of HexEx: positions, then corners and their parameters."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np

from neurframe_cli.errors import UnreadableFile
from neurframe_cli.mesh.arrays import Floats, Ints
from neurframe_cli.mesh.open_file import read_bytes

CORNERS = 4


@dataclass(frozen=True)
class HexMap:
    """V (n,3) float64, T (m,4) int64; parameters (m,4,3) float64 of the corners of each tet, in cells."""

    V: Floats
    T: Ints
    parameters: Floats


def read_hex_map(path: Path) -> HexMap:
    """The map of a .hexex file; parameters may be decimals or exact fractions `a/b`.

    Raises UnreadableFile where it is not laid out so: the number of vertices, a line of three numbers for each, the
    number of tets, a line of sixteen for each.
    """
    lines = read_bytes(path).decode("utf-8", errors="replace").splitlines()
    try:
        n = int(lines[0])
        V = _numbers(lines[1 : 1 + n], n, 3)
        m = int(lines[1 + n])
        table = _numbers(lines[2 + n : 2 + n + m], m, 4 * CORNERS)
    except (ValueError, IndexError, ZeroDivisionError) as error:
        raise UnreadableFile(f"{path}: no map in the format of HexEx: {error}") from error
    T = table[:, :CORNERS].astype(np.int64)
    if not np.isfinite(table).all() or not np.isfinite(V).all():
        raise UnreadableFile(f"{path}: a position or a parameter is not finite")
    if m == 0 or T.min() < 0 or T.max() >= n:
        raise UnreadableFile(
            f"{path}: {'no tets' if m == 0 else f'a tet has a corner that is not one of {n}'}"
        )
    return HexMap(V, T, table[:, CORNERS:].reshape(m, CORNERS, 3))


def _numbers(lines: list[str], rows: int, columns: int) -> Floats:
    words = " ".join(lines).split()
    if len(words) != rows * columns:
        raise ValueError(f"{rows} lines of {columns} numbers expected, {len(words)} numbers found")
    return np.array([float(Fraction(w)) if "/" in w else float(w) for w in words]).reshape(rows, columns)

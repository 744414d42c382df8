"""Points to ask the field at."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from neurframe_cli.errors import InvalidMesh, UnreadableFile
from neurframe_cli.mesh.arrays import Floats
from neurframe_cli.mesh.open_file import check_file


def read_points(path: Path) -> Floats:
    """Points (n,3) of a .npy file or of text with three numbers a line (blanks or commas, # for comments).

    Raises UnreadableFile or InvalidMesh.
    """
    check_file(path)
    try:
        if path.suffix.lower() == ".npy":
            points = np.load(path, allow_pickle=False)
        else:
            lines = path.read_text(encoding="utf-8").replace(",", " ").splitlines()
            points = np.loadtxt(lines, ndmin=2) if any(map(_has_numbers, lines)) else np.empty((0, 3))
        points = np.asarray(points, np.float64)
    except (OSError, ValueError, EOFError, MemoryError) as error:
        raise UnreadableFile(
            f"{path}: no table of numbers: {error}", hint="three numbers a line, or .npy"
        ) from error
    if points.ndim != 2 or points.shape[1] != 3 or len(points) == 0:
        raise InvalidMesh(f"{path}: the shape is {points.shape}, (n, 3) is needed, and at least one point")
    if not np.isfinite(points).all():
        raise InvalidMesh(
            f"{path}: point {int(np.flatnonzero(~np.isfinite(points).all(axis=1))[0])} is not finite"
        )
    return points


def _has_numbers(line: str) -> bool:
    return bool(line.partition("#")[0].strip())

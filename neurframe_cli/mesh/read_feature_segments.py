"""A user's list of feature edges, as segments in the coordinates of the input."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np

from neurframe_cli.errors import InvalidMesh, UnreadableFile, UnsupportedFormat
from neurframe_cli.mesh.arrays import Features, Floats, Surface, TetMesh
from neurframe_cli.mesh.check_tets import check_indices
from neurframe_cli.mesh.features import read_features
from neurframe_cli.mesh.file_format import CELL_FORMATS, file_format
from neurframe_cli.mesh.open_file import read_bytes
from neurframe_cli.mesh.read_tets import CELL_READERS


def read_feature_segments(path: Path, model: Surface | tuple[TetMesh, Features]) -> Floats:
    """End points (k,2,3) of the feature edges in `path`.

    features.json names vertices of `model` by number, a .sharp file (QuadWild) sides of its triangles; the lines of
    an OBJ file and the line cells of MEDIT, VTK, VTU and MSH files have positions of their own.  Raises
    UnreadableFile, UnsupportedFormat, InvalidMesh.
    """
    extension = path.suffix.lower()
    if extension == ".json":
        V = model.V if isinstance(model, Surface) else model[0].V
        return _ends(path, V, read_features(path).edges)
    if extension == ".sharp":
        return _from_sharp(path, model)
    name = file_format(path)
    if name == "obj":
        return _from_obj(path)
    if name not in CELL_FORMATS:
        raise UnsupportedFormat(f"{path}: {name} files have no lines", hint="give features.json, OBJ or VTK")
    cells = CELL_READERS[name](path)
    return _ends(path, cells.V, cells.edges)


def _ends(path: Path, V: Floats, edges: np.ndarray) -> Floats:
    """(k,2,3) positions of checked edges."""
    if len(edges) == 0:
        raise UnreadableFile(
            f"{path}: no feature edges in it", hint="give features.json, or a VTK or OBJ file with lines"
        )
    check_indices(V, edges, path, "edge")
    return np.asarray(V[edges], np.float64)


def _from_sharp(path: Path, model: Surface | tuple[TetMesh, Features]) -> Floats:
    """A count, then `kind,triangle,side` per line, side i between corners i and i+1; kind tells convex from concave."""
    if not isinstance(model, Surface):
        raise InvalidMesh(f"{path}: names sides of triangles, the model is a tet mesh")
    words = read_bytes(path).replace(b",", b" ").split()
    try:
        numbers = np.array([int(word) for word in words], np.int64)
    except (ValueError, OverflowError) as error:
        raise UnreadableFile(f"{path}: {error}") from error
    if len(numbers) == 0 or len(numbers) != 1 + 3 * numbers[0]:
        raise UnreadableFile(
            f"{path}: holds {len(numbers)} numbers, a count and three for each edge are expected"
        )
    _, triangle, side = numbers[1:].reshape(-1, 3).T
    if ((triangle < 0) | (triangle >= len(model.F)) | (side < 0) | (side > 2)).any():
        raise InvalidMesh(f"{path}: names a side that the {len(model.F)} triangles of the model do not have")
    return _ends(
        path, model.V, np.stack([model.F[triangle, side], model.F[triangle, (side + 1) % 3]], axis=1)
    )


def _from_obj(path: Path) -> Floats:
    """`v` and `l` of an OBJ file; a line of more than two vertices is a polyline, negative numbers count back."""
    V: list[list[float]] = []
    edges: list[tuple[int, int]] = []
    for line in read_bytes(path).decode("utf-8", "replace").splitlines():
        keyword, *words = line.split() or [""]
        try:
            if keyword == "v":
                V.append([float(word) for word in words[:3]])
            elif keyword == "l":
                named = [int(word.split("/")[0]) for word in words]
                vertices = [n - 1 if n > 0 else len(V) + n for n in named]
                edges += pairwise(vertices)
        except ValueError as error:
            raise UnreadableFile(f"{path}: line {line[:40]!r}: {error}") from error
    if any(len(position) != 3 for position in V):
        raise UnreadableFile(f"{path}: a vertex has fewer than three coordinates")
    return _ends(path, np.array(V).reshape(-1, 3), np.array(edges, np.int64).reshape(-1, 2))

"""A user's list of feature edges, as segments in the coordinates of the input."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from neurframe_cli.errors import InvalidMesh, UnreadableFile
from neurframe_cli.mesh.arrays import Features, Floats, Surface, TetMesh
from neurframe_cli.mesh.features import read_features
from neurframe_cli.mesh.open_file import check_file, foreign_reader


def read_feature_segments(path: Path, model: Surface | tuple[TetMesh, Features]) -> Floats:
    """End points (k,2,3) of the feature edges in `path`.

    features.json names vertices of `model` by number, any other mesh file (OBJ, VTK, VTU, ...) has line cells with
    positions of its own.  Raises UnreadableFile or InvalidMesh.
    """
    if path.suffix.lower() == ".json":
        V = model.V if isinstance(model, Surface) else model[0].V
        edges = read_features(path).edges
        if len(edges) and edges.max() >= len(V):
            raise InvalidMesh(f"{path}: vertex {edges.max()} is named, the model has {len(V)}")
        return V[edges]
    return _from_lines(path)


def _from_lines(path: Path) -> Floats:
    import meshio

    check_file(path)
    with foreign_reader(path, "meshio"):
        mesh = meshio.read(path)
        lines = np.asarray(mesh.cells_dict.get("line", np.zeros((0, 2))), np.int64)
        V = np.asarray(mesh.points, np.float64)
    if len(lines) == 0:
        raise UnreadableFile(
            f"{path}: no line cells in it", hint="give features.json, or a VTK or OBJ file with lines"
        )
    if not np.isfinite(V[lines]).all():
        raise InvalidMesh(f"{path}: a line ends at a position that is not finite")
    return V[lines]

"""A mesh from the arrays of another program."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from neurframe_cli.errors import InvalidMesh
from neurframe_cli.mesh.arrays import Surface, TetMesh
from neurframe_cli.mesh.check_tets import check_indices


def mesh_from_arrays(V: ArrayLike, F: ArrayLike) -> Surface | TetMesh:
    """Triangles F (m,3) or tets F (m,4) over V (n,3); raises InvalidMesh where the arrays are neither."""
    try:
        positions, cells = np.ascontiguousarray(V, np.float64), np.asarray(F)
    except (TypeError, ValueError) as error:
        raise InvalidMesh(f"V is no array of numbers: {error}") from error
    if positions.ndim != 2 or positions.shape[1] != 3:
        raise InvalidMesh(f"V has the shape {positions.shape}, expected (n, 3)")
    if cells.ndim != 2 or cells.shape[1] not in (3, 4) or not np.issubdtype(cells.dtype, np.integer):
        raise InvalidMesh(
            f"F is {cells.dtype} of the shape {cells.shape}, expected integers (m, 3) or (m, 4)"
        )
    corners = np.ascontiguousarray(cells, np.int64)
    check_indices(positions, corners, "the mesh", "cell")
    return Surface(positions, corners) if corners.shape[1] == 3 else TetMesh(positions, corners)

"""How well shaped tets are."""

from __future__ import annotations

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints
from neurframe_cli.mesh.check_tets import tet_volumes

TET_EDGES = np.array([[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]], np.int64)


def mean_ratio(V: Floats, T: Ints) -> Floats:
    """(m,) 12 (3 vol)^(2/3) / (sum of squared edge lengths): 1 for a regular tet, 0 flat, negative inverted.

    Liu and Joe, "Relationship between tetrahedron shape measures", BIT 34 (1994).
    """
    edges = V[T[:, TET_EDGES[:, 0]]] - V[T[:, TET_EDGES[:, 1]]]
    volumes = tet_volumes(V, T)
    size = np.einsum("ijk,ijk->i", edges, edges)
    return np.asarray(np.sign(volumes) * 12.0 * np.cbrt(3.0 * np.abs(volumes)) ** 2 / size)

"""What a volume file may hold, before anyone asks whether it is a tet mesh or a surface."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints


def no_cells(width: int) -> Ints:
    """An empty (0, width) array of cells."""
    return np.zeros((0, width), np.int64)


@dataclass(frozen=True)
class Cells:
    """Points and cells of a file with 0-based indices that are not checked yet.

    V (n,3); edges (k,2): those that the file lists as curves; triangles (f,3) with triangle_refs (f,), the number of
    the face of the model that each belongs to, -1 where the file does not say; tets (m,4); corners (c,);
    other: names of cell kinds that no reader here understands.
    """

    V: Floats
    edges: Ints = field(default_factory=lambda: no_cells(2))
    triangles: Ints = field(default_factory=lambda: no_cells(3))
    triangle_refs: Ints = field(default_factory=lambda: np.zeros(0, np.int64))
    tets: Ints = field(default_factory=lambda: no_cells(4))
    corners: Ints = field(default_factory=lambda: np.zeros(0, np.int64))
    other: tuple[str, ...] = ()

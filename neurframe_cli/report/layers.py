"""What the 3D view shows: layers of polygons, lines or points, in a frame of their own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from neurframe_cli.mesh.arrays import Floats, Ints

Colors = NDArray[np.uint8]

# what a page can hold: about 10 MB, and a few seconds to open
MOST_CELLS = 250_000  # of one layer
MOST_CELLS_TOGETHER = 400_000
_GRID = 2.0**17  # coordinates of the view are multiples of 1 / 131072 of the diagonal: they compress to half


@dataclass(frozen=True, eq=False)
class Layer:
    """One thing that can be switched on and off in the 3D view.

    V (n,3); cells (m,k) of vertices: points for k = 1, segments for 2, polygons above; colors (m,3) a cell, else
    `color` for all; edges: whether the sides of the polygons are drawn; lit: shaded, or flat in its colour.
    """

    title: str
    V: Floats
    cells: Ints
    color: str = "#dfe5ec"
    colors: Colors | None = None
    opacity: float = 1.0
    edges: bool = False
    shown: bool = True
    lit: bool = True


@dataclass(frozen=True)
class ViewFrame:
    """The coordinates of the view: (x - center) / diagonal, so that single precision does for every model."""

    center: Floats
    diagonal: float

    @classmethod
    def around(cls, points: Floats) -> ViewFrame:
        """The frame in which the bounding box of points (n,3) is centred and has a diagonal of 1."""
        low, high = points.min(axis=0), points.max(axis=0)
        return cls((low + high) / 2, float(np.linalg.norm(high - low)) or 1.0)

    def apply(self, points: Floats) -> NDArray[np.float32]:
        """Points (n,3) in this frame, rounded."""
        return (np.round((points - self.center) / self.diagonal * _GRID) / _GRID).astype(np.float32)


def rgb(color: str) -> list[float]:
    """'#rrggbb' as three numbers in [0, 1]."""
    return [int(color[i : i + 2], 16) / 255 for i in (1, 3, 5)]

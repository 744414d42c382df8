"""How large the elements shall be."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from neurframe_cli.errors import UsageError
from neurframe_cli.mesh.arrays import Surface
from neurframe_cli.mesh.measure import box_diagonal, enclosed_volume, surface_area

DEFAULT_SCALES = {"quad": 100.0, "hex": 30.0}  # paper, sections 5.1.1 and 5.1.2


@dataclass(frozen=True)
class ElementSize:
    """One of: scale S (bounding-box diagonal / edge length), edge_length in input units, count of elements."""

    scale: float | None = None
    edge_length: float | None = None
    count: int | None = None

    def length(self, surface: Surface) -> float:
        """The target edge length; of a count, that of so many squares with the area of the surface."""
        if self.count is not None:
            return float(np.sqrt(surface_area(surface.V, surface.F) / self.count))
        if self.edge_length is not None:
            return self.edge_length
        assert self.scale is not None, "element_size() sets one of the three"
        return box_diagonal(surface.V) / self.scale

    def layered_edge(self, surface: Surface) -> float:
        """The edge length h of cubes in the solid with one layer of them on its surface; of a count n, the root of
        volume / h^3 + area / h^2 = n."""
        if self.count is None:
            return self.length(surface)
        volume = abs(enclosed_volume(surface.V, surface.F))
        area = surface_area(surface.V, surface.F)
        return float(np.roots([self.count, 0.0, -area, -volume]).real.max())

    def arguments(self, surface: Surface, count_option: str) -> list[str]:
        """The size as the programs take it: an edge length, or a count behind `count_option`."""
        if self.count is not None:
            return [count_option, str(self.count)]
        return ["--edge-length", repr(self.length(surface))]


def element_size(
    scale: float | None, edge_length: float | None, count: int | None, default_scale: float
) -> ElementSize:
    """The size that was asked for, else the default scale; raises UsageError where more than one was given."""
    given = [value for value in (scale, edge_length, count) if value is not None]
    if len(given) > 1:
        raise UsageError("give only one of --scale, the edge length and the number of elements")
    return ElementSize(scale, edge_length, count) if given else ElementSize(scale=default_scale)

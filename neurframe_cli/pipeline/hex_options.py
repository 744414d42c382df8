"""What `neurframe hex` can be told beside the size."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class HexOptions:
    """padding: a layer of hexes along the whole boundary, None for one where the hexes are poor without it;
    splitting: finer hexes of the same map where the mesh is not near the surface otherwise; grid: where no map gives
    hexes that pass, those of a regular grid, None for that unless `fill`; fill: where the mesh is not valid, a second
    one in which pyramids and tets take the place of the hexes that are missing or bad."""

    padding: bool | None = None
    splitting: bool = True
    grid: bool | None = None
    fill: bool = False

    @property
    def grid_allowed(self) -> bool:
        """Whether hexes of a grid may take the place of those of a map."""
        return not self.fill if self.grid is None else self.grid

"""What `neurframe hex` can be told beside the size."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class HexOptions:
    """padding: a layer of hexes along the whole boundary, None for one where the hexes are poor without it; fill:
    where the mesh is not valid, a second one in which pyramids and tets take the place of the hexes that are missing
    or bad."""

    padding: bool | None = None
    fill: bool = False

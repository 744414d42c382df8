"""What `neurframe hex` can be told beside the size."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class HexOptions:
    """padding: a layer of hexes along the whole boundary, None for one where the hexes are poor without it;
    splitting: finer hexes of the same map where the mesh is not near the surface otherwise; fill: where the mesh is not
    valid, a second one in which pyramids and tets take the place of the hexes that are missing or bad."""

    padding: bool | None = None
    splitting: bool = True
    fill: bool = False

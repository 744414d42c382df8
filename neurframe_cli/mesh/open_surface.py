"""Surfaces with holes: which still have an inside?"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from neurframe_cli.errors import InvalidMesh
from neurframe_cli.mesh.arrays import Surface
from neurframe_cli.mesh.surface_edges import surface_edges

# Doubtful volume over inner volume: 0.003 for a teapot with a gap under its lid, 0.01 and less for solids that miss
# a few triangles, 0.2 for a box without its lid, 23 for a sheet.
LARGEST_DOUBT = 0.1
GRID = 32  # points along the longest side of the bounding box


def doubtful_share(surface: Surface) -> float:
    """Volume whose winding number lies between 1/4 and 3/4, over the volume where it is above 1/2; inf for no inside.

    fTetWild keeps what is above 1/2 (Jacobson, Kavan, Sorkine-Hornung, "Robust inside-outside segmentation using
    generalized winding numbers", SIGGRAPH 2013): where the number is near that, a hole decides.
    """
    import igl

    low, size = surface.V.min(axis=0), np.ptp(surface.V, axis=0)
    step = float(size.max()) / GRID
    axes = [low[i] + step * (np.arange(max(int(size[i] / step), 1)) + 0.5) for i in range(3)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    winding = np.asarray(igl.fast_winding_number(surface.V, surface.F, points))
    inside, doubtful = (winding > 0.5).sum(), ((winding > 0.25) & (winding < 0.75)).sum()
    return float(doubtful / inside) if inside else float("inf")


def refuse_large_holes(surface: Surface, name: str | Path = "surface") -> list[str]:
    """Raises InvalidMesh for a surface that is too open to have an inside; a warning for one that is a bit open."""
    open_edges = int((surface_edges(surface.V, surface.F).face_count == 1).sum())
    if open_edges == 0:
        return []
    doubt = doubtful_share(surface)
    if doubt > LARGEST_DOUBT:
        share = f"{doubt:.0%} of its inside is" if np.isfinite(doubt) else "all of it is"
        raise InvalidMesh(
            f"{name}: the surface is open: {share} as much outside, at most {LARGEST_DOUBT:.0%} can be filled",
            hint="close the holes, or give the sheet a thickness",
        )
    return [f"the surface is open at {open_edges} edges; the holes were closed"]

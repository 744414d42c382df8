"""Which cells of a grid to fill a solid with, so that they have the topology of its surface."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from neurframe_cli.mesh.arrays import Bools, Floats, Ints, Surface
from neurframe_cli.mesh.grid_cells import (
    CellFit,
    Grid,
    completed_cells,
    filled_cells,
    hexes_of,
    with_passed_by,
)
from neurframe_cli.mesh.pinches import has_topology_of, separate_pinches
from neurframe_cli.mesh.quality.polygons import topology

# how deep the centre of a cell lies at least, in its edges; the first that gives the topology of the surface is taken
DEPTHS = (0.0, -0.1, 0.1, -0.2, 0.2, -0.3, 0.3, -0.4, -0.5, -0.6)
BALL = (1, 2)  # components, Euler characteristic
# a choice is none any more with so many times as many cells at places passed by as the best one has, and so many more
FAR_MORE, FEW = 2, 5

Hexes = tuple[Floats, Ints]  # V (n,3), H (h,8)


def cell_choices(grid: Grid, depth: Floats, surface: Surface) -> list[Hexes]:
    """Hexes of cells, whose centres are at that `depth` (a,b,c), with the topology of the surface, the simplest choice
    first; none where no choice has it.

    Cells of one depth have no dents, be it with all cells at places that they pass by or with those of them that leave
    the topology.  Where parts are thin, cells that grow one by one leave less of the surface aside.
    """
    fit = CellFit(grid, depth, surface)
    starts = list(_starts(depth, surface))
    found = [hexes for hexes in (*_of_one_depth(fit, starts, surface), _grown(fit, starts, surface)) if hexes]
    aside = [int(fit.passed_by(*hexes).sum()) for hexes in found]
    most = FAR_MORE * min(aside, default=0) + FEW
    near = [hexes for hexes, count in zip(found, aside, strict=True) if count <= most]
    return [hexes for i, hexes in enumerate(near) if not any(_same(hexes, other) for other in near[:i])]


def _same(one: Hexes, other: Hexes) -> bool:
    return np.array_equal(one[0], other[0]) and np.array_equal(one[1], other[1])


def _starts(depth: Floats, surface: Surface) -> Iterator[Bools]:
    """Cells (a,b,c) that may have the topology of the surface: all that are so deep; for a ball, a single one."""
    for least in DEPTHS:
        if (depth > least).any():
            yield depth > least
    if topology(surface.F) == BALL:
        deepest = np.zeros(depth.shape, bool)
        deepest.flat[depth.argmax()] = True
        yield deepest


def _of_one_depth(fit: CellFit, starts: list[Bools], surface: Surface) -> list[Hexes | None]:
    """The first of the `starts` that has the topology of the surface, or has it without its pinches: with all cells at
    places passed by if that leaves the topology, and with those of them that do."""
    for start in starts:
        found = _whole(fit, start, surface)
        if found is not None:
            at_once = _whole(fit, with_passed_by(fit, start), surface) or found
            exact = has_topology_of(hexes_of(fit.grid, np.argwhere(start))[1], surface)
            return [at_once, _whole(fit, completed_cells(fit, start), surface) if exact else None]
    return []


def _whole(fit: CellFit, inside: Bools, surface: Surface) -> Hexes | None:
    """The cells as hexes, taken apart where only that gives them the surface's topology; None where it does not."""
    V, H = hexes_of(fit.grid, np.argwhere(inside))
    if not has_topology_of(H, surface):
        V, H = separate_pinches(V, H)
    return (V, H) if has_topology_of(H, surface) else None


def _grown(fit: CellFit, starts: list[Bools], surface: Surface) -> Hexes | None:
    """Cells that grow from the first of the `starts` with the topology of the surface."""
    for start in starts:
        if has_topology_of(hexes_of(fit.grid, np.argwhere(start))[1], surface):
            return hexes_of(fit.grid, np.argwhere(completed_cells(fit, filled_cells(fit, start))))
    return None

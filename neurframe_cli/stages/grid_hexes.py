"""Hexes without a map: cells of a regular grid, and one layer between them and the surface.

The last resort where no integer-grid map gives hexes that pass (Schneiders 1996, A grid-based algorithm for the
generation of hexahedral element meshes).  Inside, the mesh is the grid; its irregular edges are along the boundary,
wherever the staircase of the cells turns.  The layer's outer vertices are brought to the surface, its features and
corners like those of any other hexes; since it begins with no hex inverted, the barrier holds all the way.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from neurframe_cli.errors import NotValid
from neurframe_cli.mesh.arrays import Features, Floats, Ints, Progress, Surface, part, silent
from neurframe_cli.mesh.followed_features import followed_features
from neurframe_cli.mesh.grid_cells import Grid, area_axes, centre_depths, grid_over, hexes_of, with_passed_by
from neurframe_cli.mesh.optimize.improve import ImproveOptions
from neurframe_cli.mesh.optimize.smooth import SmoothedMesh, SmoothOptions
from neurframe_cli.mesh.optimize.soft_constraints import BAD
from neurframe_cli.mesh.pinches import has_topology_of, separate_pinches
from neurframe_cli.mesh.quality.check import CheckOptions, check_hexes
from neurframe_cli.stages.finish_hexes import POOR
from neurframe_cli.stages.pad_hexes import wrap_hexes
from neurframe_cli.stages.smooth_hexes import HEX_OPTIONS, smooth_hexes

FINER = (1.0, 1.5, 2.0, 3.0)  # times as many cells along each edge as asked for
MOST_HEXES = 60_000  # of a finer grid than was asked for
# how deep the centre of a cell lies at least, in its edges; the first that gives the topology of the surface is taken
DEPTHS = (0.0, -0.1, 0.1, -0.2, 0.2, -0.3, 0.3, -0.4, -0.5, -0.6)
LEAST_GAIN = 3e-5  # of a corner in a round; few hexes are poor, and the mean gains little with them
HOPELESS = 1.5  # limits of the distance; where a finer grid is expected to be farther away it is left out
MARGIN = 0.9  # of the limit that a mesh has to keep: a staircase bends many quads, which samples do not see as they are


@dataclass(frozen=True)
class GridOptions:
    """smoothing: its limits; check: what the hexes have to pass."""

    smoothing: SmoothOptions = field(
        default_factory=lambda: replace(
            HEX_OPTIONS,
            improve=ImproveOptions(gain=LEAST_GAIN),
            hausdorff_limit=MARGIN * HEX_OPTIONS.hausdorff_limit,
            soft_first=True,
            release=POOR,
        )
    )
    check: CheckOptions = field(default_factory=CheckOptions)


@dataclass(frozen=True)
class GridHexes:
    """V (n,3), cells (h,8); finer: times as many cells along each edge as asked for; report: what smoothing did, and
    every grid tried."""

    V: Floats
    cells: Ints
    finer: float
    report: dict[str, Any]


def grid_hexes(
    surface: Surface,
    features: Features,
    edge_length: float,
    options: GridOptions,
    progress: Progress = silent,
) -> GridHexes:
    """The hexes of the coarsest grid with cells of `edge_length` or less whose hexes pass the check; those with a hex
    that is all but inverted only where there are no better ones.

    Raises NotValid, which says what was the matter with each, where none does.
    """
    axes = area_axes(surface)
    tried: list[dict[str, Any]] = []
    valid: GridHexes | None = None
    for number, finer in enumerate(FINER):
        if tried and _too_coarse(tried[-1], finer, options.check.hausdorff_limit):
            continue
        steps = part(progress, number / len(FINER), (number + 1) / len(FINER))
        grid = grid_over(surface, axes, edge_length / finer)
        steps(0.0, f"grid of {' x '.join(map(str, grid.counts))} cells")
        start = _layered(grid, surface)
        if start is None:
            tried.append({"finer": finer, "topology": False})
            continue
        V, H = start
        if finer > 1.0 and len(H) > MOST_HEXES:
            break
        followed = followed_features(surface, features, edge_length / finer)
        smoothed = smooth_hexes(
            V, H, surface, followed, options.smoothing, part(steps, 0.1, 0.9), voids=False
        )
        tried.append(_told(finer, H, smoothed))
        if check_hexes(smoothed.V, H, surface, features, options.check).valid:
            valid = GridHexes(smoothed.V, H, finer, {"smoothing": tried[-1]["smoothing"], "grid": tried})
            if smoothed.report.after.min_scaled_jacobian > BAD:
                break
    if valid is None:
        raise NotValid(f"no grid of cells gives hexes that pass: {'; '.join(map(_in_words, tried))}")
    return valid


def _too_coarse(last: dict[str, Any], finer: float, limit: float) -> bool:
    """Whether a grid so much finer will be too far away as well: the distance shrinks like the edges at least."""
    if not last["topology"] or finer == FINER[-1]:
        return False
    expected: float = last["smoothing"]["after"]["hausdorff"] * last["finer"] / finer
    return expected > HOPELESS * limit


def _told(finer: float, H: Ints, smoothed: SmoothedMesh) -> dict[str, Any]:
    return {"finer": finer, "topology": True, "cells": len(H), "smoothing": asdict(smoothed.report)}


def _in_words(attempt: dict[str, Any]) -> str:
    """What was wrong with one grid."""
    if not attempt["topology"]:
        return f"x {attempt['finer']:g}: cells with another topology than the surface"
    after = attempt["smoothing"]["after"]
    return (
        f"x {attempt['finer']:g}: {attempt['cells']} hexes, worst scaled Jacobian "
        f"{after['min_scaled_jacobian']:.3f}, {100 * after['hausdorff']:.2f} % off"
    )


def _layered(grid: Grid, surface: Surface) -> tuple[Floats, Ints] | None:
    """V (n,3) and H (h,8): cells of the grid that have the topology of the surface, and a layer round them; None where
    no choice of cells has it."""
    depth = centre_depths(grid, surface)
    for least in DEPTHS:
        cells = np.argwhere(depth > least)
        found = _whole(grid, cells, surface)
        if found is not None:
            complete = _whole(grid, with_passed_by(grid, cells, surface), surface)
            return wrap_hexes(*(complete or found))
    return None


def _whole(grid: Grid, cells: Ints, surface: Surface) -> tuple[Floats, Ints] | None:
    """V (n,3) and H (k,8) of the cells (k,3), taken apart where only that gives them the topology of the surface; None
    where it does not."""
    if len(cells) == 0:
        return None
    V, H = hexes_of(grid, cells)
    if not has_topology_of(H, surface):
        V, H = separate_pinches(V, H)
    return (V, H) if has_topology_of(H, surface) else None

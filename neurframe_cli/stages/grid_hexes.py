"""Hexes without a map: cells of a regular grid, and one layer between them and the surface.

The last resort where no integer-grid map gives hexes that pass (Schneiders 1996, A grid-based algorithm for the
generation of hexahedral element meshes).  Inside, the mesh is the grid; its irregular edges are along the boundary,
wherever the staircase of the cells turns.  The layer's outer vertices are brought to the surface, its features and
corners like those of any other hexes; at re-entrant edges of the staircase it begins with flat or inverted hexes, which
are relaxed first, so that the barrier holds all the way.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from neurframe_cli.errors import NotValid
from neurframe_cli.mesh.arrays import Features, Floats, Ints, Progress, Surface, part, silent
from neurframe_cli.mesh.followed_features import followed_features
from neurframe_cli.mesh.grid_cells import Grid, area_axes, centre_depths, grid_over, hexes_of, with_passed_by
from neurframe_cli.mesh.optimize.smooth import SmoothedMesh, SmoothOptions
from neurframe_cli.mesh.optimize.soft_constraints import BAD
from neurframe_cli.mesh.pinches import has_topology_of, separate_pinches
from neurframe_cli.mesh.quality.check import CheckOptions, check_hexes
from neurframe_cli.stages.finish_hexes import POOR
from neurframe_cli.stages.pad_hexes import pillow_hexes
from neurframe_cli.stages.smooth_hexes import HEX_OPTIONS, smooth_hexes

FINER = (1.0, 1.5, 2.0, 3.0, 4.0)  # times as many cells along each edge as asked for
MOST_HEXES = 100_000  # of a finer grid than was asked for
MOST_CELLS = 20_000_000  # of a grid, inside and outside
# how deep the centre of a cell lies at least, in its edges; the first that gives the topology of the surface is taken
DEPTHS = (0.0, -0.1, 0.1, -0.2, 0.2, -0.3, 0.3, -0.4, -0.5, -0.6)
LEAST_GAIN = 3e-5  # of a corner in a round; few hexes are poor, and the mean gains little with them
HOPELESS = 1.2  # limits of the distance; where a finer grid is expected to be farther away it is left out
MARGIN = 0.9  # of the limit that a mesh has to keep: a staircase bends many quads, which samples do not see as they are


@dataclass(frozen=True)
class GridOptions:
    """smoothing: its limits; check: what the hexes have to pass."""

    smoothing: SmoothOptions = field(
        default_factory=lambda: replace(
            HEX_OPTIONS,
            improve=replace(HEX_OPTIONS.improve, gain=LEAST_GAIN),
            hausdorff_limit=MARGIN * HEX_OPTIONS.hausdorff_limit,
            soft_first=True,
            release=POOR,
        )
    )
    check: CheckOptions = field(default_factory=CheckOptions)


@dataclass(frozen=True)
class GridHexes:
    """V (n,3), cells (h,8); worst: their least scaled Jacobian; finer: times as many cells along each edge as asked
    for; report: what smoothing did, and every grid tried."""

    V: Floats
    cells: Ints
    worst: float
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
    found: GridHexes | None = None
    for number, finer in enumerate(FINER):
        if tried and _too_coarse(tried[-1], finer, options.check.hausdorff_limit):
            continue
        steps = part(progress, number / len(FINER), (number + 1) / len(FINER))
        grid = grid_over(surface, axes, edge_length / finer)
        try:
            smoothed, H = _on_surface(grid, surface, features, options.smoothing, finer > 1.0, steps)
        except NotValid as error:
            tried.append({"finer": finer, "refused": str(error)})
            continue
        verdict = check_hexes(smoothed.V, H, surface, features, options.check)
        refused = None if verdict.valid else ", ".join(verdict.problems)
        tried.append(
            {"finer": finer, "refused": refused, "cells": len(H), "smoothing": asdict(smoothed.report)}
        )
        worst = smoothed.report.after.min_scaled_jacobian
        if verdict.valid and (found is None or worst > found.worst):
            report = {"smoothing": tried[-1]["smoothing"], "grid": tried}
            found = GridHexes(smoothed.V, H, worst, finer, report)
        if found is not None and found.worst > BAD:
            break
    if found is None:
        told = "; ".join(f"x {attempt['finer']:g}: {attempt['refused']}" for attempt in tried)
        raise NotValid(f"no grid of cells gives hexes that pass: {told}")
    return found


def _too_coarse(last: dict[str, Any], finer: float, limit: float) -> bool:
    """Whether a grid so much finer will be too far away as well: the distance shrinks at best like the square of the
    edges, as that of chords does.  The last two are tried all the same."""
    if "smoothing" not in last or finer in FINER[-2:]:
        return False
    expected: float = last["smoothing"]["after"]["hausdorff"] * (last["finer"] / finer) ** 2
    return expected > HOPELESS * limit


def _on_surface(
    grid: Grid,
    surface: Surface,
    features: Features,
    smoothing: SmoothOptions,
    bounded: bool,
    progress: Progress,
) -> tuple[SmoothedMesh, Ints]:
    """The cells of the grid in the solid, with a layer round them that lies on the surface.

    Raises NotValid where there are none with the topology of the surface, or more than can be smoothed in minutes if
    `bounded`.
    """
    progress(0.0, f"grid of {' x '.join(map(str, grid.counts))} cells")
    if math.prod(grid.counts.tolist()) > MOST_CELLS:
        raise NotValid(f"a grid of more than {MOST_CELLS:,} cells")
    depth = centre_depths(grid, surface)
    if bounded and np.count_nonzero(depth > 0.0) > MOST_HEXES:
        raise NotValid(f"more than {MOST_HEXES:,} hexes")
    V, H = _layered(grid, depth, surface)
    if bounded and len(H) > MOST_HEXES:
        raise NotValid(f"more than {MOST_HEXES:,} hexes")
    followed = followed_features(surface, features, float(grid.step.mean()))
    return smooth_hexes(V, H, surface, followed, smoothing, part(progress, 0.1, 0.9), voids=False), H


def _layered(grid: Grid, depth: Floats, surface: Surface) -> tuple[Floats, Ints]:
    """V (n,3) and H (h,8): cells of the grid, whose centres are at that `depth` (a,b,c), that have the topology of the
    surface, and a layer round them.  Raises NotValid where no choice of cells has it."""
    for least in DEPTHS:
        cells = np.argwhere(depth > least)
        found = _whole(grid, cells, surface)
        if found is not None:
            complete = _whole(grid, with_passed_by(grid, cells, surface), surface)
            return pillow_hexes(*(complete or found))
    raise NotValid("cells with another topology than the surface")


def _whole(grid: Grid, cells: Ints, surface: Surface) -> tuple[Floats, Ints] | None:
    """V (n,3) and H (k,8) of the cells (k,3), taken apart where only that gives them the topology of the surface; None
    where it does not."""
    if len(cells) == 0:
        return None
    V, H = hexes_of(grid, cells)
    if not has_topology_of(H, surface):
        V, H = separate_pinches(V, H)
    return (V, H) if has_topology_of(H, surface) else None

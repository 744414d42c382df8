"""Hexes without a map: cells of a regular grid, and one layer between them and the surface.

The last resort where no integer-grid map gives hexes that pass (Schneiders 1996, A grid-based algorithm for the
generation of hexahedral element meshes).  Inside, the mesh is the grid; its irregular edges are along the boundary,
wherever the staircase of the cells turns.  The layer's outer vertices are brought to the surface, its features and
corners like those of any other hexes; at re-entrant edges of the staircase it begins with flat or inverted hexes, which
are relaxed first, so that the barrier holds all the way.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from neurframe_cli.errors import NotValid
from neurframe_cli.mesh.arrays import Bools, Features, Floats, Ints, Progress, Surface, part, silent
from neurframe_cli.mesh.followed_features import followed_features
from neurframe_cli.mesh.grid_cells import (
    CellFit,
    Grid,
    area_axes,
    centre_depths,
    completed_cells,
    filled_cells,
    grid_over,
    hexes_of,
    split_at,
)
from neurframe_cli.mesh.hex_shell import hex_shell
from neurframe_cli.mesh.measure import box_diagonal
from neurframe_cli.mesh.optimize.distance_probe import BothDiagonals
from neurframe_cli.mesh.optimize.smooth import SmoothedMesh, SmoothOptions
from neurframe_cli.mesh.optimize.soft_constraints import BAD
from neurframe_cli.mesh.pinches import has_topology_of, separate_pinches
from neurframe_cli.mesh.quality.check import CheckOptions, check_hexes
from neurframe_cli.mesh.quality.polygons import topology
from neurframe_cli.stages.pad_hexes import pillow_hexes
from neurframe_cli.stages.smooth_hexes import HEX_OPTIONS, smooth_hexes

FINER = (1.0, 1.5, 2.0, 3.0, 4.0)  # times as many cells along each edge as asked for
MOST_HEXES = 100_000  # of a finer grid than was asked for
MOST_CELLS = 20_000_000  # of a grid, inside and outside
# how deep the centre of a cell lies at least, in its edges; the first that gives the topology of the surface is taken
DEPTHS = (0.0, -0.1, 0.1, -0.2, 0.2, -0.3, 0.3, -0.4, -0.5, -0.6)
# times as many places passed by; more are not worth the dents of cells that grow one by one
FEWER = 0.5
BALL = (1, 2)  # components, Euler characteristic
LEAST_GAIN = 3e-5  # of a corner in a round; few hexes are poor, and the mean gains little with them
SPLITS = 2  # of the cells in places where the hexes are too far from the surface
MOST_GROWTH = 2.5  # times as many cells for that; beyond, a finer grid is as good
HALVED = 4.0  # limits of the distance, which edges half as long bring down by so much at best
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
        )
    )
    check: CheckOptions = field(default_factory=CheckOptions)


@dataclass(frozen=True)
class GridHexes:
    """V (n,3), cells (h,8); worst: their least scaled Jacobian; finer: times as many cells along each edge as asked
    for; split: how often cells are halved where the hexes were too far from the surface; report: what smoothing did,
    and every grid tried."""

    V: Floats
    cells: Ints
    worst: float
    finer: float
    split: int
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
    trials = _Trials(surface, features, options)
    for number, finer in enumerate(FINER):
        steps = part(progress, number / len(FINER), (number + 1) / len(FINER))
        grid: Grid | None = grid_over(surface, features, axes, edge_length / finer)
        for split in range(SPLITS + 1):
            within = part(steps, split / (SPLITS + 1), (split + 1) / (SPLITS + 1))
            grid = trials.attempt(grid, finer, split, within) if grid is not None else None
        if trials.found is not None and trials.found.worst > BAD:
            break
    if trials.found is None:
        raise NotValid(f"no grid of cells gives hexes that pass: {trials.told()}")
    return trials.found


class _Trials:
    """One grid after the other: what came of each, and the best hexes so far."""

    def __init__(self, surface: Surface, features: Features, options: GridOptions) -> None:
        self.surface, self.features, self.options = surface, features, options
        self.tried: list[dict[str, Any]] = []
        self.found: GridHexes | None = None

    def attempt(self, grid: Grid, finer: float, split: int, progress: Progress) -> Grid | None:
        """Smooth and judge the hexes of a grid; where nothing but a few places are too far from the surface, the grid
        that is finer there."""
        surface, options = self.surface, self.options
        try:
            smoothed, H = _on_surface(
                grid, surface, self.features, options.smoothing, finer > 1.0 or split > 0, progress
            )
        except NotValid as error:
            self.tried.append({"finer": finer, "split": split, "refused": str(error)})
            return None
        verdict = check_hexes(smoothed.V, H, surface, self.features, options.check)
        refused = None if verdict.valid else ", ".join(verdict.problems)
        smoothing = asdict(smoothed.report)
        self.tried.append(
            {"finer": finer, "split": split, "refused": refused, "cells": len(H), "smoothing": smoothing}
        )
        worst = smoothed.report.after.min_scaled_jacobian
        if verdict.valid and (self.found is None or worst > self.found.worst):
            self.found = GridHexes(
                smoothed.V, H, worst, finer, split, {"smoothing": smoothing, "grid": self.tried}
            )
        if verdict.valid or smoothed.report.after.inverted:
            return None
        return self._finer_where_far(grid, smoothed, H)

    def _finer_where_far(self, grid: Grid, smoothed: SmoothedMesh, H: Ints) -> Grid | None:
        """The grid with more planes where the hexes are too far from the surface; None where that is everywhere, or
        nowhere, or so far that twice as many planes would not do."""
        limit = self.options.check.hausdorff_limit
        if smoothed.report.after.hausdorff > HALVED * limit:
            return None
        far = far_places(smoothed.V, hex_shell(H).quads, self.surface, self.options.smoothing)
        finer = split_at(grid, far)
        growth = math.prod(finer.counts.tolist()) / math.prod(grid.counts.tolist())
        return finer if 1.0 < growth <= MOST_GROWTH else None

    def told(self) -> str:
        """What was the matter with each."""
        places = (" and finer in places" if attempt["split"] else "" for attempt in self.tried)
        told = zip(self.tried, places, strict=True)
        return "; ".join(f"x {attempt['finer']:g}{where}: {attempt['refused']}" for attempt, where in told)


def far_places(V: Floats, quads: Ints, surface: Surface, options: SmoothOptions) -> Floats:
    """Places (k,3) of the surface that quads (f,4) over V (n,3) leave farther away than the limit, and the centres of
    quads that are that far from the surface."""
    probe = BothDiagonals(quads, surface, options.samples, np.random.default_rng(options.seed))
    distances = probe.measure(V)
    limit = options.hausdorff_limit * box_diagonal(surface.V[np.unique(surface.F)])
    back = distances.back.reshape(2, -1).max(axis=0)  # for one diagonal and the other
    return np.concatenate([probe.points[back > limit], V[quads[distances.there > limit]].mean(axis=1)])


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
    followed = followed_features(surface, features, grid.edge_length)
    return smooth_hexes(V, H, surface, followed, smoothing, part(progress, 0.1, 0.9), voids=False), H


def _layered(grid: Grid, depth: Floats, surface: Surface) -> tuple[Floats, Ints]:
    """V (n,3) and H (h,8): cells of the grid, whose centres are at that `depth` (a,b,c), that have the topology of the
    surface, and a layer round them.  Raises NotValid where no choice of cells has it.

    Cells of one depth have no dents.  Where they leave much of the surface aside, thin parts above all, those are taken
    that grow cell by cell.
    """
    fit = CellFit(grid, depth, surface)
    starts = list(_starts(depth, surface))
    choices = (_of_one_depth(fit, starts, surface), _grown(fit, starts, surface))
    found = [(int(fit.passed_by(*hexes).sum()), hexes) for hexes in choices if hexes is not None]
    if not found:
        raise NotValid("cells with another topology than the surface")
    simpler, grown = found[0], found[-1]
    return pillow_hexes(*(grown if grown[0] < FEWER * simpler[0] else simpler)[1])


def _of_one_depth(fit: CellFit, starts: list[Bools], surface: Surface) -> tuple[Floats, Ints] | None:
    """V and H of the first of the `starts` that has the topology of the surface, or has it without its pinches."""
    for start in starts:
        V, H = hexes_of(fit.grid, np.argwhere(start))
        if has_topology_of(H, surface):
            return hexes_of(fit.grid, np.argwhere(completed_cells(fit, start)))
        V, H = separate_pinches(V, H)
        if has_topology_of(H, surface):
            return V, H
    return None


def _grown(fit: CellFit, starts: list[Bools], surface: Surface) -> tuple[Floats, Ints] | None:
    """V and H of cells that grow from the first of the `starts` with the topology of the surface."""
    for start in starts:
        if has_topology_of(hexes_of(fit.grid, np.argwhere(start))[1], surface):
            inside = completed_cells(fit, filled_cells(fit, start))
            return hexes_of(fit.grid, np.argwhere(inside))
    return None


def _starts(depth: Floats, surface: Surface) -> Iterator[Bools]:
    """Choices of cells (a,b,c) that may have the topology of the surface: all that are so deep; for a ball, a cell."""
    for least in DEPTHS:
        if (depth > least).any():
            yield depth > least
    if topology(surface.F) == BALL:
        deepest = np.zeros(depth.shape, bool)
        deepest.flat[depth.argmax()] = True
        yield deepest

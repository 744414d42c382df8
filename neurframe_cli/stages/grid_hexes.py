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
from neurframe_cli.mesh.cell_choices import cell_choices
from neurframe_cli.mesh.followed_features import followed_features
from neurframe_cli.mesh.grid_cells import Grid, area_axes, centre_depths, grid_over, split_at
from neurframe_cli.mesh.hex_shell import hex_shell
from neurframe_cli.mesh.measure import box_diagonal
from neurframe_cli.mesh.optimize.distance_probe import BothDiagonals
from neurframe_cli.mesh.optimize.smooth import SmoothedMesh, SmoothOptions
from neurframe_cli.mesh.optimize.soft_constraints import BAD
from neurframe_cli.mesh.quality.check import CheckOptions, check_hexes
from neurframe_cli.stages.pad_hexes import pillow_hexes
from neurframe_cli.stages.smooth_hexes import HEX_OPTIONS, smooth_hexes

FINER = (1.0, 1.5, 2.0, 3.0, 4.0)  # times as many cells along each edge as asked for
MOST_HEXES = 100_000  # of a finer grid than was asked for
MOST_CELLS = 20_000_000  # of a grid, inside and outside
LEAST_GAIN = 3e-5  # of a corner in a round; few hexes are poor, and the mean gains little with them
SEVERAL_CHOICES = 2.0  # times finer; beyond, only the first choice of cells is tried
SPLITS = 2  # of the cells in places where the hexes are too far from the surface
MOST_GROWTH = 2.5  # times as many cells for that; beyond, a finer grid is as good
HALVED = 4.0  # limits of the distance, which edges half as long bring down by so much at best
# of the surface's volume; a thin plate may be within the limit of the distance and a quarter too thick
MOST_VOLUME_ERROR = 0.06
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
    """V (n,3), cells (h,8); worst: their least scaled Jacobian; volume_ratio: to that of the surface; finer: times as
    many cells along each edge as asked for; split: how often cells are halved where the hexes were too far from the
    surface; report: what smoothing did, and every grid tried."""

    V: Floats
    cells: Ints
    worst: float
    volume_ratio: float
    finer: float
    split: int
    report: dict[str, Any]

    @property
    def rank(self) -> tuple[bool, float]:
        """The larger, the better."""
        return abs(self.volume_ratio - 1.0) <= MOST_VOLUME_ERROR, self.worst

    @property
    def fine(self) -> bool:
        """Whether no finer grid is needed."""
        return self.rank > (True, BAD)


def grid_hexes(
    surface: Surface,
    features: Features,
    edge_length: float,
    options: GridOptions,
    progress: Progress = silent,
) -> GridHexes:
    """The hexes of the coarsest grid with cells of `edge_length` or less whose hexes pass the check; those with a hex
    that is all but inverted, or with another volume than the surface, only where there are no better ones.

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
        if trials.found is not None and trials.found.fine:
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
        """Smooth and judge the hexes of a grid, for each choice of its cells until one passes; where nothing but a few
        places are too far from the surface, the grid that is finer there."""
        try:
            choices = _choices(grid, self.surface, finer > 1.0 or split > 0)
        except NotValid as error:
            self.tried.append({"finer": finer, "split": split, "refused": str(error)})
            return None
        sound: list[tuple[SmoothedMesh, Ints]] = []
        if split or finer > SEVERAL_CHOICES:
            choices = choices[:1]
        for number, hexes in enumerate(choices):
            steps = part(progress, number / len(choices), (number + 1) / len(choices))
            smoothed, H = _on_surface(
                *hexes, grid, self.surface, self.features, self.options.smoothing, steps
            )
            if self._passes(smoothed, H, finer, split):
                return None
            if not smoothed.report.after.inverted:
                sound.append((smoothed, H))
        if not sound:
            return None
        return self._finer_where_far(grid, *min(sound, key=lambda made: made[0].report.after.hausdorff))

    def _passes(self, smoothed: SmoothedMesh, H: Ints, finer: float, split: int) -> bool:
        """Whether the hexes pass, and are fine; kept if they are the best so far."""
        verdict = check_hexes(smoothed.V, H, self.surface, self.features, self.options.check)
        refused = None if verdict.valid else ", ".join(verdict.problems)
        smoothing = asdict(smoothed.report)
        self.tried.append(
            {"finer": finer, "split": split, "refused": refused, "cells": len(H), "smoothing": smoothing}
        )
        if not verdict.valid:
            return False
        worst, volume = smoothed.report.after.min_scaled_jacobian, float(verdict.numbers["volume_ratio"])
        self.tried[-1]["volume_ratio"] = volume
        report = {"smoothing": smoothing, "grid": self.tried}
        made = GridHexes(smoothed.V, H, worst, volume, finer, split, report)
        if self.found is None or made.rank > self.found.rank:
            self.found = made
            for attempt in self.tried:
                attempt["kept"] = attempt is self.tried[-1]
        return made.fine

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


def _choices(grid: Grid, surface: Surface, bounded: bool) -> list[tuple[Floats, Ints]]:
    """V (n,3) and H (h,8) of cells of the grid that have the topology of the surface, a layer round them.

    Raises NotValid where there are none, or more than can be smoothed in minutes if `bounded`.
    """
    if math.prod(grid.counts.tolist()) > MOST_CELLS:
        raise NotValid(f"a grid of more than {MOST_CELLS:,} cells")
    depth = centre_depths(grid, surface)
    if bounded and np.count_nonzero(depth > 0.0) > MOST_HEXES:
        raise NotValid(f"more than {MOST_HEXES:,} hexes")
    choices = [pillow_hexes(*hexes) for hexes in cell_choices(grid, depth, surface)]
    if not choices:
        raise NotValid("cells with another topology than the surface")
    if bounded and len(choices[0][1]) > MOST_HEXES:
        raise NotValid(f"more than {MOST_HEXES:,} hexes")
    return choices


def _on_surface(
    V: Floats,
    H: Ints,
    grid: Grid,
    surface: Surface,
    features: Features,
    smoothing: SmoothOptions,
    progress: Progress,
) -> tuple[SmoothedMesh, Ints]:
    """The hexes H (h,8) over V (n,3), smoothed until their layer lies on the surface."""
    progress(0.0, f"grid of {' x '.join(map(str, grid.counts))} cells")
    followed = followed_features(surface, features, grid.edge_length)
    return smooth_hexes(V, H, surface, followed, smoothing, part(progress, 0.1, 0.9), voids=False), H

"""From the hexes of a map to those that are written: smoothed, padded where they are poor, finer where too coarse.

Hexes are `whole` where their shell has the topology of the surface, be it after pinches are taken apart: a map that is
not valid may give such ones, too.  Others have voids; they are smoothed only.  The vertices of a map's shell lie on the
surface: how far its hexes are from it is seen before anything is done, and smoothing mends a part of that only.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from typing import Any

from neurframe_cli.errors import NotValid, StageError
from neurframe_cli.mesh.arrays import Features, Floats, Ints, Progress, Surface, part, silent
from neurframe_cli.mesh.optimize.near_surface import GOOD_ENOUGH
from neurframe_cli.mesh.optimize.smooth import MeshNumbers, SmoothOptions
from neurframe_cli.mesh.optimize.soft_constraints import BAD
from neurframe_cli.mesh.pinches import has_topology_of, separate_pinches
from neurframe_cli.mesh.quality.check import CheckOptions, check_hexes
from neurframe_cli.stages.pad_hexes import padded_hexes
from neurframe_cli.stages.smooth_hexes import HEX_OPTIONS, measured_hexes, smooth_hexes

# times the limit of the distance; hexes of a map that were farther away than 2.1 times have not been seen to pass
TOO_FAR = 2.5
FAR_TO_PAD = 1.25  # the same after smoothing: a layer brings them nearer by less
MOST_TO_SPLIT = {2: 25_000, 3: 1_000}  # hexes that are split so many times; a finer mesh is not too coarse

# (V, H) of the same map with so many hexes along each edge of a hex; raises StageError or NotValid if there are none
FinerHexes = Callable[[int], tuple[Floats, Ints]]


@dataclass(frozen=True)
class FinishOptions:
    """padding: a layer along the whole boundary, None for one where hexes near the surface are poor without it;
    splitting: finer hexes of the same map where the mesh is not near the surface otherwise; give_up: hexes with voids,
    or too far from the surface for smoothing to help, are left as they are; check: what the mesh has to pass."""

    padding: bool | None = None
    splitting: bool = True
    give_up: bool = False
    smoothing: SmoothOptions = HEX_OPTIONS
    check: CheckOptions = field(default_factory=CheckOptions)


@dataclass(frozen=True)
class FinishedHexes:
    """V (n,3), cells (h,8) with their numbers; problems: why they do not pass the check, none where they do; report:
    what each step did for them, and with `splitting`, the attempts at finer ones, that at the first ones before;
    warnings: what the user should know; given_up: they are as the map gave them."""

    V: Floats
    cells: Ints
    numbers: MeshNumbers
    problems: tuple[str, ...]
    report: dict[str, Any]
    warnings: tuple[str, ...]
    given_up: bool = False

    @property
    def fine(self) -> bool:
        """Whether they pass the check, with no hex that is all but inverted."""
        return not self.problems and self.numbers.min_scaled_jacobian > BAD


@dataclass(frozen=True)
class _Hexes:
    V: Floats
    cells: Ints
    numbers: MeshNumbers
    whole: bool
    given_up: bool = False


def finish_hexes(
    V: Floats,
    H: Ints,
    surface: Surface,
    features: Features,
    options: FinishOptions,
    finer: FinerHexes,
    progress: Progress = silent,
) -> FinishedHexes:
    """Hexes H (h,8) over V (n,3) brought to the surface; where they are whole, they may be padded, and replaced by
    `finer` ones, without being asked for.  Raises InvalidMesh if there are no hexes."""
    finisher = _Finisher(surface, features, options)
    hexes, report = finisher.finished(V, H, part(progress, 0.0, 0.4))
    if options.splitting and hexes.whole and not finisher.is_fine(hexes):
        hexes, report = finisher.split(hexes, report, len(H), finer, part(progress, 0.4, 1.0))
    problems, warnings = tuple(finisher.problems(hexes)), tuple(finisher.warnings)
    return FinishedHexes(
        hexes.V, hexes.cells, hexes.numbers, problems, report, warnings, given_up=hexes.given_up
    )


class _Finisher:
    """The steps, and what they have to say."""

    def __init__(self, surface: Surface, features: Features, options: FinishOptions) -> None:
        self.surface, self.features, self.options = surface, features, options
        self.warnings: list[str] = []

    def is_fine(self, hexes: _Hexes) -> bool:
        """Whether they pass the check, with no hex that is all but inverted."""
        if not hexes.whole or hexes.given_up or hexes.numbers.min_scaled_jacobian <= BAD:
            return False
        return not self.problems(hexes)

    def problems(self, hexes: _Hexes) -> list[str]:
        """Why they do not pass the check."""
        return check_hexes(hexes.V, hexes.cells, self.surface, self.features, self.options.check).problems

    def finished(self, V: Floats, H: Ints, progress: Progress) -> tuple[_Hexes, dict[str, Any]]:
        """Smoothed, and padded where that is asked for or the hexes are poor, unless they are given up; with the report
        of all this."""
        V, H, whole = self._apart(V, H)
        limits, voids = self.options.smoothing, not whole
        if self.options.give_up:
            numbers = measured_hexes(V, H, self.surface, limits)
            if voids or numbers.hausdorff > TOO_FAR * limits.hausdorff_limit:
                return _Hexes(V, H, numbers, whole, given_up=True), {
                    "whole": whole,
                    "given_up": asdict(numbers),
                }
        result = smooth_hexes(V, H, self.surface, self.features, limits, part(progress, 0.0, 0.6), voids)
        report: dict[str, Any] = {"whole": whole, "smoothing": asdict(result.report)}
        numbers = result.report.after
        near = numbers.hausdorff <= FAR_TO_PAD * limits.hausdorff_limit
        poor = whole and near and numbers.min_scaled_jacobian < GOOD_ENOUGH
        if not (poor if self.options.padding is None else self.options.padding):
            return _Hexes(result.V, H, numbers, whole), report
        made = padded_hexes(result, H, self.surface, self.features, limits, part(progress, 0.6, 1.0), voids)
        report["padding"] = {"kept": made.kept, "padded": asdict(made.padded)}
        if not made.kept and self.options.padding:
            self.warnings.append(
                f"the hexes are not padded, that made them worse: {made.padded.inverted} inverted, worst scaled "
                f"Jacobian {made.padded.min_scaled_jacobian:.3f} instead of "
                f"{numbers.min_scaled_jacobian:.3f}"
            )
        return _Hexes(made.smoothed.V, made.cells, made.smoothed.report.after, whole), report

    def _apart(self, V: Floats, H: Ints) -> tuple[Floats, Ints, bool]:
        """The hexes, without pinches where that makes them whole, and whether they are."""
        if len(H) == 0 or has_topology_of(H, self.surface):
            return V, H, len(H) > 0
        apart = separate_pinches(V, H)
        return (*apart, True) if has_topology_of(apart[1], self.surface) else (V, H, False)

    def split(
        self, hexes: _Hexes, first: dict[str, Any], count: int, finer: FinerHexes, progress: Progress
    ) -> tuple[_Hexes, dict[str, Any]]:
        """The coarsest of the finer meshes that is fine, or `hexes`, of a map with `count` of them, whose report is
        `first`; with the report of what is returned."""
        tried: list[dict[str, Any]] = [{"times": 1, "kept": False, **first}]
        for number, times in enumerate(t for t, most in MOST_TO_SPLIT.items() if count <= most):
            steps = part(progress, number / len(MOST_TO_SPLIT), (number + 1) / len(MOST_TO_SPLIT))
            try:
                finer_hexes = finer(times)
            except (StageError, NotValid) as error:
                self.warnings.append(f"{times} times as many hexes along each edge could not be had: {error}")
                break
            result, report = self.finished(*finer_hexes, steps)
            kept = self.is_fine(result)
            tried.append({"times": times, "kept": kept, **report})
            if kept:
                self.warnings.append(
                    f"{len(hexes.cells)} hexes were too coarse for this surface (off by "
                    f"{100 * hexes.numbers.hausdorff:.2f} % of the diagonal, worst scaled Jacobian "
                    f"{hexes.numbers.min_scaled_jacobian:.3f}): each is split {times} times along each edge"
                )
                return result, {**report, "splitting": tried}
        tried[0]["kept"] = True
        return hexes, {**first, "splitting": tried}

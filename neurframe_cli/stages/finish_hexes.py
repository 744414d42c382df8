"""From the hexes of a map to those that are written: smoothed, padded where they are poor, split where too coarse."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any

from neurframe_cli.mesh.arrays import Features, Floats, Ints, Progress, Surface, part, silent
from neurframe_cli.mesh.optimize.smooth import BAD, MeshNumbers, SmoothedMesh, SmoothOptions
from neurframe_cli.stages.pad_hexes import padded_hexes
from neurframe_cli.stages.smooth_hexes import smooth_hexes
from neurframe_cli.stages.split_hexes import split_hexes

POOR = 0.2  # worst scaled Jacobian, below which a layer of hexes is tried
MOST_TO_SPLIT = 25_000  # hexes; a finer mesh is not too coarse for its surface


@dataclass(frozen=True)
class FinishOptions:
    """padding: a layer along the whole boundary, None for one where the hexes are poor without it; splitting: every
    hex in eight where the mesh is not near the surface otherwise."""

    padding: bool | None = None
    splitting: bool = True
    smoothing: SmoothOptions = field(default_factory=SmoothOptions)


@dataclass(frozen=True)
class FinishedHexes:
    """V (n,3), cells (h,8); report: what each step did; warnings: what the user should know."""

    V: Floats
    cells: Ints
    report: dict[str, Any]
    warnings: tuple[str, ...]


@dataclass(frozen=True)
class _Hexes:
    smoothed: SmoothedMesh
    cells: Ints

    @property
    def numbers(self) -> MeshNumbers:
        return self.smoothed.report.after


def finish_hexes(
    V: Floats,
    H: Ints,
    surface: Surface,
    features: Features,
    options: FinishOptions,
    whole: bool,
    progress: Progress = silent,
) -> FinishedHexes:
    """Hexes H (h,8) over V (n,3) brought to the surface; `whole`: nothing is missing, so that it may be padded and
    split without being asked for.  Raises InvalidMesh if there are no hexes."""
    finisher = _Finisher(surface, features, options, progress)
    hexes = finisher.smoothed(V, H)
    if options.padding or (options.padding is None and whole and hexes.numbers.min_scaled_jacobian < POOR):
        hexes = finisher.padded(hexes)
    if options.splitting and whole and not finisher.is_fine(hexes.numbers):
        hexes = finisher.split(hexes)
    return FinishedHexes(hexes.smoothed.V, hexes.cells, finisher.report, tuple(finisher.warnings))


class _Finisher:
    """The steps, and what they have to say."""

    def __init__(
        self, surface: Surface, features: Features, options: FinishOptions, progress: Progress
    ) -> None:
        self.surface, self.features, self.options, self.progress = surface, features, options, progress
        self.report: dict[str, Any] = {}
        self.warnings: list[str] = []

    def is_fine(self, numbers: MeshNumbers) -> bool:
        return (
            numbers.min_scaled_jacobian > BAD and numbers.hausdorff <= self.options.smoothing.hausdorff_limit
        )

    def smoothed(self, V: Floats, H: Ints) -> _Hexes:
        result = _Hexes(self._smooth(V, H, part(self.progress, 0.0, 0.4)), H)
        self.report["smoothing"] = asdict(result.smoothed.report)
        return result

    def padded(self, hexes: _Hexes) -> _Hexes:
        made = padded_hexes(
            hexes.smoothed,
            hexes.cells,
            self.surface,
            self.features,
            self.options.smoothing,
            part(self.progress, 0.4, 0.6),
        )
        self.report["padding"] = {"kept": made.kept, "padded": asdict(made.padded)}
        if not made.kept and self.options.padding:
            self.warnings.append(
                f"the hexes are not padded, that made them worse: {made.padded.inverted} inverted, worst scaled "
                f"Jacobian {made.padded.min_scaled_jacobian:.3f} instead of {hexes.numbers.min_scaled_jacobian:.3f}"
            )
        return _Hexes(made.smoothed, made.cells)

    def split(self, hexes: _Hexes) -> _Hexes:
        """Kept where it makes the mesh one that is fine."""
        if len(hexes.cells) > MOST_TO_SPLIT:
            return hexes
        V, H = split_hexes(hexes.smoothed.V, hexes.cells)
        result = _Hexes(self._smooth(V, H, part(self.progress, 0.6, 1.0)), H)
        kept = self.is_fine(result.numbers)
        self.report["splitting"] = {"kept": kept, "split": asdict(result.numbers)}
        if not kept:
            return hexes
        self.warnings.append(
            f"{len(hexes.cells)} hexes were too coarse for this surface (off by {100 * hexes.numbers.hausdorff:.2f} % "
            f"of the diagonal, worst scaled Jacobian {hexes.numbers.min_scaled_jacobian:.3f}): each is split in eight"
        )
        return result

    def _smooth(self, V: Floats, H: Ints, progress: Progress) -> SmoothedMesh:
        return smooth_hexes(V, H, self.surface, self.features, self.options.smoothing, progress)

"""What smoothing quads and smoothing hexes share: constraints, rounds of improvement, limit of distance, report."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from neurframe_cli.errors import InvalidMesh
from neurframe_cli.mesh.arrays import Features, Floats, Ints, Progress, Surface
from neurframe_cli.mesh.optimize.approach import approach, retreat
from neurframe_cli.mesh.optimize.cell_kind import CellKind
from neurframe_cli.mesh.optimize.classify import Classification, classify
from neurframe_cli.mesh.optimize.distance_probe import DistanceProbe, Distances
from neurframe_cli.mesh.optimize.improve import ImproveOptions, Improver, State
from neurframe_cli.mesh.optimize.mend_quads import mend_poor_quads
from neurframe_cli.mesh.optimize.patches import outward_normals
from neurframe_cli.mesh.optimize.reach import reach_far_places
from neurframe_cli.mesh.quality.polygons import unique_edges

BAD = 0.05  # scaled Jacobian; such a hex is of no more use than an inverted one
WITHIN = 0.9  # of the distance limit is what hexes are pulled to: other samples see a little more
PASSED_BY = (
    0.25  # edge lengths; coarse quads on a round surface are off by less everywhere, and not to be blamed
)


@dataclass(frozen=True)
class SmoothOptions:
    """hausdorff_limit, in bounding-box diagonals of the input: the distance of a boundary face may grow up to it, and
    not at all beyond; reach_limit, likewise: quads that leave places of the surface farther away are moved to them;
    mend_limit, likewise: how far faces may get for the sake of poor quads; samples on the surface for distances, seed
    for their places."""

    improve: ImproveOptions = field(default_factory=ImproveOptions)
    hausdorff_limit: float = 0.01
    reach_limit: float = 0.004
    mend_limit: float = 0.005
    samples: int = 10_000
    seed: int = 0


@dataclass(frozen=True)
class MeshNumbers:
    """Scaled Jacobians, a cell counting with its worst corner; hausdorff in bounding-box diagonals of the input."""

    min_scaled_jacobian: float
    p1_scaled_jacobian: float
    mean_scaled_jacobian: float
    inverted: int
    hausdorff: float


@dataclass(frozen=True)
class SmoothReport:
    """Numbers before and after, what the vertices were constrained to, rounds done, how many vertices went less than
    all the way because of the distance limit, and of how many feature curves let go so that poor quads got better."""

    before: MeshNumbers
    after: MeshNumbers
    classification: Classification
    rounds: int
    held_back: int
    released: int


@dataclass(frozen=True)
class SmoothedMesh:
    """V (n,3) float64 new positions of the vertices."""

    V: Floats
    report: SmoothReport


def smooth_cells(
    X: Floats,
    cells: Ints,
    kind: CellKind,
    faces: Ints,
    surface: Surface,
    features: Features,
    options: SmoothOptions,
    progress: Progress,
    voids: bool = False,
) -> SmoothedMesh:
    """Smooth cells (c,k) whose boundary quads, or which themselves if quads, are `faces` (f,4); `voids`: some of these
    may lie inside the solid, and stay.

    Raises InvalidMesh if there are no cells.
    """
    if len(cells) == 0:
        raise InvalidMesh("there are no cells to smooth")
    progress(0.0, "matching features")
    classified = classify(X, faces, surface, features, solid=faces is not cells, voids=voids)
    normals = outward_normals(faces, classified.patches) if faces is cells else None
    improver = Improver(X, cells, kind, classified.constraints, normals, options.improve)
    probe = DistanceProbe(faces, surface, options.samples, np.random.default_rng(options.seed))
    diagonal = float(np.linalg.norm(np.ptp(surface.V[np.unique(surface.F)], axis=0)))
    distances = probe.measure(X)
    origin, start, last = improver.first, classified.start, [distances]
    soft = _Soft(improver, X, start, probe, options.hausdorff_limit * diagonal)
    if normals is None and origin.inverted and (found := soft.approached()) is not None:
        progress(0.1, "untangled")
        origin, start, last = found, found.x, [probe.measure(found.x)]
    improved, rounds = improver.run(origin, start, progress)
    limit = np.maximum(last[0].by_face, options.hausdorff_limit * diagonal)

    def too_far(x: Floats) -> Ints:
        last[:] = [probe.measure(x)]
        return np.unique(faces[last[0].by_face > limit])

    from_origin = last[0]
    final = improver.guarded(origin, improved.x, too_far)
    if not final.better_than(origin):
        final, last = origin, [from_origin]  # what is left of the way leads nowhere
    released = 0
    if normals is None:
        final, last[0] = soft.nearer(final, last[0])
    held_back = int((final.x != improved.x).any(axis=1).sum())
    if normals is not None:
        passed_by = max(options.reach_limit * diagonal, PASSED_BY * _median_edge(final.x, faces))
        final, last[0] = reach_far_places(improver, final, probe, last[0], passed_by)
        near = np.maximum(last[0].by_face, options.mend_limit * diagonal)
        mended = mend_poor_quads(improver, final, classified.patches, probe, last[0], near)
        final, last[0], released = mended.state, mended.distances, mended.released
    progress(1.0, f"worst {final.quality.min():.3f}, mean {final.quality.mean():.3f}")
    report = SmoothReport(
        before=_numbers(improver.first, distances, diagonal),
        after=_numbers(final, last[0], diagonal),
        classification=classified.found,
        rounds=rounds,
        held_back=held_back,
        released=released,
    )
    return SmoothedMesh(final.x, report)


class _Soft:
    """Hexes whose vertices cannot all be where they should: what no step that makes no hex worse finds."""

    def __init__(
        self, improver: Improver, X: Floats, start: Floats, probe: DistanceProbe, limit: float
    ) -> None:
        self.improver, self.X, self.start, self.probe, self.limit = improver, X, start, probe, limit
        self._approached: list[State | None] = []

    def approached(self) -> State | None:
        """From the positions X (n,3) of the map; worked out once."""
        if not self._approached:
            goal = WITHIN * self.limit
            self._approached.append(approach(self.improver, self.X, self.start, self._distance, goal))
        return self._approached[0]

    def nearer(self, state: State, distances: Distances) -> tuple[State, Distances]:
        """Where `state` has bad hexes or is beyond the limit: hexes that are not inverted, and nearer to the surface or
        near enough."""
        away = float(distances.by_face.max())
        if state.quality.min() > BAD and away <= self.limit:
            return state, distances
        found = None
        if away <= self.limit:
            found = retreat(self.improver, state.x, self._distance, max(WITHIN * self.limit, away))
        if found is None and (state.inverted or away > self.limit):
            found = self.approached()
        if found is None or self._distance(found.x) > max(self.limit, away):
            return state, distances
        return found, self.probe.measure(found.x)

    def _distance(self, x: Floats) -> float:
        return float(self.probe.measure(x).by_face.max())


def _median_edge(X: Floats, faces: Ints) -> float:
    ends = X[unique_edges(faces)[0]]
    return float(np.median(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)))


def _numbers(state: State, distances: Distances, diagonal: float) -> MeshNumbers:
    return MeshNumbers(
        min_scaled_jacobian=float(state.quality.min()),
        p1_scaled_jacobian=float(np.percentile(state.quality, 1)),
        mean_scaled_jacobian=float(state.quality.mean()),
        inverted=state.inverted,
        hausdorff=float(distances.by_face.max()) / diagonal,
    )

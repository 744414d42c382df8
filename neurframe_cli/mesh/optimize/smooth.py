"""What smoothing quads and smoothing hexes share: constraints, rounds of improvement, limit of distance, report."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from neurframe_cli.errors import InvalidMesh
from neurframe_cli.mesh.arrays import Features, Floats, Ints, Progress, Surface, part
from neurframe_cli.mesh.measure import box_diagonal
from neurframe_cli.mesh.optimize.cell_kind import CellKind
from neurframe_cli.mesh.optimize.classify import Classification, classify
from neurframe_cli.mesh.optimize.constraints import FREE, ON_CURVE, Constraints
from neurframe_cli.mesh.optimize.distance_probe import BothDiagonals, DistanceProbe, Distances
from neurframe_cli.mesh.optimize.improve import ImproveOptions, Improver, State
from neurframe_cli.mesh.optimize.let_go import let_go
from neurframe_cli.mesh.optimize.mend_quads import mend_poor_quads
from neurframe_cli.mesh.optimize.patches import Patches, outward_normals
from neurframe_cli.mesh.optimize.reach import reach_far_places
from neurframe_cli.mesh.optimize.soft_constraints import BAD, Placed, SoftConstraints
from neurframe_cli.mesh.quality.polygons import unique_edges

WORTH, SHARE = 0.2, 0.6  # scaled Jacobian, and share of the worst one, that a hex keeps while vertices settle
RINGS = 3  # of hexes whose features let go
ABOUT = 1.05  # times the limit of the distance, for much better hexes
NEAR_ENOUGH = 1.2  # times the limit, for features that have let go: settling brings the mesh nearer
POOREST = (0.08, 0.12, 0.16, 0.2)  # scaled Jacobians of hexes that features let go of, one after the other
PASSED_BY = (
    0.25  # edge lengths; coarse quads on a round surface are off by less everywhere, and not to be blamed
)


@dataclass(frozen=True)
class SmoothOptions:
    """hausdorff_limit, in bounding-box diagonals of the input: the distance of a boundary face may grow up to it, and
    not at all beyond; reach_limit, likewise: quads that leave places of the surface farther away are moved to them;
    mend_limit, likewise: how far faces may get for the sake of poor quads; soft_first: hexes that are away from the
    surface all over are drawn to it by the soft constraints before anything else; samples on the surface for distances,
    seed for their places."""

    improve: ImproveOptions = field(default_factory=ImproveOptions)
    hausdorff_limit: float = 0.01
    reach_limit: float = 0.004
    mend_limit: float = 0.005
    soft_first: bool = False
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
    probe_of = DistanceProbe if faces is cells else BothDiagonals
    probe = probe_of(faces, surface, options.samples, np.random.default_rng(options.seed))
    diagonal = box_diagonal(surface.V[np.unique(surface.F)])
    first = Placed(improver.first, probe.measure(X))
    limit = options.hausdorff_limit * diagonal
    begin = _loose(improver, first.state, part(progress, 0.0, 0.0)) if options.soft_first else X
    soft = SoftConstraints(improver, begin, classified.start, probe, limit, sliding=options.soft_first)
    origin = (soft.untangled() if options.soft_first else None) or first
    start = classified.start if origin is first else origin.state.x
    improved, rounds = improver.run(origin.state, start, part(progress, 0.0, 0.5))
    final = _within(improver, origin, improved, probe, limit)
    released = 0
    if normals is None:
        if not options.soft_first and final.state.inverted and (found := soft.untangled()) is not None:
            improved, more = improver.run(found.state, found.state.x, part(progress, 0.5, 1.0))
            final = _within(improver, found, improved, probe, limit)
            rounds += more
        final = soft.nearer(final)
        if not voids:  # their boundary is pinned, too, and must stay
            last = part(progress, 1.0, 1.0)
            end = _freed_of_features if options.soft_first else _let_go
            final, released = end(improver, final, probe, limit, surface, last)
            final = _settled(improver, final, probe, limit)
    held_back = int((final.state.x != improved.x).any(axis=1).sum())
    if normals is not None:
        final, released = _mended(improver, final, probe, classified.patches, options, diagonal)
    quality = final.state.quality
    progress(1.0, f"worst {quality.min():.3f}, mean {quality.mean():.3f}")
    report = SmoothReport(
        before=mesh_numbers(first.state.quality, first.distances, diagonal),
        after=mesh_numbers(final.state.quality, final.distances, diagonal),
        classification=classified.found,
        rounds=rounds,
        held_back=held_back,
        released=released,
    )
    return SmoothedMesh(final.state.x, report)


def _loose(improver: Improver, state: State, progress: Progress) -> Floats:
    """Positions (n,3) with better hexes, nothing being held: a hex that is all but inverted makes the barrier hold all
    of the mesh."""
    held = Constraints(np.full(len(state.x), FREE), state.x, [])
    return improver.constrained(held).run(state, state.x, progress)[0].x


def _freed_of_features(
    improver: Improver,
    placed: Placed,
    probe: DistanceProbe,
    limit: float,
    surface: Surface,
    progress: Progress,
) -> tuple[Placed, int]:
    """Hexes that soft constraints have drawn to the surface, after features have let go: of poor ones and all round
    them, but only if that brings the mesh near enough where it was not; then of the poorest, drawn anew."""
    released = 0
    if placed.distances.by_face.max() > limit:
        freed, count = _let_go(improver, placed, probe, limit, surface, progress, POOREST[-1])
        if freed.distances.by_face.max() <= NEAR_ENOUGH * limit:
            placed, released = freed, count
    placed, more = _drawn_anew(improver, placed, probe, limit, surface, progress)
    return placed, max(released, more)


def _let_go(
    improver: Improver,
    placed: Placed,
    probe: DistanceProbe,
    limit: float,
    surface: Surface,
    progress: Progress,
    least: float = BAD,
) -> tuple[Placed, int]:
    """Hexes better than `least`, where letting go of features in the others makes them so, or round those that stay bad
    in as many rings of hexes as needed; with the number of vertices let go."""
    held = improver.constraints.kind >= ON_CURVE
    chosen, freed = np.zeros(len(improver.cells), bool), 0
    for rings in range(RINGS):
        bad = np.asarray(placed.state.quality <= least)
        if not bad.any():
            break
        for _ in range(rings):
            bad = np.asarray(np.isin(improver.cells, improver.cells[bad]).any(axis=1))
        chosen |= bad
        count = int(held[np.unique(improver.cells[chosen])].sum())
        if count == freed:
            continue
        freed = count
        free = improver.constrained(let_go(improver.constraints, surface, improver.cells[chosen]))
        improved = free.run(placed.state, placed.state.x, progress)[0]
        placed = _within(free, placed, improved, probe, limit)
    return placed, freed


def _drawn_anew(
    improver: Improver,
    placed: Placed,
    probe: DistanceProbe,
    limit: float,
    surface: Surface,
    progress: Progress,
) -> tuple[Placed, int]:
    """The same for hexes that soft constraints have drawn to the surface: they are drawn to it anew, from where they
    are, features having let go of the poorest hexes, then of less poor ones, as long as that makes the poorest better
    and leaves no place too far away."""
    held = improver.constraints.kind >= ON_CURVE
    chosen, freed = np.zeros(len(improver.cells), bool), 0
    for least in POOREST:
        poor = np.asarray(placed.state.quality <= least)
        if not poor.any():
            continue
        loose = chosen | poor
        free = improver.constrained(let_go(improver.constraints, surface, improver.cells[loose]))
        x = placed.state.x
        drawn = SoftConstraints(free, x, x, probe, limit, sliding=True).untangled()
        if drawn is None:
            break
        drawn = _within(free, drawn, free.run(drawn.state, drawn.state.x, progress)[0], probe, limit)
        away = float(drawn.distances.by_face.max())
        better = drawn.state.quality.min() > placed.state.quality.min()
        if not better or away > max(ABOUT * limit, float(placed.distances.by_face.max())):
            break
        placed, chosen = drawn, loose
        freed = int(held[np.unique(improver.cells[chosen])].sum())
    return placed, freed


def _within(
    improver: Improver, origin: Placed, improved: State, probe: DistanceProbe, limit: float
) -> Placed:
    """As much of the way from `origin` to `improved` as leaves no face beyond the limit that was not."""
    final = _moved(improver, origin, improved.x, probe, limit)
    return final if final.state.better_than(origin.state) else origin


def _settled(improver: Improver, placed: Placed, probe: DistanceProbe, limit: float) -> Placed:
    """Vertices where the constraints want them, wherever no hex gets poor for that, nor worse than the worst one was at
    first: soft constraints leave all of them a little off, and planes uneven."""
    goal = improver.constraints.project(placed.state.x).points
    quality = placed.state.quality
    least = max(WORTH, SHARE * quality.min(), improver.first.quality.min())
    allowed = np.minimum(quality, least)
    return _moved(improver, placed, goal, probe, limit, allowed)


def _moved(
    improver: Improver,
    origin: Placed,
    goal: Floats,
    probe: DistanceProbe,
    limit: float,
    allowed: Floats | None = None,
) -> Placed:
    """As much of the way from `origin` to `goal` (n,3) as guarded_step allows, with cells no worse than `allowed` (c,)
    and no face beyond the limit that was not."""
    near = np.maximum(origin.distances.by_face, limit)
    last = origin.distances

    def too_far(x: Floats) -> Ints:
        nonlocal last
        last = probe.measure(x)
        return np.unique(probe.faces[last.by_face > near])

    final = improver.guarded(origin.state, goal, too_far, allowed)
    return Placed(final, last)


def _mended(
    improver: Improver,
    placed: Placed,
    probe: DistanceProbe,
    patches: Patches,
    options: SmoothOptions,
    diagonal: float,
) -> tuple[Placed, int]:
    """Quads moved to places of the surface that they leave far away, and the poor ones mended; with the number of
    curves let go for that."""
    passed_by = max(options.reach_limit * diagonal, PASSED_BY * _median_edge(placed.state.x, probe.faces))
    state, distances = reach_far_places(improver, placed.state, probe, placed.distances, passed_by)
    near = np.maximum(distances.by_face, options.mend_limit * diagonal)
    mended = mend_poor_quads(improver, state, patches, probe, distances, near)
    return Placed(mended.state, mended.distances), mended.released


def _median_edge(X: Floats, faces: Ints) -> float:
    ends = X[unique_edges(faces)[0]]
    return float(np.median(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)))


def mesh_numbers(quality: Floats, distances: Distances, diagonal: float) -> MeshNumbers:
    """Of cells with their worst scaled Jacobians `quality` (c,)."""
    return MeshNumbers(
        min_scaled_jacobian=float(quality.min()),
        p1_scaled_jacobian=float(np.percentile(quality, 1)),
        mean_scaled_jacobian=float(quality.mean()),
        inverted=int((quality <= 0.0).sum()),
        hausdorff=float(distances.by_face.max()) / diagonal,
    )

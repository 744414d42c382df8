"""What smoothing quads and smoothing hexes share: constraints, rounds of improvement, limit of distance, report."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from neurframe_cli.errors import InvalidMesh
from neurframe_cli.mesh.arrays import Features, Floats, Ints, Progress, Surface, part, silent
from neurframe_cli.mesh.measure import box_diagonal
from neurframe_cli.mesh.optimize.cell_kind import CellKind
from neurframe_cli.mesh.optimize.classify import Classification, classify
from neurframe_cli.mesh.optimize.constraints import FREE, Constraints
from neurframe_cli.mesh.optimize.distance_probe import BothDiagonals, DistanceProbe, Distances
from neurframe_cli.mesh.optimize.improve import ImproveOptions, Improver
from neurframe_cli.mesh.optimize.lift import lifted
from neurframe_cli.mesh.optimize.mend_quads import mend_poor_quads
from neurframe_cli.mesh.optimize.near_surface import NearSurface, Placed
from neurframe_cli.mesh.optimize.patches import Patches, outward_normals
from neurframe_cli.mesh.optimize.reach import reach_far_places
from neurframe_cli.mesh.optimize.release import released_of_soft, released_round_bad
from neurframe_cli.mesh.optimize.settle import settled
from neurframe_cli.mesh.optimize.soft_constraints import SoftConstraints
from neurframe_cli.mesh.quality.polygons import unique_edges

Release = Callable[[NearSurface, Placed, Surface], tuple[Placed, int]]

PASSED_BY = (
    0.25  # edge lengths; coarse quads on a round surface are off by less everywhere, and not to be blamed
)


@dataclass(frozen=True)
class SmoothOptions:
    """hausdorff_limit, in bounding-box diagonals of the input: the distance of a boundary face may grow up to it, and
    not at all beyond; useless_beyond, likewise: hexes that are farther away are not lifted, and others preferred;
    reach_limit, likewise: quads that leave places of the surface farther away are moved to them; mend_limit, likewise:
    how far faces may get for the sake of poor quads; soft_first: hexes that are away from the surface all over are
    drawn to it by the soft constraints before anything else; samples on the surface for distances, seed for their
    places."""

    improve: ImproveOptions = field(default_factory=ImproveOptions)
    hausdorff_limit: float = 0.01
    useless_beyond: float = 0.01
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
    limit = options.hausdorff_limit * diagonal
    near = NearSurface(improver, probe, limit, useless_beyond=max(limit, options.useless_beyond * diagonal))
    first = near.placed(improver.first)
    steps = part(progress, 0.0, 0.9)
    if normals is not None:
        run = _improved(near, first, classified.start, steps)
        final, released = _mended(near, run.placed, classified.patches, options, diagonal)
    else:
        run = _improved_hexes(near, first, classified.start, options.soft_first, steps)
        final, released = _finished_hexes(near, run.placed, surface, options.soft_first, voids)
    quality = final.state.quality
    progress(1.0, f"worst {quality.min():.3f}, mean {quality.mean():.3f}")
    report = SmoothReport(
        before=mesh_numbers(first.state.quality, first.distances, diagonal),
        after=mesh_numbers(final.state.quality, final.distances, diagonal),
        classification=classified.found,
        rounds=run.rounds,
        held_back=run.held_back,
        released=released,
    )
    return SmoothedMesh(final.state.x, report)


@dataclass(frozen=True)
class _Run:
    """The mesh after rounds of improvement, and how many vertices the limit of the distance held back in the last."""

    placed: Placed
    rounds: int
    held_back: int


def _improved(near: NearSurface, origin: Placed, start: Floats, progress: Progress) -> _Run:
    """Rounds from `start` (n,3), and as much of the way there from `origin` as the limit allows."""
    improved, rounds = near.improver.run(origin.state, start, progress)
    placed = near.within(origin, improved)
    return _Run(placed, rounds, int((placed.state.x != improved.x).any(axis=1).sum()))


def _improved_hexes(
    near: NearSurface, first: Placed, start: Floats, soft_first: bool, progress: Progress
) -> _Run:
    """The same for hexes, which soft constraints draw to the surface where hard ones leave them inverted or away from
    it, or before these if `soft_first`."""
    X = _loose(near.improver, silent) if soft_first else first.state.x
    soft = SoftConstraints(near, X, start, sliding=soft_first)
    origin = (soft.untangled() if soft_first else None) or first
    run = _improved(near, origin, start if origin is first else origin.state.x, progress)
    if not soft_first and run.placed.state.inverted and (found := soft.untangled()) is not None:
        again = _improved(near, found, found.state.x, progress)
        run = _Run(again.placed, run.rounds + again.rounds, again.held_back)
    return replace(run, placed=soft.nearer(run.placed))


def _finished_hexes(
    near: NearSurface, placed: Placed, surface: Surface, soft_first: bool, voids: bool
) -> tuple[Placed, int]:
    """The poorest hexes made better, features letting go of them where that is needed, and the vertices in place; with
    the number of vertices let go.  That is done with hexes as they are, and with lifted ones, which may have room for
    more features or be in the way of others; the better mesh is kept."""
    release = released_of_soft if soft_first else released_round_bad
    made = _in_place(near, placed, surface, None if voids else release, alone=soft_first)
    first = lifted(near, placed, surface, may_release=False).placed
    if first is placed:
        return made
    other = _in_place(near, first, surface, None if voids else release, alone=True)
    return max(made, other, key=lambda one: near.worth(one[0]))


def _in_place(
    near: NearSurface, placed: Placed, surface: Surface, release: Release | None, alone: bool
) -> tuple[Placed, int]:
    """Features let go of the poorest hexes, vertices settle, one by one if `alone`, and the worst hexes are lifted.
    Without a `release`, round voids, nothing lets go: their boundary is pinned, too, and must stay."""
    released = 0
    if release is not None:
        placed, released = release(near, placed, surface)
        placed = settled(near, placed, alone)
    made = lifted(near, placed, surface, may_release=release is not None)
    return made.placed, released + made.released


def _loose(improver: Improver, progress: Progress) -> Floats:
    """Positions (n,3) with better hexes, nothing being held: a hex that is all but inverted makes the barrier hold all
    of the mesh."""
    first = improver.first
    held = Constraints(np.full(len(first.x), FREE), first.x, [])
    return improver.constrained(held).run(first, first.x, progress)[0].x


def _mended(
    near: NearSurface, placed: Placed, patches: Patches, options: SmoothOptions, diagonal: float
) -> tuple[Placed, int]:
    """Quads moved to places of the surface that they leave far away, and the poor ones mended; with the number of
    curves let go for that."""
    improver, probe = near.improver, near.probe
    passed_by = max(options.reach_limit * diagonal, PASSED_BY * _median_edge(placed.state.x, probe.faces))
    state, distances = reach_far_places(improver, placed.state, probe, placed.distances, passed_by)
    most = np.maximum(distances.by_face, options.mend_limit * diagonal)
    mended = mend_poor_quads(improver, state, patches, probe, distances, most)
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

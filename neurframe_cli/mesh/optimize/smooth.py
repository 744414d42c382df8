"""What smoothing quads and smoothing hexes share: constraints, rounds of improvement, limit of distance, report."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from neurframe_cli.mesh.arrays import Features, Floats, Ints, Progress, Surface
from neurframe_cli.mesh.optimize.cell_kind import CellKind
from neurframe_cli.mesh.optimize.classify import Classification, classify
from neurframe_cli.mesh.optimize.improve import ImproveOptions, Improver, Normals, State
from neurframe_cli.mesh.optimize.patches import Patches
from neurframe_cli.mesh.quality.distance import surface_distance
from neurframe_cli.mesh.quality.polygons import triangulated

BLENDS = (
    1.0,
    0.5,
    0.25,
)  # shares of the way that are tried while the distance is too large; then nothing moves


@dataclass(frozen=True)
class SmoothOptions:
    """hausdorff_limit, in bounding-box diagonals of the input: the distance may grow up to it, and not at all beyond;
    samples of each surface for distances."""

    improve: ImproveOptions = field(default_factory=ImproveOptions)
    hausdorff_limit: float = 0.01
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
    """Numbers before and after, what the vertices were constrained to, rounds done, and the share of the way taken (1
    unless the distance limit was in the way)."""

    before: MeshNumbers
    after: MeshNumbers
    classification: Classification
    rounds: int
    share_of_way: float


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
) -> SmoothedMesh:
    """Smooth cells (c,k) whose boundary quads, or which themselves if quads, are `faces` (f,4)."""
    progress(0.0, "matching features")
    classified = classify(X, faces, surface, features, voids=faces is not cells)
    normals = _outward(faces, classified.patches) if faces is cells else None
    improver = Improver(X, cells, kind, classified.constraints, normals, options.improve)
    improved, rounds = improver.run(classified.start, progress)
    before = _numbers(improver.first, faces, surface, options)
    limit = max(before.hausdorff, options.hausdorff_limit)
    for share in BLENDS:
        state = improver.guarded(improver.first, X + share * (improved.x - X)) if share < 1.0 else improved
        after = _numbers(state, faces, surface, options)
        if after.hausdorff <= limit:
            return SmoothedMesh(state.x, SmoothReport(before, after, classified.found, rounds, share))
    return SmoothedMesh(X.copy(), SmoothReport(before, before, classified.found, rounds, 0.0))


def _outward(quads: Ints, patches: Patches) -> Normals:
    """Normals of the input under the centres of the quads, each on its own patch."""
    groups = [(tree, np.flatnonzero(patches.of_face == t)) for t, tree in enumerate(patches.trees)]

    def normals(x: Floats) -> Floats:
        result = np.zeros((len(quads), 3))
        for tree, members in groups:
            if len(members):
                result[members] = tree.closest(x[quads[members]].mean(axis=1)).directions
        return result

    return normals


def _numbers(state: State, faces: Ints, surface: Surface, options: SmoothOptions) -> MeshNumbers:
    rng = np.random.default_rng(options.seed)
    distance = surface_distance(Surface(state.x, triangulated(faces)), surface, options.samples, rng)
    diagonal = float(np.linalg.norm(np.ptp(surface.V[np.unique(surface.F)], axis=0)))
    return MeshNumbers(
        min_scaled_jacobian=float(state.quality.min()),
        p1_scaled_jacobian=float(np.percentile(state.quality, 1)),
        mean_scaled_jacobian=float(state.quality.mean()),
        inverted=state.inverted,
        hausdorff=distance.hausdorff / diagonal,
    )

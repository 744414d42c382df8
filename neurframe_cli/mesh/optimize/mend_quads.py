"""Poor quads mended where they are: their surroundings are improved alone, and curves let go of vertices there.

A round over all of a mesh ends when the mean corner gains no more, long before a few quads in a narrow place are as
good as they can be.  Others cannot be good: a curve that takes two edges in a row of one quad, or two curves that are
closer than a quad is wide, leave it a corner of 180 degrees wherever their vertices slide.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from neurframe_cli.mesh.arrays import Bools, Floats, Ints
from neurframe_cli.mesh.optimize.cell_kind import QUADS
from neurframe_cli.mesh.optimize.constraints import ON_CURVE, ON_SURFACE, PINNED, Constraints, Track
from neurframe_cli.mesh.optimize.distance_probe import DistanceProbe, Distances
from neurframe_cli.mesh.optimize.improve import ImproveOptions, Improver, State, quad_normals
from neurframe_cli.mesh.optimize.patches import Patches, outward_normals
from neurframe_cli.mesh.quality.polygons import unique_edges

POOR, BAD = 0.3, 0.1  # scaled Jacobians; the tip of a wedge of 15 degrees is poor by right
RINGS = 4  # of quads around the poor ones that may move
FLAT_DEG = 150.0
LEAST_GAIN = 0.01  # of the worst quad, for which a curve may let go
LOCAL = ImproveOptions(rounds=30, steps=20, gain=1e-4)


@dataclass(frozen=True)
class Mended:
    """The mesh, its distances to the surface, and of how many vertices curves let go."""

    state: State
    distances: Distances
    released: int


def mend_poor_quads(
    improver: Improver,
    state: State,
    patches: Patches,
    probe: DistanceProbe,
    distances: Distances,
    limit: Floats,
) -> Mended:
    """`state` with better quads where some are worse than POOR; no quad gets worse than the worst one near it.

    At first nothing lets go, then the flat corners of the poor quads, then all vertices of the BAD ones, then those of
    the quads around these as well, until none is poor any more.  Open boundaries never let go.  No face gets farther
    from the surface than `limit` (f,).
    """
    released = 0
    edges, use = unique_edges(improver.cells)
    rim = np.zeros(len(state.x), bool)
    rim[edges[use == 1]] = True
    for region in _regions(improver.cells, state.quality < POOR):
        spot = _Spot(improver, region, patches, rim, probe, limit)
        state, distances, count = spot.mended(state, distances)
        released += count
    return Mended(state, distances, released)


class _Spot:
    """The quads `region` (k,) around some poor ones; vertices that other quads share stay where they are."""

    def __init__(
        self,
        improver: Improver,
        region: Ints,
        patches: Patches,
        rim: Bools,
        probe: DistanceProbe,
        limit: Floats,
    ) -> None:
        self.improver, self.region, self.patches = improver, region, patches
        self.rim, self.probe, self.limit = rim, probe, limit
        self.fixed = np.zeros(len(rim), bool)
        self.fixed[np.delete(improver.cells, region, axis=0)] = True
        self.vertices, local = np.unique(improver.cells[region], return_inverse=True)
        self.cells = local.reshape(-1, 4)
        self.normals = outward_normals(self.cells, replace(patches, of_face=patches.of_face[region]))

    def mended(self, state: State, distances: Distances) -> tuple[State, Distances, int]:
        """The best mesh found, its distances, and the number of vertices that curves let go of for it."""
        released, tried = np.zeros(0, np.int64), -1
        for let_go in (_nothing, _flat_corners, _bad_quads, _around_bad_quads):
            found = let_go(state.x, self.improver.cells[self.region], state.quality[self.region])
            candidates = np.union1d(released, found[self._held(found)])
            if len(candidates) == tried:
                continue
            tried = len(candidates)
            new, measured = self._improved(state, distances, candidates)
            if self._worst(new) > self._worst(state) + LEAST_GAIN * (tried > len(released)):
                state, distances, released = new, measured, candidates
            if self._worst(state) >= POOR:
                break
        return state, distances, len(released)

    def _worst(self, state: State) -> float:
        return float(state.quality[self.region].min())

    def _held(self, vertices: Ints) -> Bools:
        kind = self.improver.constraints.kind[vertices]
        held = (kind == ON_CURVE) | (kind == PINNED)
        return np.asarray(held & ~self.fixed[vertices] & ~self.rim[vertices])

    def _improved(self, state: State, distances: Distances, released: Ints) -> tuple[State, Distances]:
        """The mesh with this spot as good as it gets when curves let go of `released` (k,)."""
        constraints = self._constraints(state.x, released)
        improver = Improver(state.x[self.vertices], self.cells, QUADS, constraints, self.normals, LOCAL)
        improved, _ = improver.run(improver.first, improver.first.x, lambda fraction, text: None)
        last = [distances]

        def too_far(x: Floats) -> Ints:
            whole = self._whole(state, x)
            last[:] = [self.probe.measure(whole, distances)]
            far = np.unique(self.improver.cells[last[0].by_face > self.limit])
            near = np.flatnonzero(np.isin(self.vertices, far))
            return near if len(near) or not len(far) else np.arange(len(self.vertices))

        kept = improver.guarded(improver.first, improved.x, too_far)
        x = self._whole(state, kept.x)
        return self.improver.state(x, state), self.probe.measure(x, distances)

    def _whole(self, state: State, local: Floats) -> Floats:
        x = state.x.copy()
        x[self.vertices] = local
        return x

    def _constraints(self, x: Floats, released: Ints) -> Constraints:
        """Those of the whole mesh for the vertices here; `released` slide on all of the surface."""
        whole = self.improver.constraints
        kind, pins = whole.kind.copy(), np.where(self.fixed[:, None], x, whole.pins)
        kind[released], kind[self.fixed] = ON_SURFACE, PINNED
        free = np.isin(np.arange(len(kind)), self.vertices) & ~self.fixed
        free[released] = False
        tracks = [Track(t.tree, t.vertices[free[t.vertices]]) for t in whole.tracks]
        tracks.append(Track(self.patches.trees[0], released))
        local = [
            replace(t, vertices=np.searchsorted(self.vertices, t.vertices)) for t in tracks if len(t.vertices)
        ]
        return Constraints(kind[self.vertices], pins[self.vertices], local)


def _nothing(x: Floats, quads: Ints, quality: Floats) -> Ints:
    return np.zeros(0, np.int64)


def _flat_corners(x: Floats, quads: Ints, quality: Floats) -> Ints:
    """Vertices (k,) at which one of the poor `quads` (q,4) has an angle of more than FLAT_DEG."""
    poor = quads[quality < POOR]
    P = x[poor]
    ahead, behind = np.roll(P, -1, axis=1) - P, np.roll(P, 1, axis=1) - P
    normals = np.broadcast_to(quad_normals(x, poor)[:, None], P.shape)
    sine = np.einsum("qcd,qcd->qc", np.cross(ahead, behind), normals)
    angle = np.degrees(np.arctan2(sine, np.einsum("qcd,qcd->qc", ahead, behind))) % 360.0
    return np.unique(poor[angle > FLAT_DEG])


def _bad_quads(x: Floats, quads: Ints, quality: Floats) -> Ints:
    return np.unique(quads[quality < BAD])


def _around_bad_quads(x: Floats, quads: Ints, quality: Floats) -> Ints:
    return np.unique(quads[np.isin(quads, quads[quality < BAD]).any(axis=1)])


def _regions(cells: Ints, poor: Bools) -> list[Ints]:
    """The poor quads with RINGS rings around them: indices of the quads of each connected part."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    chosen = np.flatnonzero(poor)
    for _ in range(RINGS):
        chosen = np.flatnonzero(np.isin(cells, cells[chosen]).any(axis=1))
    if len(chosen) == 0:
        return []
    use = coo_matrix(
        (np.ones(4 * len(chosen)), (np.repeat(np.arange(len(chosen)), 4), cells[chosen].ravel()))
    ).tocsr()
    count, part = connected_components(use @ use.T, directed=False)
    return [chosen[part == p] for p in range(count)]

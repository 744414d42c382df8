"""Quads brought to the places of the surface that they pass by: tips and narrow ridges between their vertices."""

from __future__ import annotations

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints
from neurframe_cli.mesh.optimize.constraints import ON_SURFACE
from neurframe_cli.mesh.optimize.distance_probe import DistanceProbe, Distances
from neurframe_cli.mesh.optimize.improve import Improver, State

ROUNDS = 4
LEAST_QUALITY = 0.5  # scaled Jacobian that no quad loses for being nearer to the surface
LEAST_GAIN = 0.25  # share of the distance; less is not worth it


def reach_far_places(
    improver: Improver, start: State, probe: DistanceProbe, distances: Distances, limit: float
) -> tuple[State, Distances]:
    """Positions with fewer samples of the surface farther than `limit` from the quads, and the distances there, given
    those at `start`.

    The vertex nearest to such a sample, if it may slide on the surface, goes there, or as much of the way as leaves
    every quad at LEAST_QUALITY or what it had.  No face gets farther from the surface than it was, but for those
    round that vertex: they take over a part of the distance.
    """
    state = start
    for _ in range(ROUNDS):
        new, farthest = _moved_to_far_samples(improver, state, probe, distances, limit)
        if (new == state.x).all():
            break
        base, last = distances, [distances]

        def harmed(
            x: Floats, farthest: Floats = farthest, base: Distances = base, last: list[Distances] = last
        ) -> Ints:
            last[:] = [
                probe.measure(x, base)
            ]  # not from the last trial: where nothing has moved, nothing does harm
            return np.unique(improver.cells[last[0].by_face > farthest])

        # a mesh that was better from the start stays as good
        mark = max(LEAST_QUALITY, float(improver.first.quality.min()))
        next_state = improver.guarded(state, new, harmed, np.minimum(state.quality, mark))
        if (next_state.x == state.x).all():
            break
        state, distances = next_state, last[0]
    return state, distances


def _moved_to_far_samples(
    improver: Improver, state: State, probe: DistanceProbe, distances: Distances, limit: float
) -> tuple[Floats, Floats]:
    """Positions with the nearest vertex of each far face at its farthest sample, and how far each face may be then."""
    farthest = np.maximum(distances.by_face, limit)
    distance, face, points = distances.back, distances.nearest, probe.points
    x, taken = state.x.copy(), set[int]()
    far = np.flatnonzero(distance > limit)
    for sample in far[np.argsort(-distance[far], kind="stable")].tolist():
        corners = improver.cells[face[sample]]
        nearest = int(corners[np.linalg.norm(state.x[corners] - points[sample], axis=1).argmin()])
        around = np.flatnonzero((improver.cells == nearest).any(axis=1))
        beside = set(improver.cells[around].ravel().tolist())
        if improver.constraints.kind[nearest] == ON_SURFACE and not beside & taken:
            taken.add(nearest)
            x[nearest] = points[sample]
            farthest[around] = np.maximum(farthest[around], (1.0 - LEAST_GAIN) * distance[sample])
    return x, farthest

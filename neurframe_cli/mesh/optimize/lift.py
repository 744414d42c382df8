"""The worst hexes made better, for which those around them may lose a little.

The corner energy of a mesh is a sum over all its corners: a few poor ones weigh little in it, and the edge lengths that
it asks for as well may be what makes them poor.  Here only hexes near poor ones move, and the targets are the lengths
that their edges have: the columns of S are then unit vectors, and each corner's energy is D^(-2/3), a function of its
scaled Jacobian D alone, to first order.  A high power of it is nearly the worst corner's.  The targets follow the edges
from round to round, but not far from what smoothing wants: a hex with two faces on one rounded edge would become a
chamfer.

Where that does not help, a corner of a hex is held flat by a feature curve that runs along two of its edges, or by two
curves: these let go of its vertex, one corner after the other, only for what a hex gains by it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from neurframe_cli.mesh.arrays import Bools, Floats, Ints, Surface
from neurframe_cli.mesh.optimize.cell_kind import HEXES
from neurframe_cli.mesh.optimize.constraints import ON_CURVE
from neurframe_cli.mesh.optimize.corner_energy import CornerEnergy, EnergyWeights
from neurframe_cli.mesh.optimize.lbfgs import LbfgsOptions, minimise
from neurframe_cli.mesh.optimize.let_go import let_go
from neurframe_cli.mesh.optimize.near_surface import NearSurface, Placed

GOOD = 0.5  # scaled Jacobian; better hexes are left alone
BAND = 0.15  # above the worst one: what is lifted at once
# rings of hexes that move with poor ones, power of a corner's energy, L-BFGS iterations: the next where one helps no
# more; short steps where long ones end too far from the surface
WAYS = ((2, 8.0, 20), (1, 16.0, 20), (3, 16.0, 20), (1, 16.0, 3))
ROUNDS = 16  # at most
STRETCH = 2.0  # times the lengths that smoothing wants: targets beyond would let a corner open by a huge hex
LEAST_GAIN = 2e-3  # of the worst scaled Jacobian in a round
WORTH_A_FEATURE = 0.25  # worst scaled Jacobian, below which features let go
FEATURES_GAIN = 0.03  # of the worst one, for that
RELEASES = 4
# of the limit of the distance: hexes all at it may be beyond it by other samples
CLOSER = 0.8


@dataclass(frozen=True)
class Lifted:
    """The mesh, and how many of its vertices features have let go of."""

    placed: Placed
    released: int


def lifted(near: NearSurface, placed: Placed, surface: Surface, may_release: bool) -> Lifted:
    """Hexes whose worst ones are better, no face getting farther away than 0.8 of the limit, or than it was;
    `may_release`: features may let go of the vertices of poor corners.  A mesh that is of no use so far from the
    surface stays as it is."""
    if placed.away > near.useless_beyond:
        return Lifted(placed, 0)
    near = replace(near, limit=CLOSER * near.limit)
    placed = _raised(near, placed)
    released = 0
    for _ in range(RELEASES if may_release else 0):
        if placed.worst >= WORTH_A_FEATURE:
            break
        held = _held_at_poor_corners(near, placed)
        if len(held) == 0:
            break
        free = near.constrained(let_go(near.improver.constraints, surface, held))
        better = _raised(free, placed)
        if better.worst < placed.worst + FEATURES_GAIN:
            break
        near, placed, released = free, better, released + len(held)
    return Lifted(placed, released)


def _raised(near: NearSurface, placed: Placed) -> Placed:
    """Rounds until the worst hex gains nothing more, however many move with it."""
    idle = 0
    for _ in range(ROUNDS):
        poor = placed.state.quality < _aim(placed)
        if not poor.any() or idle == len(WAYS):
            break
        better = near.moved(placed, _goal(near, placed, poor, *WAYS[idle]))
        idle = 0 if better.worst > placed.worst + LEAST_GAIN else idle + 1
        placed = better
    return placed


def _aim(placed: Placed) -> float:
    return min(GOOD, placed.worst + BAND)


def _goal(near: NearSurface, placed: Placed, poor: Bools, rings: int, power: float, steps: int) -> Floats:
    """Positions (n,3) with better `poor` hexes (c,), for which so many rings of hexes round them move, too; a vertex
    that is away from its place stays as far away."""
    x, constraints = placed.state.x, near.improver.constraints
    moving, energy = _energy_around(near, placed, poor, rings)
    foot = constraints.project(x)

    def held(y: Floats) -> tuple[float, Floats]:
        value, gradient = energy.evaluate(y, None, EnergyWeights(0.0, power, 0.0))
        gradient = constraints.tangential(gradient, foot.directions)
        return value, np.where(moving, gradient, 0.0)

    new = minimise(held, x, energy.scale, LbfgsOptions(iterations=steps))[0]
    return np.asarray(np.where(moving, constraints.project(new).points + x - foot.points, x))


def _energy_around(near: NearSurface, placed: Placed, poor: Bools, rings: int) -> tuple[Bools, CornerEnergy]:
    """The vertices (n,1) that move, and the energy of all hexes that have one, whose targets are the lengths of their
    edges, or near those that smoothing wants."""
    H, x = near.improver.cells, placed.state.x
    chosen = poor
    for _ in range(rings):
        chosen = np.asarray(np.isin(H, H[chosen]).any(axis=1))
    moving = np.zeros(len(x), bool)
    moving[H[chosen]] = True
    near_by = np.flatnonzero(moving[H].any(axis=1))
    corners = H[near_by][:, HEXES.corners].reshape(-1, 4)
    lengths = np.linalg.norm(x[corners[:, 1:]] - x[corners[:, :1]], axis=2)
    wanted = near.improver.energy.lengths.reshape(len(H), -1, 3)[near_by].reshape(-1, 3)
    targets = np.clip(lengths, wanted / STRETCH, wanted * STRETCH)
    return moving[:, None], CornerEnergy(len(x), corners[:, 0], corners[:, 1:], targets)


def _held_at_poor_corners(near: NearSurface, placed: Placed) -> Ints:
    """The vertices (k,) on features at which hexes have their poor corners."""
    improver = near.improver
    count = len(HEXES.corners)
    hexes = np.flatnonzero(placed.state.quality < min(_aim(placed), WORTH_A_FEATURE))
    corners = (hexes[:, None] * count + np.arange(count)).ravel()
    quality = improver.energy.scaled_jacobians(placed.state.x, None, corners)
    vertices = improver.cells[:, HEXES.corners[:, 0]].ravel()[corners[quality < WORTH_A_FEATURE]]
    vertices = np.unique(vertices)
    return np.asarray(vertices[improver.constraints.kind[vertices] >= ON_CURVE])

"""Vertices that soft constraints left a little off come to their places, but for those that would make a hex poor."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from smooth_shapes import boundary_quads, cube_hexes

from neurframe_cli.mesh.optimize.cell_kind import HEXES
from neurframe_cli.mesh.optimize.classify import classify
from neurframe_cli.mesh.optimize.constraints import ON_CURVE, Constraints
from neurframe_cli.mesh.optimize.distance_probe import BothDiagonals
from neurframe_cli.mesh.optimize.improve import ImproveOptions, Improver
from neurframe_cli.mesh.optimize.near_surface import NearSurface, Placed
from neurframe_cli.mesh.optimize.settle import SHARE, WORTH, settled


def shrunken_cube(limit: float, corner_at: float | None = None) -> tuple[NearSurface, int]:
    """A cube of 6³ hexes, everywhere two per cent too small, with poor ones round its middle; and the vertex of one
    corner, whose place is `corner_at` along the diagonal if that is given."""
    shape = cube_hexes(6)
    faces = boundary_quads(shape.cells)
    held = classify(shape.V, faces, shape.surface, shape.features, solid=True).constraints
    corner = int(np.argmin(np.linalg.norm(shape.V, axis=1)))
    pins = held.pins.copy()
    if corner_at is not None:
        pins[corner] = corner_at
    V = 0.5 + 0.98 * (shape.V - 0.5)
    V[int(np.argmin(np.linalg.norm(V - 0.5, axis=1)))] += (
        0.27 / 6
    )  # a third of an edge along all three would be flat
    constraints = Constraints(held.kind, pins, held.tracks)
    improver = Improver(V, shape.cells, HEXES, constraints, None, ImproveOptions())
    probe = BothDiagonals(faces, shape.surface, 2000, np.random.default_rng(0))
    return NearSurface(improver, probe, limit, useless_beyond=limit), corner


def test_all_vertices_come_to_their_places_where_nothing_is_in_the_way() -> None:
    near, _ = shrunken_cube(limit=1.0)
    first = near.placed(near.improver.first)
    assert near.on_features(first) == 0.0
    made = settled(near, first, alone=True)
    assert near.on_features(made) == 1.0
    assert made.away < 1e-9


def test_one_vertex_that_would_make_a_hex_poor_stops_none_of_its_neighbours() -> None:
    near, corner = shrunken_cube(limit=1.0, corner_at=0.3)  # inside the second hex along the diagonal
    first = near.placed(near.improver.first)
    made = settled(near, first, alone=True)
    assert made.worst >= max(WORTH, SHARE * first.worst)
    held = np.flatnonzero(near.improver.constraints.kind >= ON_CURVE)
    goal = near.improver.constraints.project(made.state.x).points
    off = np.linalg.norm(goal - made.state.x, axis=1)
    assert off[corner] > 0.1
    assert off[np.setdiff1d(held, corner)].max() < 1e-3 / 6
    assert near.on_features(settled(near, first, alone=False)) < near.on_features(made)


def test_faces_keep_the_limit_of_the_distance() -> None:
    near, corner = shrunken_cube(
        limit=0.05, corner_at=0.1
    )  # which alone takes the corner 0.17 off the surface
    made = settled(near, near.placed(near.improver.first), alone=True)
    assert made.away <= 0.05
    assert np.linalg.norm(made.state.x[corner]) < 0.1


def made_up(near: NearSurface, worst: float, on_features: float) -> Placed:
    """The mesh with so many of the vertices that features hold in place, and a worst hex as if it were so poor."""
    first = near.placed(near.improver.first)
    held = np.flatnonzero(near.improver.constraints.kind >= ON_CURVE)
    there = held[: round(on_features * len(held))]
    x = first.state.x.copy()
    x[there] = near.improver.constraints.project(x).points[there]
    quality = np.full(len(first.state.quality), 0.9)
    quality[0] = worst
    return replace(first, state=replace(first.state, x=x, quality=quality))


def test_a_poor_hex_weighs_more_than_a_few_features_and_good_enough_is_enough() -> None:
    near, _ = shrunken_cube(limit=1.0)
    few = near.worth(made_up(near, worst=0.3, on_features=0.5))
    assert few > near.worth(made_up(near, worst=0.2, on_features=0.9))
    assert few < near.worth(made_up(near, worst=0.29, on_features=0.9))
    assert few < near.worth(made_up(near, worst=0.3, on_features=0.6))
    assert few == near.worth(made_up(near, worst=0.6, on_features=0.5))


def test_nothing_makes_up_for_being_too_far_from_the_surface() -> None:
    near, _ = shrunken_cube(limit=1.0)
    good, poor = made_up(near, worst=0.3, on_features=1.0), made_up(near, worst=0.1, on_features=0.1)
    away = good.away
    for limit, useless_beyond in ((0.9 * away, 1.1 * away), (0.9 * away, 0.9 * away)):
        beyond = replace(near, limit=limit, useless_beyond=useless_beyond)
        assert near.worth(poor) > beyond.worth(good)

"""The worst hexes made better, at the cost of those around them and of features that hold their corners flat."""

from __future__ import annotations

import numpy as np
from smooth_shapes import Shape, boundary_quads, cube_hexes, sphere_hexes

from neurframe_cli.mesh.optimize.cell_kind import HEXES
from neurframe_cli.mesh.optimize.classify import classify
from neurframe_cli.mesh.optimize.constraints import ON_CURVE, PINNED, Constraints, Track
from neurframe_cli.mesh.optimize.distance_probe import BothDiagonals
from neurframe_cli.mesh.optimize.improve import ImproveOptions, Improver
from neurframe_cli.mesh.optimize.lift import GOOD, WORTH_A_FEATURE, lifted
from neurframe_cli.mesh.optimize.near_surface import NearSurface
from neurframe_cli.mesh.optimize.simplex_tree import SimplexTree


def near_surface(shape: Shape, limit: float, useless_beyond: float | None = None) -> NearSurface:
    faces = boundary_quads(shape.cells)
    constraints = classify(shape.V, faces, shape.surface, shape.features, solid=True).constraints
    improver = Improver(shape.V, shape.cells, HEXES, constraints, None, ImproveOptions())
    probe = BothDiagonals(faces, shape.surface, 2000, np.random.default_rng(0))
    return NearSurface(
        improver, probe, limit, useless_beyond=limit if useless_beyond is None else useless_beyond
    )


def with_a_feature_along_two_edges(shape: Shape, limit: float) -> NearSurface:
    """A cube, but a straight line on its top holds a vertex between its pinned neighbours in one quad.  It begins a
    little beside the line: the quad's corner there is all but flat wherever the vertex slides."""

    def at(x: float, y: float) -> int:
        return int(np.argmin(np.linalg.norm(shape.V - [x, y, 1.0], axis=1)))

    left, corner, right = at(0.25, 0.5), at(0.5, 0.5), at(0.5, 0.25)
    V = shape.V.copy()
    V[corner] = 0.52 * (V[left] + V[right]) - 0.04 * np.array([0.25, 0.25, 1.0])
    V[corner, 2] = 1.0
    near = near_surface(Shape(V, shape.cells, shape.surface, shape.features), limit)
    held = near.improver.constraints
    kind = held.kind.copy()
    kind[[left, corner, right]] = PINNED, ON_CURVE, PINNED
    pins = held.pins.copy()
    pins[[left, right]] = V[[left, right]]
    tracks = [Track(t.tree, np.setdiff1d(t.vertices, [left, corner, right])) for t in held.tracks]
    line = SimplexTree(V[[left, right]], np.array([[0, 1]]))
    tracks.append(Track(line, np.array([corner])))
    return near.constrained(Constraints(kind, pins, tracks))


def test_poor_hexes_get_better_and_those_far_from_them_stay() -> None:
    """A cube of 8³ hexes, one inner vertex moved until its hexes are almost flat."""
    shape = cube_hexes(8)
    middle = int(np.argmin(np.linalg.norm(shape.V - 0.5, axis=1)))
    V = shape.V.copy()
    V[middle] += 0.31 / 8  # a third of an edge along all three of them would be flat
    near = near_surface(Shape(V, shape.cells, shape.surface, shape.features), limit=1e-3)
    first = near.placed(near.improver.first)
    assert first.worst < 0.15
    made = lifted(near, first, shape.surface, may_release=True)
    assert made.placed.worst > GOOD
    assert made.released == 0
    moved = np.flatnonzero((made.placed.state.x != V).any(axis=1))
    assert np.abs(V[moved] - V[middle]).max() < 0.5  # four edges of the grid
    on_boundary = np.unique(boundary_quads(shape.cells))
    np.testing.assert_array_equal(made.placed.state.x[on_boundary], V[on_boundary])


def test_features_let_go_of_a_corner_that_they_hold_flat() -> None:
    shape = cube_hexes(4, surface_n=4)
    near = with_a_feature_along_two_edges(shape, limit=1e-3)
    first = near.placed(near.improver.first)
    assert 0.0 < first.worst < 0.15
    held = lifted(near, first, shape.surface, may_release=False)
    assert held.released == 0
    assert held.placed.worst < WORTH_A_FEATURE
    freed = lifted(near, first, shape.surface, may_release=True)
    assert freed.released == 1
    assert freed.placed.worst > GOOD
    assert freed.placed.away <= 1e-3


def test_a_mesh_beyond_the_limit_of_the_distance_stays_as_it_is() -> None:
    shape = sphere_hexes(4)
    away = near_surface(shape, limit=1.0).placed(near_surface(shape, limit=1.0).improver.first).away
    near = near_surface(shape, limit=away / 2.0)
    first = near.placed(near.improver.first)
    assert first.worst < GOOD
    made = lifted(near, first, shape.surface, may_release=True)
    assert made.placed is first
    assert made.released == 0
    # where the limit leaves room, hexes are better, and all faces within it
    near = near_surface(shape, limit=1.5 * away)
    made = lifted(near, first, shape.surface, may_release=True)
    assert made.placed.worst > first.worst + 0.05
    assert made.placed.away <= 1.5 * away


def test_a_mesh_beyond_the_limit_that_is_of_use_is_lifted_and_gets_no_farther() -> None:
    shape = sphere_hexes(4)
    away = near_surface(shape, limit=1.0).placed(near_surface(shape, limit=1.0).improver.first).away
    near = near_surface(shape, limit=away / 1.1, useless_beyond=away * 1.01)
    first = near.placed(near.improver.first)
    made = lifted(near, first, shape.surface, may_release=True)
    assert made.placed.worst > first.worst + 0.02
    assert made.placed.away <= away

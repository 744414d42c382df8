"""Parts of the smoother against closed forms: closest points, energy, L-BFGS, feature matching."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from smooth_shapes import cube_hexes, cylinder_surface, disk_quads, grid_quads, jitter, sphere_hexes

from neurframe_cli.errors import StageError
from neurframe_cli.mesh.arrays import Features, Floats, Surface
from neurframe_cli.mesh.features import features_by_angle
from neurframe_cli.mesh.optimize import corner_energy
from neurframe_cli.mesh.optimize.approach import NEARLY, SLIDING, approach, retreat
from neurframe_cli.mesh.optimize.cell_kind import HEXES, QUADS, CellKind, target_lengths
from neurframe_cli.mesh.optimize.classify import classify
from neurframe_cli.mesh.optimize.constraints import ON_CURVE, ON_SURFACE, PINNED
from neurframe_cli.mesh.optimize.corner_energy import CornerEnergy, EnergyWeights
from neurframe_cli.mesh.optimize.distance_probe import BothDiagonals, DistanceProbe
from neurframe_cli.mesh.optimize.feature_curves import FeatureCurves, feature_curves
from neurframe_cli.mesh.optimize.guard import least_allowed
from neurframe_cli.mesh.optimize.improve import ImproveOptions, Improver
from neurframe_cli.mesh.optimize.lbfgs import LbfgsOptions, minimise
from neurframe_cli.mesh.optimize.let_go import let_go
from neurframe_cli.mesh.optimize.match_curves import match_features
from neurframe_cli.mesh.optimize.patches import components_cut_by
from neurframe_cli.mesh.optimize.simplex_tree import SimplexTree
from neurframe_cli.mesh.optimize.smooth import SmoothOptions
from neurframe_cli.mesh.quality.polygons import triangulated, unique_edges
from neurframe_cli.stages.smooth_hexes import boundary_quads, smooth_hexes


def test_closest_points_on_segments() -> None:
    V = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0]])
    tree = SimplexTree(V, np.array([[0, 1], [1, 2]]))
    foot = tree.closest(np.array([[0.25, -1.0, 0], [2, 0.5, 0], [1.5, -0.5, 0]]))
    np.testing.assert_allclose(foot.points, [[0.25, 0, 0], [1, 0.5, 0], [1, 0, 0]])
    diagonal = np.array([1.0, 1.0, 0.0]) / np.sqrt(2)
    np.testing.assert_allclose(foot.directions[2], diagonal, atol=1e-12)  # between both segments' tangents


def test_closest_points_interpolate_normals() -> None:
    surface = cylinder_surface(24)
    side = surface.F[: 2 * 24]
    rng = np.random.default_rng(0)
    P = rng.normal(size=(50, 3))
    P[:, 2] = rng.uniform(0.1, 1.9, 50)
    foot = SimplexTree(surface.V, side).closest(P)
    outward = foot.points[:, :2] / np.linalg.norm(foot.points[:, :2], axis=1, keepdims=True)
    # exact at the vertices; linear interpolation over 15 degrees is off by less than a thousandth
    np.testing.assert_allclose(foot.directions[:, :2], outward, atol=1e-3)
    np.testing.assert_allclose(np.linalg.norm(foot.directions, axis=1), 1.0)


def test_degenerate_triangles_have_finite_weights() -> None:
    V = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]])
    foot = SimplexTree(V, np.array([[0, 1, 2]])).closest(np.array([[0.5, 1.0, 0]]))
    assert np.isfinite(foot.weights).all()
    assert np.isfinite(foot.directions).all()


@pytest.mark.parametrize("kind", [QUADS, HEXES])
@pytest.mark.parametrize("weights", [EnergyWeights(0.1, 1.0, 0.0), EnergyWeights(0.3, 3.0, 0.2)])
def test_gradient_of_the_energy(kind: CellKind, weights: EnergyWeights) -> None:
    """Against central differences, whose error is about 1e-9 at this step."""
    X, cells, normals = _small_mesh(kind)
    lengths = target_lengths(X, cells, kind, 0.5, rounds=2)
    corners = cells[:, kind.corners].reshape(-1, kind.corners.shape[1])
    energy = CornerEnergy(len(X), corners[:, 0], corners[:, 1:], lengths.reshape(len(corners), -1))
    rng = np.random.default_rng(1)
    _, gradient = energy.evaluate(X, normals, weights)
    for _ in range(5):
        direction, step = rng.normal(size=X.shape), 1e-6
        ahead = energy.evaluate(X + step * direction, normals, weights)[0]
        behind = energy.evaluate(X - step * direction, normals, weights)[0]
        assert np.vdot(gradient, direction) == pytest.approx((ahead - behind) / (2 * step), rel=1e-6)


def _small_mesh(kind: CellKind) -> tuple[Floats, np.ndarray, Floats | None]:
    if kind is HEXES:
        shape = cube_hexes(2)
        return jitter(shape.V, 0.05, 2), shape.cells, None
    Q = grid_quads(3, 3)[:, ::-1].copy()
    i, j = np.divmod(np.arange(16), 4)
    X = np.stack([i, j, np.zeros(16)], axis=1).astype(float)
    normals = np.tile([0.0, 0.0, 1.0], (4 * len(Q), 1))
    return jitter(X, 0.1, 2), Q, normals


def test_the_ideal_corner_has_energy_one() -> None:
    shape = cube_hexes(2)
    corners = shape.cells[:, HEXES.corners].reshape(-1, 4)
    energy = CornerEnergy(len(shape.V), corners[:, 0], corners[:, 1:], np.full((len(corners), 3), 0.5))
    value, gradient = energy.evaluate(shape.V, None, EnergyWeights())
    assert value == pytest.approx(len(corners))
    np.testing.assert_allclose(gradient, 0.0, atol=1e-12)
    assert energy.evaluate(shape.V * [1, 1, -1], None, EnergyWeights())[0] == np.inf


def test_lbfgs_reaches_the_minimum_of_rosenbrock() -> None:
    def rosenbrock(x: Floats) -> tuple[float, Floats]:
        a, b = 1 - x[:, 0], x[:, 1] - x[:, 0] ** 2
        gradient = np.stack([-2 * a - 400 * x[:, 0] * b, 200 * b, 0 * a], axis=1)
        return float((a**2 + 100 * b**2).sum()), gradient

    start = np.array([[-1.2, 1.0, 5.0]])
    found, decrease = minimise(
        rosenbrock, start, np.ones((1, 1)), LbfgsOptions(iterations=200, tolerance=0.0)
    )
    assert decrease == pytest.approx(rosenbrock(start)[0], abs=1e-9)  # the minimum is zero
    np.testing.assert_allclose(found, [[1.0, 1.0, 5.0]], atol=1e-6)


def test_lbfgs_stays_where_the_energy_is_finite() -> None:
    def barrier(x: Floats) -> tuple[float, Floats]:
        if x.min() <= 0.0:
            return np.inf, np.zeros_like(x)
        return float((x - np.log(x)).sum()), 1 - 1 / x

    found, _ = minimise(barrier, np.full((4, 3), 1e-3), np.ones((4, 1)), LbfgsOptions(100, tolerance=0.0))
    np.testing.assert_allclose(found, 1.0, atol=1e-6)


def test_feature_curves_of_a_cylinder_and_of_a_plate() -> None:
    surface = cylinder_surface(24)
    curves = feature_curves(surface, features_by_angle(surface.V, surface.F, 45.0))
    assert [len(c) for c in curves.curves] == [25, 25]
    assert len(curves.corners) == 0
    assert not curves.on_boundary.any()
    i, j = np.divmod(np.arange(16), 4)
    plate = Surface(np.stack([i, j, 0 * i], axis=1).astype(float), triangulated(grid_quads(3, 3)))
    outline = feature_curves(plate, Features())
    assert sorted(outline.corners.tolist()) == [0, 3, 12, 15]
    assert len(outline.curves) == 4
    assert outline.on_boundary.all()


def test_two_curves_closer_than_an_edge_get_paths_of_their_own() -> None:
    """Two parallel curves 0.6 edges apart: the vertices in between are nearer to the first for one of the rows."""
    i, j = np.divmod(np.arange(7 * 11), 11)
    X = np.stack([j, i, 0 * i], axis=1).astype(float)
    X[:, 1] = np.where(i == 3, 3.1, np.where(i == 4, 3.6, X[:, 1]))
    V = np.array([[0.0, 3.0, 0], [10, 3.0, 0], [0, 3.6, 0], [10, 3.6, 0]])
    curves = FeatureCurves(
        (np.array([0, 1]), np.array([2, 3])), np.zeros(2, bool), np.arange(4), np.zeros(4, bool)
    )
    matched = match_features(V, curves, X, grid_quads(6, 10))
    paths = {m.curve: m.path for m in matched.curves}
    np.testing.assert_array_equal(paths[0], 3 * 11 + np.arange(11))
    np.testing.assert_array_equal(paths[1], 4 * 11 + np.arange(11))


def test_a_hairpin_is_followed_to_its_end() -> None:
    """The ends of the curve are one edge apart: the short cut along that edge is no match."""
    i, j = np.divmod(np.arange(5 * 9), 9)
    X = np.stack([j, i, 0 * i], axis=1).astype(float)
    V = np.array([[0.0, 1, 0], [7, 1, 0], [7, 2, 0], [0, 2, 0]])
    curves = FeatureCurves((np.arange(4),), np.zeros(1, bool), np.array([0, 3]), np.zeros(2, bool))
    path = match_features(V, curves, X, grid_quads(4, 8)).curves[0].path
    np.testing.assert_array_equal(path, [*range(9, 17), *range(25, 17, -1)])


def straight_curves(ends: list[tuple[int, int]], corners: int) -> FeatureCurves:
    curves = tuple(np.array(pair) for pair in ends)
    return FeatureCurves(curves, np.zeros(len(curves), bool), np.arange(corners), np.zeros(corners, bool))


def test_curves_that_want_the_same_edges_make_room_for_each_other() -> None:
    """Three curves within half an edge of one row of vertices, whose ends are on three rows: alone each would take the
    row in the middle, whoever came first would keep the others from it."""
    i, j = np.divmod(np.arange(7 * 13), 13)
    X = np.stack([j, i, 0 * i], axis=1).astype(float)
    V = np.array([[0.0, 2, 0], [12, 2, 0], [0, 3, 0], [12, 3, 0], [0, 4, 0], [12, 4, 0]])
    bent = np.array([[1.0, 2.8, 0], [11, 2.8, 0], [1.0, 3.2, 0], [11, 3.2, 0]])
    curves = FeatureCurves(
        (np.array([0, 6, 7, 1]), np.array([2, 3]), np.array([4, 8, 9, 5])),
        np.zeros(3, bool),
        np.arange(6),
        np.zeros(6, bool),
    )
    matched = match_features(np.concatenate([V, bent]), curves, X, grid_quads(6, 12))
    assert [m.whole for m in matched.curves] == [True, True, True]
    paths = [set(m.path.tolist()) for m in matched.curves]
    assert sum(map(len, paths)) == len(set.union(*paths))


def test_a_curve_that_finds_no_path_is_followed_from_its_ends() -> None:
    """A wall of longer curves across it, which are on every column of vertices that it could pass between."""
    i, j = np.divmod(np.arange(9 * 13), 13)
    X = np.stack([j, i, 0 * i], axis=1).astype(float)
    V = np.array([[0.0, 4, 0], [12, 4, 0], [6, 0, 0], [6, 8, 0]])
    longer = straight_curves([(0, 1), (2, 3)], 4)
    matched = match_features(V * [1, 2, 1], longer, X * [1, 2, 1], grid_quads(8, 12))
    across = [m for m in matched.curves if m.curve == 0]
    assert [m.whole for m in matched.curves if m.curve == 1] == [True]
    assert [m.whole for m in across] == [False, False]
    covered = np.concatenate([X[m.path, 0] for m in across])
    assert sorted(covered) == [0, 1, 2, 3, 4, 5, 7, 8, 9, 10, 11, 12]
    assert all((X[m.path, 1] == 4).all() for m in across)


def test_a_closed_curve_is_matched_all_the_way_round() -> None:
    V2, Q = disk_quads(4, 3)
    X = np.column_stack([V2, np.zeros(len(V2))])
    angle = 2 * np.pi * np.arange(41) / 40
    V = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)[:40]
    loop = np.append(np.arange(40), 0)
    curves = FeatureCurves((loop,), np.zeros(1, bool), np.zeros(0, np.int64), np.zeros(0, bool))
    path = match_features(V, curves, X, Q).curves[0].path
    assert path[0] == path[-1]
    rim = np.flatnonzero(np.linalg.norm(V2, axis=1) > 1 - 1e-9)
    np.testing.assert_array_equal(np.sort(path[:-1]), rim)


def test_an_edge_goes_to_the_curve_that_runs_along_it() -> None:
    """Four curves end in the corner of a cube, whose vertex has three edges: the shortest one lies across the quads."""
    shape = cube_hexes(6)
    V = np.concatenate([shape.surface.V, [[0.5, 0.45, 1.0]]])
    outline = feature_curves(shape.surface, shape.features)
    corner = int(np.flatnonzero((V == [0.0, 0.0, 1.0]).all(axis=1))[0])
    curves = FeatureCurves(
        (np.array([corner, len(V) - 1]), *outline.curves),
        np.zeros(len(outline.curves) + 1, bool),
        np.append(outline.corners, len(V) - 1),
        np.zeros(len(outline.corners) + 1, bool),
    )
    matched = match_features(V, curves, shape.V, boundary_quads(shape.cells))
    paths = {m.curve: m for m in matched.curves}
    assert sorted(paths) == list(range(13))
    for number, curve in enumerate(outline.curves, 1):
        along = np.ptp(V[curve], axis=0) > 0
        assert paths[number].whole
        np.testing.assert_array_equal(np.ptp(shape.V[paths[number].path], axis=0) > 0, along)
    assert not paths[0].whole
    assert (shape.V[paths[0].path[0]] != V[corner]).any()


def test_a_curve_away_from_the_mesh_is_not_matched() -> None:
    i, j = np.divmod(np.arange(16), 4)
    X = np.stack([j, i, 0 * i], axis=1).astype(float)
    V = np.array([[0.0, 0, 5], [3, 0, 5]])
    curves = FeatureCurves((np.array([0, 1]),), np.zeros(1, bool), np.arange(2), np.zeros(2, bool))
    matched = match_features(V, curves, X, grid_quads(3, 3))
    assert matched.curves == ()
    assert len(matched.corners) == 0


def test_components_between_cuts() -> None:
    Q = grid_quads(4, 4)
    cut = np.stack([10 + np.arange(4), 11 + np.arange(4)], axis=1)  # the middle line
    labels = components_cut_by(Q, cut)
    assert len(np.unique(labels)) == 2
    assert (labels[:8] == labels[0]).all()
    assert (labels[8:] == labels[8]).all()
    assert len(np.unique(components_cut_by(Q, cut[:3]))) == 1  # a dangling cut separates nothing
    assert len(unique_edges(Q)[0]) == 40


def test_bad_hexes_open_within_the_limit_of_distance() -> None:
    """A cube of hexes blown up to a ball: flat along the cube's edges as long as all vertices are on the sphere."""
    shape = sphere_hexes(4)
    faces = boundary_quads(shape.cells)
    constraints = classify(shape.V, faces, shape.surface, shape.features, solid=True, voids=True).constraints
    improver = Improver(shape.V, shape.cells, HEXES, constraints, None, ImproveOptions())
    probe = DistanceProbe(faces, shape.surface, 2000, np.random.default_rng(0))

    def excess(x: Floats, limit: float) -> float:
        return float(np.maximum(probe.measure(x).by_face - limit, 0.0).sum())

    found = retreat(improver, shape.V, lambda x: excess(x, 0.07))
    assert found is not None
    assert excess(found.x, 0.07) == 0.0
    assert improver.first.quality.min() < 0.25
    assert found.quality.min() > 0.4
    # no four hexes across a ball are that near
    assert retreat(improver, shape.V, lambda x: excess(x, 0.01)) is None


def test_tangled_hexes_come_near_their_surface_untangled() -> None:
    """A ball of hexes, each vertex off by up to a third of an edge."""
    shape = sphere_hexes(4)
    tangled = jitter(shape.V, 0.15, seed=5)
    faces = boundary_quads(shape.cells)
    constraints = classify(tangled, faces, shape.surface, shape.features, solid=True).constraints
    improver = Improver(tangled, shape.cells, HEXES, constraints, None, ImproveOptions())
    probe = BothDiagonals(faces, shape.surface, 2000, np.random.default_rng(0))

    def distance(x: Floats) -> float:
        return float(probe.measure(x).by_face.max())

    assert improver.first.inverted > 0
    limit = 1.2 * distance(shape.V)
    found = approach(improver, tangled, tangled, (SLIDING, 0.0), lambda x: max(0.0, distance(x) - limit))
    assert found is not None
    assert found.inverted == 0
    assert distance(found.x) <= limit
    # where no state is within the limit, a sound one all the same
    nearest = approach(improver, tangled, tangled, (SLIDING, 0.0), distance)
    assert nearest is not None
    assert nearest.inverted == 0
    assert distance(nearest.x) <= NEARLY * distance(found.x)


def test_a_bent_quad_is_as_far_away_as_the_worse_of_its_triangulations() -> None:
    """A unit quad with one corner lifted, against the two triangles of its first diagonal."""
    height = 0.2
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, height], [0, 1, 0]])
    quad = np.array([[0, 1, 2, 3]])
    same = Surface(corners, np.array([[0, 1, 2], [0, 2, 3]]))
    one = DistanceProbe(quad, same, 500, np.random.default_rng(0)).measure(corners).by_face
    both = BothDiagonals(quad, same, 500, np.random.default_rng(0)).measure(corners).by_face
    np.testing.assert_allclose(one, [0.0], atol=1e-12)
    # from the middle of the second diagonal straight to either triangle, which lies h/2 above it and has slope h
    np.testing.assert_allclose(both, [height / 2 / np.hypot(1, height)], rtol=1e-9)


def test_what_cells_may_fall_to() -> None:
    np.testing.assert_array_equal(least_allowed(np.array([0.5, 0.2, 0.9])), [0.2, 0.2, 0.2])
    np.testing.assert_array_equal(least_allowed(np.array([0.5, -0.2, 1e-4, -0.1])), [1e-3, -0.2, 1e-4, -0.2])


def test_features_let_go_of_the_hexes_that_they_flatten() -> None:
    shape = cube_hexes(3)
    faces = boundary_quads(shape.cells)
    constraints = classify(shape.V, faces, shape.surface, shape.features, solid=True).constraints
    corner = int((shape.V == 0.0).all(axis=1).argmax())
    cells = shape.cells[(shape.cells == corner).any(axis=1)]
    free = let_go(constraints, shape.surface, cells)
    held = np.isin(constraints.kind, [ON_CURVE, PINNED])
    inside = np.isin(np.arange(len(shape.V)), cells)
    assert held[corner]
    np.testing.assert_array_equal(np.isin(free.kind, [ON_CURVE, PINNED]), held & ~inside)
    assert (free.kind[held & inside] == ON_SURFACE).all()
    # what was let go slides on the surface, what was not stays where it was held
    away = shape.V + 0.1
    np.testing.assert_allclose(free.project(away).points[~inside], constraints.project(away).points[~inside])
    on_surface = free.project(away).points[held & inside]
    np.testing.assert_allclose(np.abs(on_surface - 0.5).max(axis=1), 0.5)


def test_the_number_of_threads_does_not_change_what_lbfgs_finds() -> None:
    """More numbers than a single thread of BLAS takes: their inner products are not those of BLAS."""
    program = (
        "import numpy as np\n"
        "from neurframe_cli.mesh.optimize.lbfgs import LbfgsOptions, minimise\n"
        "rng = np.random.default_rng(0)\n"
        "centre, stiffness = rng.normal(size=(2, 40_000, 3)) ** 2\n"
        "energy = lambda x: (float((stiffness * (x - centre) ** 2).sum()), 2 * stiffness * (x - centre))\n"
        "found, _ = minimise(energy, np.zeros_like(centre), np.ones((40_000, 1)), LbfgsOptions(10))\n"
        "print(found.tobytes().hex()[:4000])"
    )
    results = {
        subprocess.run(
            [sys.executable, "-c", program],
            env=os.environ | {"OPENBLAS_NUM_THREADS": threads},
            capture_output=True,
            check=True,
            text=True,
        ).stdout
        for threads in ("1", "2", "4")
    }
    assert len(results) == 1


def test_vertices_do_not_settle_where_a_hex_gets_worse_than_the_worst_one_was() -> None:
    """Perfect hexes of a cube, and a surface whose top leans: near enough as they are."""
    shape = cube_hexes(3)
    leaning = shape.surface.V + [0.0, 0.0, 0.15] * (shape.surface.V[:, :1] * shape.surface.V[:, 2:])
    surface = Surface(leaning, shape.surface.F)
    options = SmoothOptions(hausdorff_limit=0.2)
    smoothed = smooth_hexes(shape.V, shape.cells, surface, shape.features, options, voids=False)
    assert smoothed.report.before.min_scaled_jacobian == pytest.approx(1.0)
    assert smoothed.report.after.min_scaled_jacobian >= smoothed.report.before.min_scaled_jacobian


def test_without_its_library_smoothing_says_what_is_missing(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(corner_energy, "LIBRARY", tmp_path / "libneurframe_smooth.so")
    with pytest.raises(StageError, match=r"libneurframe_smooth\.so cannot be loaded"):
        corner_energy.load_library()

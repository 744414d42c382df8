"""Smoothing of quads: closed-form meshes come back from disorder, constraints hold, nothing gets worse."""

from __future__ import annotations

import igl
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from smooth_shapes import Shape, bump_quads, cube_quads, jitter, patch_quads, sphere_quads, torus_quads

from neurframe_cli.errors import InvalidMesh
from neurframe_cli.mesh.arrays import Floats, Surface, silent
from neurframe_cli.mesh.features import features_from_edges
from neurframe_cli.mesh.optimize.improve import ImproveOptions
from neurframe_cli.mesh.optimize.smooth import SmoothedMesh, SmoothOptions
from neurframe_cli.mesh.quality.feature_recall import feature_recall
from neurframe_cli.mesh.quality.polygons import unique_edges
from neurframe_cli.mesh.quality.scaled_jacobian import quad_scaled_jacobians
from neurframe_cli.stages.smooth_quads import smooth_quads


def smooth(shape: Shape, V: Floats, options: SmoothOptions | None = None) -> SmoothedMesh:
    return smooth_quads(V, shape.cells, shape.surface, shape.features, options or SmoothOptions())


def worst(V: Floats, shape: Shape) -> float:
    return float(quad_scaled_jacobians(V, shape.cells).min())


def distance_to(surface: Surface, V: Floats) -> float:
    return float(np.sqrt(igl.point_mesh_squared_distance(V, surface.V, surface.F)[0].max()))


@pytest.mark.parametrize("amount", [0.02, 0.06])  # of a unit edge in 6: the second turns quads over
def test_a_jittered_cube_returns_to_its_grid(amount: float) -> None:
    shape = cube_quads(6)
    V = jitter(shape.V, amount, seed=1)
    result = smooth(shape, V)
    assert worst(result.V, shape) > 0.99
    # with isotropic targets the regular grid is the only minimiser; the optimiser stops within 2 % of an edge of it
    isotropic = SmoothOptions(ImproveOptions(anisotropy=0.0, gain=1e-6))
    np.testing.assert_allclose(smooth(shape, V, isotropic).V, shape.V, atol=0.02 / 6)


def test_features_of_a_cube_stay_sharp() -> None:
    shape = cube_quads(6)
    result = smooth(shape, jitter(shape.V, 0.03, seed=2))
    edges, _ = unique_edges(shape.cells)
    recall = feature_recall(shape.surface.V, shape.features.edges, result.V, edges, 0.001)
    assert recall == 1.0
    found = result.report.classification
    assert (found.matched_corners, found.corners) == (8, 8)
    assert (found.matched_curves, found.curves) == (12, 12)
    assert (found.on_curves, found.on_surface, found.free) == (12 * 5, 6 * 25, 0)


@pytest.mark.parametrize(("shape", "least"), [(torus_quads(30, 12), 0.98), (sphere_quads(8), 0.85)])
def test_quads_on_smooth_surfaces(shape: Shape, least: float) -> None:
    V = jitter(shape.V, 0.05, seed=3)
    assert worst(V, shape) < 0.4
    result = smooth(shape, V)
    # at the eight corners of a cubed sphere three quads meet: 120 degrees at best, sin = 0.866
    assert worst(result.V, shape) > least
    assert result.report.after.mean_scaled_jacobian > 0.97
    assert distance_to(shape.surface, result.V) < 1e-12


def test_open_boundaries_slide_on_themselves() -> None:
    shape = patch_quads(10)
    result = smooth(shape, jitter(shape.V, 0.02, seed=4))
    edges, use = unique_edges(shape.cells)
    rim = np.unique(edges[use == 1])
    outline = result.V[rim, :2]
    np.testing.assert_allclose(np.abs(outline - 0.5).max(axis=1), 0.5, atol=1e-12)
    for corner in ([0, 0], [0, 1], [1, 0], [1, 1]):
        assert np.abs(outline - corner).max(axis=1).min() < 1e-12
    assert worst(result.V, shape) > 0.99


@pytest.mark.parametrize("seed", range(4))
def test_the_worst_quad_never_gets_worse(seed: int) -> None:
    shape = torus_quads(10, 5)  # so coarse and so disturbed that little can be saved
    V = jitter(shape.V, 0.3, seed)
    result = smooth(shape, V, SmoothOptions(hausdorff_limit=0.0))
    report = result.report
    assert worst(result.V, shape) >= worst(V, shape) - 1e-12
    assert report.after.min_scaled_jacobian >= report.before.min_scaled_jacobian
    assert report.after.inverted <= report.before.inverted
    assert report.after.hausdorff <= report.before.hausdorff


def test_the_distance_limit_holds_vertices_back() -> None:
    shape = bump_quads()
    free = smooth(shape, shape.V, SmoothOptions(hausdorff_limit=1.0)).report
    limit = 0.2 * free.before.hausdorff + 0.8 * free.after.hausdorff
    held = smooth(shape, shape.V, SmoothOptions(hausdorff_limit=limit)).report
    assert free.after.hausdorff > 1.2 * free.before.hausdorff
    assert free.held_back == 0
    assert held.after.hausdorff <= limit
    assert 0 < held.held_back < len(shape.V)
    assert held.after.min_scaled_jacobian >= held.before.min_scaled_jacobian


def test_quads_are_moved_to_a_tip_that_they_pass_by() -> None:
    shape = patch_quads(10, 50)
    V = shape.surface.V.copy()
    V[:, 2] += 0.06 * np.exp(-((V[:, :2] - 0.55) ** 2).sum(axis=1) / 0.06**2)  # in the middle of a quad
    surface = Surface(V, shape.surface.F)
    X = jitter(shape.V, 0.04, seed=8)
    assert worst(X, shape) < 0.5  # a mesh that is better than that is left as good as it is
    free = smooth_quads(X, shape.cells, surface, shape.features, SmoothOptions(reach_limit=1.0))
    near = smooth_quads(X, shape.cells, surface, shape.features, SmoothOptions())
    assert near.report.after.hausdorff < 0.95 * free.report.after.hausdorff
    assert near.report.after.min_scaled_jacobian > 0.5


def test_creases_of_a_few_edges_hold_nothing() -> None:
    shape = torus_quads(30, 12)
    scratched = features_from_edges(shape.surface.V, shape.surface.F[:1, :2])
    result = smooth_quads(shape.V, shape.cells, shape.surface, scratched, SmoothOptions())
    assert result.report.classification.curves == 0


def test_the_end_of_a_crease_is_free_to_slide() -> None:
    shape = patch_quads(10, 20)
    V = shape.surface.V
    middle = np.flatnonzero((V[:, 1] == 0.5) & (V[:, 0] <= 0.6))
    line = features_from_edges(V, np.stack([middle[:-1], middle[1:]], axis=1))
    result = smooth_quads(shape.V, shape.cells, shape.surface, line, SmoothOptions())
    found = result.report.classification
    # the four corners of the patch, and both ends of the crease, of which the one on the outline is held
    assert (found.corners, found.matched_corners, found.matched_curves) == (6, 6, found.curves)
    assert found.on_curves == 40 - 4 - 1 + 6


def test_a_crease_that_the_quads_do_not_follow_lets_go_of_them() -> None:
    shape = patch_quads(10, 20)
    V = shape.surface.V.copy()
    # from (0.2, 0.5) to (0.8, 0.6): a path of edges has to take a step up, and all of its vertices lie on one line
    line = np.flatnonzero((V[:, 1] == 0.5) & (V[:, 0] >= 0.2) & (V[:, 0] <= 0.8))
    V[line, 1] += (V[line, 0] - 0.2) / 6.0
    crease = features_from_edges(V, np.stack([line[:-1], line[1:]], axis=1))
    X = jitter(shape.V, 0.06, seed=2)  # some quads turn over
    result = smooth_quads(X, shape.cells, Surface(V, shape.surface.F), crease, SmoothOptions())
    assert result.report.classification.on_curves > 40 - 4
    assert 0 < result.report.released <= 4  # of 8 on it
    assert worst(result.V, shape) > 0.8  # 0 where none is let go
    rim = (np.abs(shape.V[:, :2] - 0.5) == 0.5).any(axis=1)
    np.testing.assert_allclose(np.abs(result.V[rim, :2] - 0.5).max(axis=1), 0.5, atol=1e-12)


def test_a_perfect_mesh_stays() -> None:
    shape = cube_quads(4)
    result = smooth(shape, shape.V)
    np.testing.assert_allclose(result.V, shape.V, atol=1e-12)


def test_unmatched_boundaries_stay_where_they_are() -> None:
    shape = torus_quads(30, 12)
    Q = np.delete(shape.cells, [5, 6, 100], axis=0)  # holes that the closed input does not have
    edges, use = unique_edges(Q)
    rim = np.unique(edges[use == 1])
    result = smooth_quads(shape.V, Q, shape.surface, shape.features, SmoothOptions())
    np.testing.assert_array_equal(result.V[rim], shape.V[rim])


@pytest.mark.parametrize("shape", [cube_quads(5), sphere_quads(6), patch_quads(8)])
def test_motion_and_scale_carry_over(shape: Shape) -> None:
    rotation, scale = Rotation.random(random_state=5).as_matrix(), 7.3

    def move(P: Floats) -> Floats:
        return scale * P @ rotation.T + np.array([3.0, -2.0, 1.0])

    V = jitter(shape.V, 0.02, seed=6)
    # the limits are measured in axis-parallel boxes, which do turn
    options = SmoothOptions(hausdorff_limit=1.0, reach_limit=1.0)
    still = smooth(shape, V, options)
    moved = smooth_quads(
        move(V), shape.cells, Surface(move(shape.surface.V), shape.surface.F), shape.features, options
    )
    np.testing.assert_allclose(moved.V, move(still.V), atol=1e-9 * scale)


def test_progress_grows_to_its_end() -> None:
    shape = cube_quads(3)
    seen: list[float] = []
    smooth_quads(
        jitter(shape.V, 0.05, seed=7),
        shape.cells,
        shape.surface,
        shape.features,
        SmoothOptions(),
        lambda fraction, _: seen.append(fraction),
    )
    assert seen == sorted(seen)
    assert seen[0] == 0.0
    assert seen[-1] == 1.0
    smooth_quads(shape.V, shape.cells, shape.surface, shape.features, SmoothOptions(), silent)


def test_no_quads_are_refused() -> None:
    shape = cube_quads(2)
    with pytest.raises(InvalidMesh, match="no cells"):
        smooth_quads(shape.V, shape.cells[:0], shape.surface, shape.features, SmoothOptions())

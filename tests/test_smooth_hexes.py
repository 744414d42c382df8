"""Smoothing and untangling of hexes: closed-form meshes come back, constraints hold, nothing gets worse."""

from __future__ import annotations

import igl
import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from smooth_shapes import Shape, cube_hexes, cylinder_hexes, grid_hexes, jitter, sphere_hexes

from neurframe_cli.mesh.arrays import Floats, Surface
from neurframe_cli.mesh.optimize.improve import ImproveOptions
from neurframe_cli.mesh.optimize.smooth import SmoothedMesh, SmoothOptions
from neurframe_cli.mesh.quality.scaled_jacobian import hex_scaled_jacobians
from neurframe_cli.stages.smooth_hexes import boundary_quads, smooth_hexes


def smooth(shape: Shape, V: Floats, options: SmoothOptions | None = None) -> SmoothedMesh:
    return smooth_hexes(V, shape.cells, shape.surface, shape.features, options or SmoothOptions())


def worst(V: Floats, shape: Shape) -> float:
    return float(hex_scaled_jacobians(V, shape.cells).min())


@pytest.mark.parametrize("amount", [0.03, 0.12])  # of an edge of 1/5: the second inverts most hexes
def test_a_jittered_cube_returns_to_its_grid(amount: float) -> None:
    shape = cube_hexes(5)
    V = jitter(shape.V, amount, seed=1)
    result = smooth(shape, V)
    assert worst(result.V, shape) > 0.99
    # with isotropic targets the regular grid is the only minimiser; the optimiser stops within 2 % of an edge of it
    isotropic = SmoothOptions(ImproveOptions(anisotropy=0.0, gain=1e-6))
    np.testing.assert_allclose(smooth(shape, V, isotropic).V, shape.V, atol=0.02 / 5)


def test_tangled_insides_are_untangled() -> None:
    shape = cylinder_hexes()
    inside = np.setdiff1d(np.arange(len(shape.V)), boundary_quads(shape.cells))
    V = shape.V.copy()
    V[inside] = jitter(V[inside], 0.5, seed=2)
    assert (hex_scaled_jacobians(V, shape.cells).min(axis=1) < 0).mean() > 0.5
    result = smooth(shape, V)
    assert result.report.after.inverted == 0
    # the O-grid's own block corners on the rim allow no more than 135 degrees between two edges: sin = 0.707
    assert worst(result.V, shape) > 0.7


def test_vertices_stay_on_the_cylinder_and_its_rims() -> None:
    shape = cylinder_hexes()
    result = smooth(shape, jitter(shape.V, 0.03, seed=3))
    found = result.report.classification
    assert (found.matched_curves, found.curves, found.on_curves) == (2, 2, 2 * 16)
    boundary = np.unique(boundary_quads(shape.cells))
    squared = igl.point_mesh_squared_distance(result.V[boundary], shape.surface.V, shape.surface.F)[0]
    assert np.sqrt(squared.max()) < 1e-12
    rim = (np.linalg.norm(shape.V[:, :2], axis=1) > 1 - 1e-9) & np.isin(shape.V[:, 2], [0.0, 2.0])
    np.testing.assert_allclose(result.V[rim, 2], shape.V[rim, 2], atol=1e-12)


def test_hexes_become_worse_where_they_are_too_far_from_the_surface() -> None:
    """A rounded cube about a sphere: there the hexes along its edges and at its corners cannot be what they are."""
    shape = sphere_hexes(4)
    rounded = (shape.V + 0.75 * (2 * grid_hexes(4)[0] - 1)) / 2
    result = smooth(shape, rounded, SmoothOptions(hausdorff_limit=0.02))
    assert result.report.before.hausdorff > 0.02
    assert result.report.after.hausdorff <= 0.02
    assert result.report.after.inverted == 0
    assert worst(result.V, shape) > 0.2


@pytest.mark.parametrize("seed", range(3))
def test_the_worst_hex_never_gets_worse(seed: int) -> None:
    shape = sphere_hexes(3, surface_n=5)
    V = jitter(shape.V, 0.4, seed)
    result = smooth(shape, V, SmoothOptions(hausdorff_limit=0.0))
    report = result.report
    assert worst(result.V, shape) >= worst(V, shape) - 1e-12
    assert report.after.inverted <= report.before.inverted
    assert report.after.hausdorff <= report.before.hausdorff
    before = hex_scaled_jacobians(V, shape.cells).min(axis=1)
    after = hex_scaled_jacobians(result.V, shape.cells).min(axis=1)
    assert (after[before > 1e-9] > 0).all()


def test_the_boundary_of_a_void_does_not_move() -> None:
    shape = cube_hexes(6)
    centre = grid_hexes(6)[0][shape.cells].mean(axis=1)
    H = shape.cells[np.abs(centre - 0.5).max(axis=1) > 0.25]  # all but the outer layers
    void = np.unique(boundary_quads(H))
    void = void[np.abs(shape.V[void] - 0.5).max(axis=1) < 0.49]
    result = smooth_hexes(
        jitter(shape.V, 0.005, seed=4), H, shape.surface, shape.features, SmoothOptions(hausdorff_limit=1.0)
    )
    assert len(void) > 0
    assert result.report.classification.off_surface == len(void)
    np.testing.assert_array_equal(result.V[void], jitter(shape.V, 0.005, seed=4)[void])


@pytest.mark.parametrize("shape", [cube_hexes(4), cylinder_hexes()])
def test_motion_and_scale_carry_over(shape: Shape) -> None:
    rotation, scale = Rotation.random(random_state=5).as_matrix(), 0.02

    def move(P: Floats) -> Floats:
        return scale * P @ rotation.T + np.array([3.0, -2.0, 1.0])

    V = jitter(shape.V, 0.03, seed=6)
    # the limit is measured in axis-parallel boxes, which do turn
    options = SmoothOptions(hausdorff_limit=1.0)
    still = smooth(shape, V, options)
    surface = Surface(move(shape.surface.V), shape.surface.F)
    moved = smooth_hexes(move(V), shape.cells, surface, shape.features, options)
    np.testing.assert_allclose(moved.V, move(still.V), atol=1e-9 * scale)

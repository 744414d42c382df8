"""The parts of the quad stage on closed forms: sizing by curvature, mirror symmetry, finer triangles, feature lines."""

from __future__ import annotations

import numpy as np
import pytest
from smooth_shapes import cube_quads, grid_quads, sphere_quads, torus_quads

from neurframe_cli.errors import InvalidMesh, UsageError
from neurframe_cli.field.surface_cross_field import relaxed_cross_field, surface_cross_field
from neurframe_cli.mesh.arrays import Features, Floats, Surface
from neurframe_cli.mesh.features import features_from_edges
from neurframe_cli.mesh.optimize.lasting_features import lasting_features
from neurframe_cli.mesh.quality.polygons import euler_characteristic, unique_edges
from neurframe_cli.mesh.split_edges import with_short_edges
from neurframe_cli.mesh.surface_edges import directed_edges
from neurframe_cli.stages.curvature_sizing import (
    SizingOptions,
    curvature_sizing,
    largest_curvature,
    vertex_areas,
)
from neurframe_cli.stages.mirror_plane import MirrorPlane, cut_off, features_of_half, mirror_plane
from neurframe_cli.stages.symmetric_quads import half_model, mirrored_quads


def area(surface: Surface) -> float:
    return float(vertex_areas(surface).sum())


def edge_lengths(surface: Surface) -> Floats:
    ends = surface.V[directed_edges(surface.F)]
    return np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)


def rng() -> np.random.Generator:
    return np.random.default_rng(0)


def test_curvature_of_a_sphere_is_one_over_its_radius() -> None:
    sphere = sphere_quads(2, 20).surface
    found = largest_curvature(Surface(2.0 * sphere.V, sphere.F), Features())
    np.testing.assert_allclose(found, 0.5, rtol=0.1)


def test_edges_of_a_cube_are_no_curvature() -> None:
    shape = cube_quads(2, 8)
    assert largest_curvature(shape.surface, shape.features).max() < 1e-6
    # without its features the fit goes round the corners
    assert largest_curvature(shape.surface, Features()).max() > 1.0


@pytest.mark.parametrize("strength", [0.0, 0.5, 1.0])
def test_sizing_follows_the_curvature_within_its_range(strength: float) -> None:
    surface = torus_quads(60, 24).surface
    factors = curvature_sizing(surface, Features(), 0.1, SizingOptions(strength))
    assert factors.min() >= 3.0**-strength - 1e-12
    assert factors.max() <= 3.0**strength + 1e-12
    # as many quads as without it
    assert np.sum(vertex_areas(surface) / factors**2) == pytest.approx(area(surface), rel=1e-6)
    if strength == 0.0:
        np.testing.assert_allclose(factors, 1.0)


def test_sizing_is_smaller_where_a_bump_bends() -> None:
    t = np.linspace(-1.0, 1.0, 41)
    x, y = (a.ravel() for a in np.meshgrid(t, t, indexing="ij"))
    V = np.stack([x, y, 0.3 * np.exp(-12 * (x**2 + y**2))], axis=1)
    Q = grid_quads(40, 40)[:, ::-1]
    surface = Surface(V, np.concatenate([Q[:, [0, 1, 2]], Q[:, [0, 2, 3]]]))
    factors = curvature_sizing(surface, Features(), 0.05, SizingOptions(1.0))
    middle, rim = np.hypot(x, y) < 0.1, np.hypot(x, y) > 0.9
    assert factors[middle].max() < 0.7
    assert factors[rim].min() > 1.2
    # the edge length grows by at most 0.2 per length
    ends = directed_edges(surface.F)
    growth = 0.05 * np.abs(factors[ends[:, 0]] - factors[ends[:, 1]]) / edge_lengths(surface)
    assert growth.max() <= 0.2 + 1e-9


def test_a_strength_beyond_one_is_refused() -> None:
    with pytest.raises(UsageError, match="from 0 to 1"):
        curvature_sizing(sphere_quads(2, 4).surface, Features(), 0.1, SizingOptions(1.5))


def test_the_mirror_plane_of_a_torus() -> None:
    surface = torus_quads(40, 16).surface
    moved = Surface(surface.V + np.array([0.3, 0.0, 0.0]), surface.F)
    plane = mirror_plane(moved, "z", 0.005, rng())
    assert (plane.axis, plane.offset) == (2, pytest.approx(0.0, abs=1e-12))


def test_a_lopsided_surface_is_refused_with_how_far_it_is_off() -> None:
    surface = sphere_quads(2, 12).surface
    V = surface.V.copy()
    V[:, 0] *= np.where(V[:, 0] > 0, 1.0, 0.5)
    with pytest.raises(UsageError, match=r"mirrored at x = 0\.25 .* of the diagonal"):
        mirror_plane(Surface(V, surface.F), "x", 0.005, rng())


@pytest.mark.parametrize("snap", [0.0, 0.25])
def test_a_cut_lies_in_the_plane_to_the_last_bit(snap: float) -> None:
    surface = torus_quads(40, 16).surface
    plane = MirrorPlane(0, 0.1)
    half = cut_off(surface, plane, snap)
    height = plane.height(half.surface.V)
    edges, use = unique_edges(half.surface.F)
    assert use.max() == 2
    rim = np.unique(edges[use == 1])
    assert (height[rim] == 0.0).all()
    assert (height[np.setdiff1d(np.arange(len(height)), rim)] > 0.0).all()
    other = cut_off(surface, plane, 0.0)
    mirrored = cut_off(Surface(plane.mirror(surface.V), surface.F[:, ::-1]), plane, 0.0)
    assert area(other.surface) + area(mirrored.surface) == pytest.approx(area(surface), rel=1e-9)


def test_values_are_carried_to_the_half() -> None:
    surface = torus_quads(40, 16).surface
    half = cut_off(surface, MirrorPlane(2, 0.05), 0.0)
    np.testing.assert_allclose(half.interpolate(surface.V[:, 1]), half.surface.V[:, 1], atol=1e-12)


def test_features_are_cut_with_the_surface() -> None:
    shape = cube_quads(2, 5)
    half = cut_off(shape.surface, MirrorPlane(0, 0.5), 0.0)
    found = features_of_half(half, shape.features)
    V = half.surface.V
    length = np.linalg.norm(V[found.edges[:, 0]] - V[found.edges[:, 1]], axis=1).sum()
    assert length == pytest.approx(4 * 1.0 + 4 * 0.5)
    with pytest.raises(UsageError, match="does not cut"):
        cut_off(shape.surface, MirrorPlane(0, 1.5), 0.0)


@pytest.mark.parametrize("offset", [0.0, 0.1, -1234.567])
def test_mirrored_quads_are_symmetric_to_the_last_bit(offset: float) -> None:
    plane = MirrorPlane(1, offset)
    t = np.linspace(0.0, 1.0, 6)
    x, y = (a.ravel() for a in np.meshgrid(t, t, indexing="ij"))
    noise = np.random.default_rng(3).uniform(0.0, 0.1, len(x))
    V = np.stack([x, offset + y + np.where(y > 0, noise, 0.0), noise], axis=1)
    whole, Q = mirrored_quads(V, grid_quads(5, 5), plane)
    assert euler_characteristic(Q) == 1
    assert unique_edges(Q)[1].max() == 2
    assert len(whole) == 2 * len(V) - 6
    centre = whole[np.abs(whole[:, 1] - offset).argmin(), 1]  # the offset as it was rounded
    image = whole.copy()
    image[:, 1] = 2 * centre - whole[:, 1]
    assert {tuple(p) for p in image.tolist()} == {tuple(p) for p in whole.tolist()}


def test_quads_beyond_the_plane_are_refused() -> None:
    V = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, -1, 0]], float)
    with pytest.raises(InvalidMesh, match="1 vertices of the half mesh lie beyond"):
        mirrored_quads(V, np.array([[0, 1, 2, 3]]), MirrorPlane(1, 0.0))


def test_crosses_of_a_half_follow_the_cut_and_are_tangent() -> None:
    surface = torus_quads(30, 12).surface
    crosses = surface_cross_field(surface.V, surface.F, Features().edges)
    plane = MirrorPlane(2, 0.0)
    half = half_model(plane, surface, Features(), surface, crosses, Features())
    V, F = half.carrier.surface.V, half.carrier.surface.F
    use = unique_edges(F)[1]
    beside = np.flatnonzero((V[F][:, :, 2] == 0.0).sum(axis=1) == 2)
    assert len(beside) == (use == 1).sum()
    for f in beside.tolist():
        a, b = V[F[f][V[F[f]][:, 2] == 0.0]]
        along = (b - a) / np.linalg.norm(b - a)
        assert np.abs(half.crosses[f] @ along).max() == pytest.approx(1.0, abs=1e-9)


def test_relaxing_a_smooth_field_changes_little() -> None:
    surface = torus_quads(30, 12).surface
    crosses = surface_cross_field(surface.V, surface.F, Features().edges)
    again = relaxed_cross_field(surface.V, surface.F, Features().edges, crosses[None, :, 0])
    cosine = np.abs(np.einsum("mkd,md->mk", again, crosses[:, 0])).max(axis=1)
    assert cosine.min() > np.cos(np.radians(5))


def test_short_edges_keep_area_and_topology() -> None:
    shape = cube_quads(2, 2)
    fine = with_short_edges(shape.surface, 0.2)
    assert edge_lengths(fine).max() <= 0.2
    assert area(fine) == pytest.approx(6.0)
    assert euler_characteristic(fine.F) == 2
    assert (unique_edges(fine.F)[1] == 2).all()
    np.testing.assert_array_equal(with_short_edges(fine, 0.2).F, fine.F)


def test_only_long_feature_lines_last() -> None:
    V = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [5, 0, 0], [5.5, 0, 0]], float)
    features = features_from_edges(V, np.array([[0, 1], [1, 2], [3, 4]]))
    kept = lasting_features(V, features, 1.5)
    np.testing.assert_array_equal(kept.edges, [[0, 1], [1, 2]])
    assert lasting_features(V, features, 0.1) is features

"""Hexes of a regular grid: which cells, along which axes, and what they become at the surface."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import trimesh

from neurframe_cli.errors import NotValid
from neurframe_cli.mesh.arrays import Features, Surface, as_surface
from neurframe_cli.mesh.features import features_by_angle
from neurframe_cli.mesh.grid_cells import (
    CellFit,
    Grid,
    area_axes,
    centre_depths,
    completed_cells,
    grid_over,
    hexes_of,
    split_at,
)
from neurframe_cli.mesh.grid_planes import grid_planes
from neurframe_cli.mesh.hex_shell import hex_shell
from neurframe_cli.mesh.measure import enclosed_volume, surface_area
from neurframe_cli.mesh.optimize.simplex_tree import SimplexTree
from neurframe_cli.mesh.pinches import has_topology_of
from neurframe_cli.mesh.quality.check import CheckOptions, check_hexes
from neurframe_cli.mesh.quality.scaled_jacobian import hex_scaled_jacobians
from neurframe_cli.pipeline.sizing import ElementSize
from neurframe_cli.stages import grid_hexes as stage
from neurframe_cli.stages.grid_hexes import GridOptions, grid_hexes
from neurframe_cli.stages.pad_hexes import pillow_hexes


def surface_of(mesh: Any) -> Surface:
    return as_surface(mesh.vertices, mesh.faces)


def turned(mesh: Any) -> Any:
    rotation = trimesh.transformations.euler_matrix(0.3, 0.5, 0.2)
    return mesh.apply_transform(rotation)


def inside_out(mesh: Any) -> Any:
    mesh.invert()
    return mesh


def features_of(surface: Surface) -> Features:
    return features_by_angle(surface.V, surface.F, 45.0)


def test_axes_are_those_of_a_turned_box() -> None:
    box = trimesh.creation.box(extents=(1.0, 2.0, 3.0))
    found = area_axes(surface_of(turned(box.copy())))
    wanted = trimesh.transformations.euler_matrix(0.3, 0.5, 0.2)[:3, :3].T
    # each found axis is one of the box's, up to its sign
    assert np.abs(found @ wanted.T).max(axis=1) == pytest.approx(np.ones(3), abs=1e-9)
    assert np.linalg.det(found) == pytest.approx(1.0)
    np.testing.assert_array_equal(area_axes(surface_of(box)), np.eye(3))
    np.testing.assert_array_equal(area_axes(surface_of(trimesh.creation.icosphere(3))), np.eye(3))


def test_a_grid_fills_a_turned_box_without_a_remainder() -> None:
    surface = surface_of(turned(trimesh.creation.box(extents=(1.0, 2.0, 3.0))))
    grid = grid_over(surface, features_of(surface), area_axes(surface), 0.45)
    assert sorted(grid.counts) == [2, 4, 7]
    depth = centre_depths(grid, surface)
    assert (depth > 0.0).all()
    V, H = hexes_of(grid, np.argwhere(depth > 0.0))
    assert len(H) == 2 * 4 * 7
    assert check_hexes(V, H, surface, features_of(surface), CheckOptions()).valid
    assert hex_scaled_jacobians(V, H).min() == pytest.approx(1.0)


def test_planes_lie_in_flat_parts_of_the_surface() -> None:
    """A step of 0.37 on a block: a plane in its tread, one in its riser, the rest of the block divided evenly."""
    low = trimesh.creation.box(bounds=[[0, 0, 0], [2, 0.37, 1.5]])
    high = trimesh.creation.box(bounds=[[0, 0.37, 0], [1.3, 1, 1.5]])
    surface = surface_of(trimesh.util.concatenate([low, high]))
    x, y, z = grid_planes(surface, features_of(surface), np.eye(3), 0.25)
    assert min(abs(x - 1.3)) < 1e-12
    assert min(abs(y - 0.37)) < 1e-12
    for places, length in ((x, 2.0), (y, 1.0), (z, 1.5)):
        assert (places[0], places[-1]) == pytest.approx((0.0, length))
        assert (np.diff(places) > 0.15).all()
        assert (np.diff(places) < 0.38).all()
    np.testing.assert_allclose(np.diff(z), 0.25)


def test_planes_that_carry_little_or_are_close_together_are_left_out() -> None:
    """A tread 0.05 above the floor of a block, and another that is smaller than two cells."""
    block = trimesh.creation.box(extents=(2.0, 2.0, 1.0), transform=shifted(0.0, 0.0, 0.5))
    tread = trimesh.creation.box(extents=(1.0, 1.0, 0.05), transform=shifted(0.0, 0.0, 1.025))
    knob = trimesh.creation.box(extents=(0.1, 0.1, 0.1), transform=shifted(0.9, 0.9, 1.05))
    surface = surface_of(trimesh.util.concatenate([block, tread, knob]))
    features = features_of(surface)
    z = grid_planes(surface, features, np.eye(3), 0.25)[2]
    assert z[-1] == pytest.approx(1.1)
    assert min(abs(z - 1.0)) < 1e-12  # the floor carries more than the tread 0.05 above it
    assert min(abs(z - 1.05)) > 0.04


def test_cells_are_halved_in_the_slabs_of_places() -> None:
    surface = surface_of(trimesh.creation.box())
    grid = grid_over(surface, features_of(surface), np.eye(3), 0.25)
    finer = split_at(grid, np.array([[-0.4, 0.1, 0.45], [-0.45, 0.1, 0.4]]))
    np.testing.assert_array_equal(finer.counts, [5, 5, 5])
    np.testing.assert_allclose(finer.planes[0], [-0.5, -0.375, -0.25, 0.0, 0.25, 0.5])
    np.testing.assert_allclose(finer.planes[1], [-0.5, -0.25, 0.0, 0.125, 0.25, 0.5])


def test_cells_are_halved_where_the_surface_is_too_far(monkeypatch: pytest.MonkeyPatch) -> None:
    """A ring of coarse cells, too far from it all round."""
    monkeypatch.setattr(stage, "MOST_GROWTH", 9.0)
    surface = surface_of(trimesh.creation.torus(1.0, 0.3, major_sections=48, minor_sections=24))
    made = grid_hexes(surface, features_of(surface), 0.3, GridOptions())
    assert (made.finer, made.split) == (1.0, 1)
    first, second = made.report["grid"]
    assert "Hausdorff distance" in first["refused"]
    assert second["refused"] is None
    assert second["cells"] > first["cells"]


def shifted(x: float, y: float, z: float) -> Any:
    return trimesh.transformations.translation_matrix((x, y, z))


def test_cells_are_added_where_the_surface_passes_them_by() -> None:
    """A spike on a block, thinner than a cell, so that no centre lies in it."""
    block = trimesh.creation.box(extents=(1.0, 1.0, 1.0))
    spike = trimesh.creation.cylinder(0.03, 0.5, sections=24).apply_translation((0.15, 0.15, 0.75))
    surface = surface_of(trimesh.util.concatenate([block, spike]))
    grid = grid_over(surface, features_of(surface), np.eye(3), 0.125)
    depth = centre_depths(grid, surface)
    inside = completed_cells(CellFit(grid, depth, surface), depth > 0.0)
    assert inside[depth > 0.0].all()
    assert inside.sum() > (depth > 0.0).sum()
    top = hexes_of(grid, np.argwhere(inside))[0][:, 2].max()
    assert top == pytest.approx(surface.V[:, 2].max())


def test_cells_are_taken_from_slits_thinner_than_they_are() -> None:
    """A notch as wide as a quarter of a cell, which has all centres beside it inside."""
    block = trimesh.creation.box(bounds=[[0, 0, 0], [1, 1, 0.5]])
    notch = inside_out(trimesh.creation.box(bounds=[[0.39, 0, 0.2], [0.42, 0.8, 0.5]]))
    surface = surface_of(trimesh.util.concatenate([block, notch]))
    grid = Grid(np.eye(3), (np.linspace(0, 1, 9), np.linspace(0, 1, 9), np.linspace(0, 0.5, 5)), 0.125)
    depth = centre_depths(grid, surface)
    assert (depth > 0.0).all()
    gone = ~completed_cells(CellFit(grid, depth, surface), depth > 0.0)
    assert gone[3, :5, 2:].all()
    gone[3] = False
    assert not gone.any()


def test_thin_legs_grow_from_the_body_that_they_belong_to() -> None:
    """A body on two slanted legs, of which centres see crumbs only: no depth gives a ball."""
    body = trimesh.creation.icosphere(3, radius=1.0)
    V = body.vertices.copy()
    for side in (-1.0, 1.0):
        towards = np.array([side, 0.3, -1.0]) / np.linalg.norm([1.0, 0.3, 1.0])
        leg = V @ towards > 0.995
        leg[np.linalg.norm(V, axis=1) > 1.5] = False
        V[leg] += 1.5 * towards
    surface = surface_of(trimesh.Trimesh(V, body.faces, process=False))
    made = grid_hexes(surface, features_of(surface), 0.25, GridOptions())
    assert check_hexes(made.V, made.cells, surface, features_of(surface), CheckOptions()).valid


def test_a_layer_lies_round_all_hexes() -> None:
    surface = surface_of(trimesh.creation.icosphere(3))
    grid = grid_over(surface, features_of(surface), np.eye(3), 0.3)
    V, H = hexes_of(grid, np.argwhere(centre_depths(grid, surface) > 0.0))
    before = hex_shell(H).quads
    layered, cells = pillow_hexes(V, H)
    after = hex_shell(cells).quads
    assert has_topology_of(cells, surface)
    assert (cells[: len(H)] == H).all()
    assert len(cells) == len(H) + len(before) == len(H) + len(after)
    np.testing.assert_allclose(layered[after].mean(axis=1), V[before].mean(axis=1))
    assert np.bincount(hex_shell(cells).owner).max() == 1  # before, hexes had up to three faces outside


MODELS = {
    "ball": trimesh.creation.icosphere(4),
    "turned box": turned(trimesh.creation.box(extents=(1.0, 1.3, 0.8))),
    "cone": trimesh.creation.cone(0.5, 1.2, sections=32),
    "ring": trimesh.creation.torus(1.0, 0.35, major_sections=48, minor_sections=24),
    "hollow ball": trimesh.util.concatenate(
        [trimesh.creation.icosphere(3), inside_out(trimesh.creation.icosphere(3, radius=0.5))]
    ),
    "two boxes": trimesh.util.concatenate(
        [trimesh.creation.box(), turned(trimesh.creation.box()).apply_translation((2.5, 0.0, 0.0))]
    ),
    "wheel": trimesh.creation.annulus(0.3, 0.7, 0.4, sections=48),
}


@pytest.mark.parametrize("name", MODELS)
def test_a_grid_becomes_valid_hexes(name: str) -> None:
    surface = surface_of(MODELS[name])
    features = features_of(surface)
    diagonal = float(np.linalg.norm(np.ptp(surface.V, axis=0)))
    made = grid_hexes(surface, features, diagonal / 16, GridOptions())
    verdict = check_hexes(made.V, made.cells, surface, features, CheckOptions())
    assert verdict.valid
    assert verdict.numbers["min_scaled_jacobian"] > 0.05
    assert made.report["grid"][-1]["finer"] == made.finer
    # soft constraints bring vertices near the surface, and then most of them settle on it: all but 0 to 40 %
    away = SimplexTree(surface.V, surface.F).distances(made.V[np.unique(hex_shell(made.cells).quads)])
    assert (away < 1e-9 * diagonal).mean() > 0.5


def test_a_grid_is_refined_until_it_has_the_topology_of_the_surface() -> None:
    surface = surface_of(trimesh.creation.annulus(0.1, 0.5, 0.3, sections=48))
    made = grid_hexes(surface, features_of(surface), 0.5, GridOptions())
    assert "topology" in made.report["grid"][0]["refused"]
    assert made.finer > 1.0


def test_what_was_wrong_with_each_grid_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two balls almost in touch, and a wish that no mesh fulfils."""
    one = trimesh.creation.icosphere(2)
    other = one.copy().apply_translation((2.001, 0.0, 0.0))
    surface = surface_of(trimesh.util.concatenate([one, other]))
    strict = GridOptions(check=CheckOptions(hausdorff_limit=1e-6))
    monkeypatch.setattr(stage, "MOST_HEXES", 400)
    monkeypatch.setattr(stage, "MOST_CELLS", 1000)
    wanted = r"x 1: .*topology.*; x 1\.5: Hausdorff.*; x 2: more than 400 hexes; x 3: a grid of more than 1,000 cells"
    with pytest.raises(NotValid, match=wanted):
        grid_hexes(surface, features_of(surface), 0.7, strict)


def test_the_edge_of_a_count_is_that_of_cubes_and_a_layer() -> None:
    surface = surface_of(trimesh.creation.icosphere(3))
    h = ElementSize(count=2000).layered_edge(surface)
    volume, area = enclosed_volume(surface.V, surface.F), surface_area(surface.V, surface.F)
    assert volume / h**3 + area / h**2 == pytest.approx(2000)
    assert ElementSize(edge_length=0.2).layered_edge(surface) == 0.2

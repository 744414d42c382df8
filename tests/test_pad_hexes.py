"""Padding: one more layer on each side, as in a grid; never a worse mesh."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from smooth_shapes import Shape, cube_hexes, cylinder_hexes, sphere_hexes

from neurframe_cli.mesh.hex_shell import hex_shell
from neurframe_cli.mesh.optimize.smooth import SmoothOptions
from neurframe_cli.mesh.quality.check import CheckOptions, check_hexes
from neurframe_cli.mesh.quality.scaled_jacobian import hex_scaled_jacobians
from neurframe_cli.stages.pad_hexes import pad_hexes, padded_hexes
from neurframe_cli.stages.smooth_hexes import smooth_hexes


def test_a_padded_cube_is_a_finer_grid() -> None:
    shape = cube_hexes(3)
    V, H = pad_hexes(shape.V, shape.cells)
    assert len(H) == 5**3
    assert len(V) == 6**3
    assert hex_scaled_jacobians(V, H).min() == pytest.approx(1.0)
    np.testing.assert_allclose(np.unique(V[:, 0].round(12)), [0, 0.4 / 3, 1 / 3, 2 / 3, 1 - 0.4 / 3, 1])


@pytest.mark.parametrize("shape", [cube_hexes(3), sphere_hexes(4), cylinder_hexes()])
def test_the_boundary_stays_and_each_of_its_quads_gets_a_hex(shape: Shape) -> None:
    V, H = pad_hexes(shape.V, shape.cells)
    before, after = hex_shell(shape.cells).quads, hex_shell(H).quads
    np.testing.assert_array_equal(H[: len(shape.cells)], shape.cells)
    assert len(H) >= len(shape.cells) + len(before)
    assert hex_scaled_jacobians(V, H).min() > 0
    # the outer vertices are the old ones, and those of the layers along the edges
    old = {tuple(p) for p in shape.V[np.unique(before)].round(9)}
    assert old <= {tuple(p) for p in V[np.unique(after)].round(9)}


def test_a_sphere_is_padded_with_one_whole_layer() -> None:
    shape = sphere_hexes(4)
    quads = len(hex_shell(shape.cells).quads)
    _, H = pad_hexes(shape.V, shape.cells)
    assert len(H) == len(shape.cells) + quads
    touching = np.bincount(hex_shell(H).owner, minlength=len(H))
    assert touching.max() == 1  # before, the hexes at the eight corners had three faces outside


def test_a_padded_sphere_is_better_and_passes_the_check() -> None:
    shape = sphere_hexes(7, surface_n=16)
    options = SmoothOptions()
    plain = smooth_hexes(shape.V, shape.cells, shape.surface, shape.features, options)
    result = padded_hexes(plain, shape.cells, shape.surface, shape.features, options)
    assert result.kept
    assert result.padded.min_scaled_jacobian > plain.report.after.min_scaled_jacobian
    checked = check_hexes(result.smoothed.V, result.cells, shape.surface, shape.features, CheckOptions())
    assert checked.valid, checked.problems


def test_a_worse_mesh_is_not_taken() -> None:
    shape = sphere_hexes(3, surface_n=8)
    options = SmoothOptions(hausdorff_limit=0.0)
    plain = smooth_hexes(shape.V, shape.cells, shape.surface, shape.features, options)
    # flat quads cannot be as near to the sphere as this pretends
    after = replace(plain.report.after, hausdorff=0.0)
    exact = replace(plain, report=replace(plain.report, after=after))
    result = padded_hexes(exact, shape.cells, shape.surface, shape.features, options)
    assert not result.kept
    assert result.smoothed is exact
    np.testing.assert_array_equal(result.cells, shape.cells)

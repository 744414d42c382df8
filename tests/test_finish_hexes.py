"""What becomes of the hexes of a map: padded where they are poor, split where they are too coarse."""

from __future__ import annotations

import numpy as np
import pytest
from smooth_shapes import cube_hexes, grid_hexes, sphere_hexes

from neurframe_cli.mesh.hex_shell import hex_shell
from neurframe_cli.mesh.optimize.smooth import SmoothOptions
from neurframe_cli.mesh.quality.scaled_jacobian import hex_scaled_jacobians
from neurframe_cli.stages.finish_hexes import FinishOptions, finish_hexes
from neurframe_cli.stages.split_hexes import split_hexes


def test_a_split_grid_is_the_finer_grid() -> None:
    V, H = split_hexes(*grid_hexes(4))
    finer, _ = grid_hexes(8)  # powers of two: the middles are exact
    np.testing.assert_array_equal(V[np.lexsort(V.T)], finer[np.lexsort(finer.T)])
    assert len(H) == 8**3
    assert hex_scaled_jacobians(V, H).min() > 1 - 1e-12
    assert len(hex_shell(H).quads) == 6 * 8**2


def test_fine_hexes_stay_as_they_are() -> None:
    shape = cube_hexes(4)
    made = finish_hexes(shape.V, shape.cells, shape.surface, shape.features, FinishOptions(), whole=True)
    assert list(made.report) == ["smoothing"]
    assert len(made.cells) == len(shape.cells)
    assert made.warnings == ()


@pytest.mark.parametrize("splitting", [True, False])
def test_a_mesh_that_is_too_coarse_for_its_surface_is_split(splitting: bool) -> None:
    """Three hexes across a ball: its bulges are farther away than the limit, wherever the vertices are."""
    shape = sphere_hexes(3)
    options = FinishOptions(
        padding=False, splitting=splitting, smoothing=SmoothOptions(hausdorff_limit=0.012)
    )
    fractions: list[float] = []
    made = finish_hexes(
        shape.V,
        shape.cells,
        shape.surface,
        shape.features,
        options,
        whole=True,
        progress=lambda fraction, text: fractions.append(fraction),
    )
    assert fractions == sorted(fractions)
    assert made.report["smoothing"]["after"]["hausdorff"] > 0.012
    assert len(made.cells) == len(shape.cells) * (8 if splitting else 1)
    assert len(made.warnings) == splitting
    if splitting:
        assert made.report["splitting"]["kept"]
        assert made.report["splitting"]["split"]["hausdorff"] <= 0.012
        assert hex_scaled_jacobians(made.V, made.cells).min() > 0
        assert "27 hexes were too coarse" in made.warnings[0]

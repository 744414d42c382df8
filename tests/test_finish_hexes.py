"""What becomes of the hexes of a map: padded where they are poor, finer where they are too coarse."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from smooth_shapes import cube_hexes, sphere_hexes

from neurframe_cli.mesh.arrays import Floats, Ints
from neurframe_cli.mesh.finer_map import write_finer_map
from neurframe_cli.mesh.optimize.smooth import SmoothOptions
from neurframe_cli.mesh.quality.scaled_jacobian import hex_scaled_jacobians
from neurframe_cli.stages.finish_hexes import FinishOptions, finish_hexes
from neurframe_cli.stages.smooth_hexes import smooth_hexes


def test_fine_hexes_stay_as_they_are() -> None:
    shape = cube_hexes(4)

    def finer(times: int) -> tuple[Floats, Ints]:
        raise AssertionError("nobody needs finer hexes here")

    made = finish_hexes(
        shape.V, shape.cells, shape.surface, shape.features, FinishOptions(), whole=True, finer=finer
    )
    assert list(made.report) == ["smoothing"]
    assert len(made.cells) == len(shape.cells)
    assert made.warnings == ()


@pytest.mark.parametrize(("n", "limit", "times"), [(3, 0.012, 2), (2, 0.0105, 3), (2, 0.001, None)])
def test_a_mesh_that_is_too_coarse_for_its_surface_is_split(n: int, limit: float, times: int | None) -> None:
    """A few hexes across a ball: its bulges are farther away than the limit, wherever the vertices are."""
    shape = sphere_hexes(n)
    options = FinishOptions(padding=False, smoothing=SmoothOptions(hausdorff_limit=limit))
    fractions: list[float] = []
    made = finish_hexes(
        shape.V,
        shape.cells,
        shape.surface,
        shape.features,
        options,
        whole=True,
        finer=lambda times: balls(n * times),
        progress=lambda fraction, text: fractions.append(fraction),
    )
    assert fractions == sorted(fractions)
    assert made.report["smoothing"]["after"]["hausdorff"] > limit
    assert len(made.cells) == len(shape.cells) * (times or 1) ** 3
    tried = made.report["splitting"]
    assert [attempt["times"] for attempt in tried] == list(range(2, (times or 3) + 1))
    assert [attempt["kept"] for attempt in tried] == [attempt["times"] == times for attempt in tried]
    if times:
        assert tried[-1]["smoothing"]["after"]["hausdorff"] <= limit
        assert hex_scaled_jacobians(made.V, made.cells).min() > 0
        assert f"{n**3} hexes were too coarse" in made.warnings[0]


@pytest.mark.parametrize(("splitting", "whole"), [(False, True), (True, False)])
def test_hexes_stay_coarse_where_that_is_wanted_or_some_are_missing(splitting: bool, whole: bool) -> None:
    shape = sphere_hexes(3)
    options = FinishOptions(splitting=splitting, smoothing=SmoothOptions(hausdorff_limit=0.012))
    made = finish_hexes(shape.V, shape.cells, shape.surface, shape.features, options, whole, balls)
    assert "splitting" not in made.report


def balls(n: int) -> tuple[Floats, Ints]:
    shape = sphere_hexes(n)
    return shape.V, shape.cells


def test_a_vertex_far_from_the_surface_stays_only_where_hexes_may_be_missing() -> None:
    """The middle of a side of a cube, pulled out by more than a hex: left there, or put on the surface."""
    shape = cube_hexes(4)
    V = shape.V.copy()
    middle = int(np.linalg.norm(V - [0.5, 0.5, 1.0], axis=1).argmin())
    V[middle, 2] += 0.3
    for voids in (False, True):
        smoothed = smooth_hexes(V, shape.cells, shape.surface, shape.features, SmoothOptions(), voids=voids)
        assert smoothed.report.classification.off_surface == voids
        assert (smoothed.V[middle, 2] == pytest.approx(1.0, abs=1e-9)) != voids


def test_a_finer_map_has_every_parameter_times_as_large(tmp_path: Path) -> None:
    source, target = tmp_path / "map.hexex", tmp_path / "finer.hexex"
    source.write_text("4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1\n0 1 2 3 0 0 0 0.5 0 0 0 -1/3 0 0 0 1e-3\n")
    write_finer_map(source, target, 3)
    assert target.read_text().splitlines()[:-1] == source.read_text().splitlines()[:-1]
    words = target.read_text().splitlines()[-1].split()
    assert words[:4] == ["0", "1", "2", "3"]
    assert [float(word) for word in words[4:]] == [0, 0, 0, 1.5, 0, 0, 0, -1, 0, 0, 0, 0.003]

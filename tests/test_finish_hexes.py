"""What becomes of the hexes of a map: padded where they are poor, finer where they are too coarse."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from smooth_shapes import cube_hexes, grid_hexes, sphere_hexes

from neurframe_cli.errors import StageError
from neurframe_cli.mesh.arrays import Floats, Ints, Surface
from neurframe_cli.mesh.finer_map import write_finer_map
from neurframe_cli.mesh.hex_shell import hex_shell
from neurframe_cli.mesh.optimize.smooth import SmoothOptions
from neurframe_cli.mesh.pinches import has_topology_of, separate_pinches
from neurframe_cli.mesh.quality.check import CheckOptions
from neurframe_cli.mesh.quality.polygons import triangulated
from neurframe_cli.mesh.quality.scaled_jacobian import hex_scaled_jacobians
from neurframe_cli.stages.finish_hexes import FinishOptions, finish_hexes
from neurframe_cli.stages.smooth_hexes import smooth_hexes


def test_fine_hexes_stay_as_they_are() -> None:
    shape = cube_hexes(4)

    def finer(times: int) -> tuple[Floats, Ints]:
        raise AssertionError("nobody needs finer hexes here")

    made = finish_hexes(shape.V, shape.cells, shape.surface, shape.features, FinishOptions(), finer=finer)
    assert list(made.report) == ["whole", "smoothing"]
    assert len(made.cells) == len(shape.cells)
    assert made.warnings == ()


@pytest.mark.parametrize(("n", "limit", "times"), [(3, 0.012, 2), (2, 0.0105, 3), (2, 0.001, None)])
def test_a_mesh_that_is_too_coarse_for_its_surface_is_split(n: int, limit: float, times: int | None) -> None:
    """A few hexes across a ball: its bulges are farther away than the limit, wherever the vertices are."""
    shape = sphere_hexes(n)
    options = within(limit)
    fractions: list[float] = []
    made = finish_hexes(
        shape.V,
        shape.cells,
        shape.surface,
        shape.features,
        options,
        finer=lambda times: balls(n * times),
        progress=lambda fraction, text: fractions.append(fraction),
    )
    assert fractions == sorted(fractions)
    assert len(made.cells) == len(shape.cells) * (times or 1) ** 3
    tried = made.report["splitting"]
    assert [attempt["times"] for attempt in tried] == list(range(1, (times or 3) + 1))
    assert [attempt["kept"] for attempt in tried] == [attempt["times"] == (times or 1) for attempt in tried]
    assert tried[0]["smoothing"]["after"]["hausdorff"] > limit
    if times:
        assert made.report["smoothing"] == tried[-1]["smoothing"]
        assert made.report["smoothing"]["after"]["hausdorff"] <= limit
        assert hex_scaled_jacobians(made.V, made.cells).min() > 0
        assert f"{n**3} hexes were too coarse" in made.warnings[0]


@pytest.mark.parametrize(("splitting", "missing"), [(False, []), (True, [13])])
def test_hexes_stay_coarse_where_that_is_wanted_or_one_is_missing(
    splitting: bool, missing: list[int]
) -> None:
    shape = sphere_hexes(3)
    options = replace(within(0.012), splitting=splitting)
    cells = np.delete(shape.cells, missing, axis=0)  # the one in the middle: a void
    made = finish_hexes(shape.V, cells, shape.surface, shape.features, options, balls)
    assert made.report["whole"] != bool(missing)
    assert "splitting" not in made.report


def test_hexes_that_touch_in_an_edge_only_are_taken_apart() -> None:
    """A ring of twelve hexes, pinched: opposite edges of its hole are one."""
    V, H = grid_hexes(4)
    centres = V[H].mean(axis=1)
    ring = H[(centres[:, 2] < 0.25) & (np.abs(centres[:, :2] - 0.5).max(axis=1) > 0.25)]
    surface = Surface(V, triangulated(hex_shell(ring).quads))
    pinched = ring.copy()
    for z in (0.0, 0.25):
        here, there = (int(np.linalg.norm(V - [x, x, z], axis=1).argmin()) for x in (0.25, 0.75))
        pinched[pinched == there] = here
    assert has_topology_of(ring, surface)
    assert not has_topology_of(pinched, surface)
    apart, cells = separate_pinches(V, pinched)
    assert has_topology_of(cells, surface)
    np.testing.assert_array_equal(apart[cells], V[pinched])


def test_the_first_hexes_stay_where_finer_ones_cannot_be_had() -> None:
    shape = sphere_hexes(2)
    options = within(0.012)

    def finer(times: int) -> tuple[Floats, Ints]:
        raise StageError("no memory left")

    made = finish_hexes(shape.V, shape.cells, shape.surface, shape.features, options, finer)
    assert len(made.cells) == len(shape.cells)
    assert made.warnings == ("2 times as many hexes along each edge could not be had: no memory left",)


def within(limit: float) -> FinishOptions:
    """Options for hexes that are near enough within `limit`."""
    return FinishOptions(
        padding=False,
        smoothing=SmoothOptions(hausdorff_limit=limit),
        check=CheckOptions(hausdorff_limit=limit),
    )


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
    target.write_text("no map")
    with pytest.raises(StageError, match=r"finer.hexex cannot be made finer"):
        write_finer_map(target, tmp_path / "finest.hexex", 2)
    assert words[:4] == ["0", "1", "2", "3"]
    assert [float(word) for word in words[4:]] == [0, 0, 0, 1.5, 0, 0, 0, -1, 0, 0, 0, 0.003]


@pytest.mark.parametrize("missing", [[], [13]])
def test_hexes_without_hope_are_given_up_where_that_is_wanted(missing: list[int]) -> None:
    """Twenty-seven hexes in a ball are away by much more than the limit, or one in the middle is missing."""
    shape = sphere_hexes(3)
    cells = np.delete(shape.cells, missing, axis=0)
    options = replace(within(0.03 if missing else 0.001), splitting=False, give_up=True)
    made = finish_hexes(shape.V, cells, shape.surface, shape.features, options, balls)
    assert made.given_up
    assert not made.fine
    assert made.problems
    np.testing.assert_array_equal(made.V, shape.V)
    finished = finish_hexes(
        shape.V, cells, shape.surface, shape.features, replace(options, give_up=False), balls
    )
    assert not finished.given_up
    assert "smoothing" in finished.report
    assert "smoothing" not in made.report
    assert finished.numbers.mean_scaled_jacobian > made.numbers.mean_scaled_jacobian - 1e-9


def test_finer_hexes_are_tried_where_the_first_ones_are_given_up() -> None:
    shape = sphere_hexes(2)
    options = replace(within(0.0105), give_up=True)
    made = finish_hexes(
        shape.V, shape.cells, shape.surface, shape.features, options, lambda times: balls(2 * times)
    )
    assert made.fine
    assert ["given_up" in attempt for attempt in made.report["splitting"]] == [True, False, False]

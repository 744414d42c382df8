"""Cells that come and go without a change of topology."""

from __future__ import annotations

import numpy as np
import pytest

from neurframe_cli.mesh.arrays import Bools, Floats, Ints
from neurframe_cli.mesh.grid_cells import CORNERS
from neurframe_cli.mesh.grow_cells import GrowingCells
from neurframe_cli.mesh.hex_shell import hex_shell
from neurframe_cli.mesh.pinches import separate_pinches
from neurframe_cli.mesh.quality.polygons import topology, unique_edges


def hexes(inside: Bools) -> tuple[Floats, Ints]:
    """The cells as hexes that share all vertices of the grid."""
    corners = np.argwhere(inside)[:, None, :] + CORNERS
    vertices, index = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    return vertices.astype(float), index.reshape(-1, 8)


def is_manifold(inside: Bools) -> bool:
    """No edge of the shell in more than two quads, and nothing that falls apart in vertices, neither the cells nor the
    rest of space."""
    outside = ~np.pad(inside, 1)
    for cells in (inside, outside):
        V, H = hexes(cells)
        if len(separate_pinches(V, H)[0]) > len(V):
            return False
    return bool((unique_edges(hex_shell(hexes(inside)[1]).quads)[1] == 2).all())


def everything(shape: tuple[int, int, int]) -> Ints:
    return np.argwhere(np.ones(shape, bool))


@pytest.mark.parametrize("seed", range(8))
def test_whatever_is_added_and_removed_a_ball_stays_a_ball(seed: int) -> None:
    rng = np.random.default_rng(seed)
    shape = (6, 5, 4)
    start = np.zeros(shape, bool)
    start[3, 2, 2] = True
    growing = GrowingCells(start)
    for _ in range(4):
        cells = everything(shape)
        wanted = cells[rng.random(len(cells)) < 0.6]
        growing.add(wanted, rng.random(len(wanted)))
        assert topology(hex_shell(hexes(growing.inside)[1]).quads) == (1, 2)
        assert is_manifold(growing.inside)
        unwanted = cells[rng.random(len(cells)) < 0.5]
        growing.remove(unwanted, rng.random(len(unwanted)))
        assert topology(hex_shell(hexes(growing.inside)[1]).quads) == (1, 2)
        assert is_manifold(growing.inside)


def test_a_ring_is_not_filled_and_not_cut() -> None:
    ring = np.ones((3, 3, 1), bool)
    ring[1, 1, 0] = False
    growing = GrowingCells(ring)
    assert growing.add(everything((3, 3, 1)), np.zeros(9)) == 0
    assert growing.remove(everything((3, 3, 1)), np.zeros(9)) == 0
    block = GrowingCells(np.ones((3, 3, 1), bool))
    assert block.remove(np.array([[1, 1, 0]]), np.zeros(1)) == 0


def test_a_wall_grows_cell_by_cell_from_where_it_begins() -> None:
    start = np.zeros((8, 1, 1), bool)
    start[0] = True
    growing = GrowingCells(start)
    wall = np.array([[7, 0, 0], [3, 0, 0], [1, 0, 0], [2, 0, 0], [4, 0, 0]])
    assert growing.add(wall, np.zeros(5)) == 4
    np.testing.assert_array_equal(growing.cells[:, 0], [0, 1, 2, 3, 4])


def test_a_cell_comes_when_its_neighbours_have() -> None:
    start = np.zeros((2, 2, 2), bool)
    start[0, 0, 0] = True
    candidates = np.array([[1, 1, 0], [1, 0, 0], [0, 1, 0]])
    one = GrowingCells(start)
    assert one.add(candidates, np.array([0.0, 1.0, 2.0])) == 3
    corner = np.array([[1, 1, 1], [1, 0, 0]])
    assert GrowingCells(start).add(corner, np.zeros(2)) == 1


def test_cells_of_several_parts_stay_apart() -> None:
    start = np.zeros((5, 1, 1), bool)
    start[[0, 4]] = True
    growing = GrowingCells(start)
    growing.add(everything((5, 1, 1)), np.zeros(5))
    assert topology(hex_shell(hexes(growing.inside)[1]).quads) == (2, 4)
    assert len(growing.cells) == 4

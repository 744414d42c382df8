"""Decimation: fewer triangles, the same surface within the tolerance, the same topology."""

from __future__ import annotations

import numpy as np
import pytest
from smooth_shapes import torus_grid

from neurframe_cli.mesh.arrays import Surface, as_surface
from neurframe_cli.mesh.decimate_surface import decimated_surface, deviation


def torus(rows: int, columns: int) -> Surface:
    V, quads = torus_grid(rows, columns)
    return as_surface(V, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]))


def test_flat_faces_keep_nothing_that_they_do_not_need() -> None:
    n = 16
    u, v = np.meshgrid(np.arange(n + 1.0), np.arange(n + 1.0), indexing="ij")
    at = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    quads = np.stack([at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]], axis=2).reshape(-1, 4)
    square = as_surface(
        np.stack([u, v, 0 * u], axis=2).reshape(-1, 3),
        np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]),
    )
    fewer = decimated_surface(square, 1e-6)
    assert len(fewer.F) <= 200
    assert deviation(fewer, square) <= 1e-6


@pytest.mark.parametrize("tolerance", [3e-3, 2e-2])
def test_a_torus_stays_within_the_tolerance_and_a_torus(tolerance: float) -> None:
    fine = torus(120, 60)
    fewer = decimated_surface(fine, tolerance)
    assert len(fewer.F) < len(fine.F)
    assert deviation(fewer, fine) <= tolerance
    edges = np.sort(np.concatenate([fewer.F[:, [i, (i + 1) % 3]] for i in range(3)]), axis=1)
    unique, uses = np.unique(edges, axis=0, return_counts=True)
    assert (uses == 2).all()
    assert len(fewer.V) - len(unique) + len(fewer.F) == 0  # Euler characteristic


def test_no_tolerance_no_change() -> None:
    coarse = torus(30, 16)
    assert decimated_surface(coarse, 0.0) is coarse

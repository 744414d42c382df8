"""The guard of a step: only what does harm is held back, and who did it is found where others are named."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from neurframe_cli.mesh.arrays import Floats, Ints
from neurframe_cli.mesh.optimize.guard import guarded_step


def next_to(vertices: Ints) -> Ints:
    """Of five vertices in a row, these and their neighbours."""
    return np.unique(np.clip(np.concatenate([vertices - 1, vertices, vertices + 1]), 0, 4))


def guarded_row(harmed: Callable[[Floats], Ints]) -> Floats:
    """Where along x the guard leaves five vertices that want to go from 0 to 1."""
    return guarded_step(np.zeros((5, 3)), np.ones((5, 3)), harmed, lambda x, _: x, next_to)[:, 0]


def test_the_guard_holds_back_only_what_harms() -> None:
    kept = guarded_row(lambda x: np.flatnonzero(x[:, 0] * [1, 2, 9, 1, 1] > 1.2))
    np.testing.assert_array_equal(kept, [1.0, 0.5, 0.0, 1.0, 1.0])


@pytest.mark.parametrize("culprit", range(5))
def test_where_blame_is_misplaced_the_guard_looks_farther_and_farther_away(culprit: int) -> None:
    kept = guarded_row(lambda x: np.array([0]) if x[culprit, 0] > 0.3 else np.array([], int))
    assert kept[culprit] <= 0.25
    np.testing.assert_array_equal(kept[2 * culprit + 1 :], 1.0)

"""Doublets are merged, and nothing else."""

from __future__ import annotations

import numpy as np
from smooth_shapes import cube_shell

from neurframe_cli.mesh.arrays import Floats, Ints
from neurframe_cli.mesh.merge_doublets import merge_doublets
from neurframe_cli.mesh.quality.polygons import unique_edges


def with_doublet(V: Floats, Q: Ints, which: int) -> tuple[Floats, Ints]:
    """Quad `which` (a, b, c, d) becomes (a, b, c, v) and (a, v, c, d)."""
    a, b, c, d = Q[which]
    v = len(V)
    return (
        np.concatenate([V, V[[a, c]].mean(axis=0, keepdims=True)]),
        np.concatenate([np.delete(Q, which, axis=0), [[a, b, c, v], [v, c, d, a]]]),
    )


def as_set(Q: Ints) -> set[tuple[int, ...]]:
    return {tuple(np.roll(quad, -int(quad.argmin())).tolist()) for quad in Q}


def test_a_doublet_becomes_the_quad_that_it_was() -> None:
    V, Q = cube_shell(3)
    split_V, split_Q = with_doublet(V, Q, 5)
    merged_V, merged_Q, count = merge_doublets(split_V, split_Q)
    assert count == 1
    assert merged_V.tolist() == V.tolist()
    assert as_set(merged_Q) == as_set(Q)


def test_a_doublet_in_a_doublet() -> None:
    V, Q = cube_shell(3)
    once = with_doublet(V, Q, 7)
    twice = with_doublet(*once, len(once[1]) - 1)
    merged_V, merged_Q, count = merge_doublets(*twice)
    assert count == 2
    assert as_set(merged_Q) == as_set(Q)
    assert len(merged_V) - len(unique_edges(merged_Q)[0]) + len(merged_Q) == 2


def test_an_open_strip_is_left_alone() -> None:
    V = np.array([[x, y, 0.0] for y in range(2) for x in range(4)])
    Q = np.array([[x, x + 1, x + 5, x + 4] for x in range(3)])
    _, kept, count = merge_doublets(V, Q)
    assert count == 0
    assert kept is Q

"""Arcs and their smoothed tangents on polylines drawn by hand."""

from __future__ import annotations

import numpy as np
import pytest

from neurframe_cli.field.singular_arcs import singular_arcs, smoothed_tangents


def ring(n: int) -> tuple[np.ndarray, np.ndarray]:
    angle = 2 * np.pi * np.arange(n) / n
    V = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    return V, np.sort(np.stack([np.arange(n), (np.arange(n) + 1) % n], axis=1), axis=1)


def test_arcs_end_at_nodes():
    edges = np.array([[0, 1], [1, 2], [2, 3], [2, 4], [5, 6], [6, 7], [5, 7]])
    arcs = {tuple(arc.tolist()) for arc in singular_arcs(edges)}
    assert arcs == {(0, 1, 2), (2, 3), (2, 4), (5, 6, 7, 5)}
    assert singular_arcs(np.zeros((0, 2), np.int64)) == ()


def test_a_zigzag_along_a_line_has_the_tangent_of_the_line_up_to_its_steps():
    n = 30
    V = np.stack([0.5 * (np.arange(n) % 2), 0 * np.arange(n), np.arange(n) / 2], axis=1)
    edges = np.stack([np.arange(n - 1), np.arange(1, n)], axis=1)
    own = V[edges[:, 1]] - V[edges[:, 0]]
    assert np.degrees(np.arctan2(np.abs(own[:, 0]), own[:, 2])).min() == pytest.approx(45)
    smooth = smoothed_tangents(V, edges)
    assert np.degrees(np.arctan2(np.abs(smooth[:, 0]), smooth[:, 2]))[2:-2].max() < 12
    assert np.linalg.norm(smooth, axis=1) == pytest.approx(1.0)


@pytest.mark.parametrize("n", [3, 4, 5, 6, 40])
def test_loops_of_any_size_turn_with_their_edges(n):
    V, edges = ring(n)
    tangents = smoothed_tangents(V, edges)
    own = V[edges[:, 1]] - V[edges[:, 0]]
    assert (tangents * own).sum(1) == pytest.approx(np.linalg.norm(own, axis=1))

"""The three values that travel between the stages: surface, tet mesh, feature edges."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

# progress(fraction in [0, 1], text): what a long function calls as it goes
Progress = Callable[[float, str], None]


def silent(fraction: float, text: str) -> None:
    """A progress that shows nothing."""


def part(progress: Progress, begin: float, end: float) -> Progress:
    """Progress of a step that is the part from `begin` to `end` of the whole."""
    return lambda fraction, text: progress(begin + (end - begin) * fraction, text)


@dataclass(frozen=True)
class Surface:
    """A triangle mesh: V (n,3) float64 positions, F (m,3) int64, counter-clockwise seen from outside."""

    V: Floats
    F: Ints


@dataclass(frozen=True)
class TetMesh:
    """A tet mesh: V (n,3) float64 positions, T (m,4) int64, positive volume det(v1-v0, v2-v0, v3-v0) > 0."""

    V: Floats
    T: Ints


@dataclass(frozen=True)
class Features:
    """Feature edges of a mesh as a graph over its vertices.

    edges (k,2) int64 vertex pairs, smaller index first; chains: vertex sequences that together cover every edge once
    (closed chains repeat their first vertex at the end); corners (c,) int64: vertices where chains end or meet, and
    others that a mesh must keep.
    """

    edges: Ints = field(default_factory=lambda: np.zeros((0, 2), np.int64))
    chains: tuple[Ints, ...] = ()
    corners: Ints = field(default_factory=lambda: np.zeros(0, np.int64))


def as_surface(V: Any, F: Any) -> Surface:
    """Surface with the dtypes above, copied only where needed."""
    return Surface(np.ascontiguousarray(V, np.float64), np.ascontiguousarray(F, np.int64))


def as_tets(V: Any, T: Any) -> TetMesh:
    """TetMesh with the dtypes above, copied only where needed."""
    return TetMesh(np.ascontiguousarray(V, np.float64), np.ascontiguousarray(T, np.int64))

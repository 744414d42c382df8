"""Parts of a surface that lie in solid material and bound nothing: walls, and shells inside shells."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from neurframe_cli.mesh.arrays import Bools, Floats, Ints
from neurframe_cli.mesh.measure import enclosed_volume
from neurframe_cli.mesh.surface_edges import directed_edges

# winding numbers of closed surfaces are integers; the fast sum is good to a few per cent
DEEP_INSIDE = 0.75


@dataclass(frozen=True)
class InnerShells:
    """F (m,3) without the sheets, dropped: their triangles; nested: closed shells that lie in solid material."""

    F: Ints
    dropped: int
    nested: int


def inner_shells(V: Floats, F: Ints) -> InnerShells:
    """Takes out open sheets that lie inside closed parts, and counts the closed parts that bound nothing.

    Of a solid, only its boundary counts; a sheet inside would make the winding number doubtful on its one side, where
    fTetWild then digs a hollow.  A closed shell bounds something where it turns outward with nothing around it, or
    inward in one other.  Parts are what hangs together over vertices.
    """
    part, closed = _parts(F)
    if len(closed) == 1:
        return InnerShells(F, 0, 0)
    inside = _winding(V, F[closed[part]], V[F].mean(axis=1)) > DEEP_INSIDE
    sheets = [i for i in np.flatnonzero(~closed) if inside[part == i].all()]
    sheet = np.isin(part, sheets)
    boxes = _boxes(V, F, part)
    nested = sum(not _bounds(V, F, part, int(i), closed, boxes) for i in np.flatnonzero(closed))
    return InnerShells(F[~sheet], int(sheet.sum()), nested)


def _parts(F: Ints) -> tuple[Ints, Bools]:
    """Part of each triangle (m,), and for each part whether all its edges have two triangles."""
    import igl

    _, part = np.unique(np.asarray(igl.vertex_components(F))[F[:, 0]], return_inverse=True)
    directed = directed_edges(F)
    _, edge_of, count = np.unique(np.sort(directed, axis=1), axis=0, return_inverse=True, return_counts=True)
    closed = np.ones(int(part.max()) + 1, np.bool_)
    closed[part[np.flatnonzero(count[edge_of.reshape(-1)] != 2) // 3]] = False
    return part.reshape(-1), closed


def _winding(V: Floats, F: Ints, points: Floats) -> Floats:
    import igl

    return np.asarray(igl.fast_winding_number(V, F, points)) if len(F) else np.zeros(len(points))


def _boxes(V: Floats, F: Ints, part: Ints) -> tuple[Floats, Floats]:
    """Lowest and highest corner (p,3) of each part's bounding box."""
    count = int(part.max()) + 1
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(low, part, V[F].min(axis=1))
    np.maximum.at(high, part, V[F].max(axis=1))
    return low, high


def _bounds(V: Floats, F: Ints, part: Ints, i: int, closed: Bools, boxes: tuple[Floats, Floats]) -> bool:
    """Whether one side of a closed part is solid and the other is not.  Measured at its middle triangle."""
    low, high = boxes
    around = closed & (low <= low[i]).all(axis=1) & (high >= high[i]).all(axis=1)  # no other has it inside
    around[i] = False
    own = F[part == i]
    winding = 0.0
    if around.any():
        winding = float(np.median(_winding(V, F[around[part]], V[own].mean(axis=1))))
    return round(winding) == (0 if enclosed_volume(V, own) > 0 else 1)

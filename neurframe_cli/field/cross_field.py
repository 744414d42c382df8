"""Crosses on triangles from frames: the axis nearest the normal is dropped (paper, section 4.1.1)."""

from __future__ import annotations

import numpy as np

from neurframe_cli.mesh.arrays import Floats

# the other two axes after each, in the order that makes the three right-handed
_OTHERS = np.array([[1, 2], [2, 0], [0, 1]])


def crosses_of_frames(frames: Floats, normals: Floats) -> Floats:
    """Two orthonormal tangent vectors per triangle, right-handed about its normal: (m,3,3), (m,3) -> (m,2,3).

    Of the frame's axes the one nearest the unit normal is dropped.  The other two, projected to the tangent
    plane, are in general neither unit nor orthogonal: the nearest orthonormal pair favours neither.  The dropped
    axis is at most 54.8 degrees off the normal, so the projections always span the plane.  A triangle without
    area, normal zero, counts as one across the frame's third axis.
    """
    rows = np.arange(len(frames))
    normals = np.where(normals.any(axis=1, keepdims=True), normals, frames[:, :, 2])
    cosine = np.einsum("nij,ni->nj", frames, normals)
    dropped = np.abs(cosine).argmax(axis=1)
    first = frames[rows, :, _OTHERS[dropped, 0]]
    second = frames[rows, :, _OTHERS[dropped, 1]] * np.sign(cosine[rows, dropped])[:, None]
    return _nearest_orthonormal(_tangent(first, normals), _tangent(second, normals), normals)


def _tangent(v: Floats, normals: Floats) -> Floats:
    return np.asarray(v - np.einsum("ni,ni->n", v, normals)[:, None] * normals)


def _nearest_orthonormal(a: Floats, b: Floats, normals: Floats) -> Floats:
    """The right-handed orthonormal pair (c, n x c) nearest to tangent vectors a, b.

    |a - c|^2 + |b - n x c|^2 is least for c along a - n x b, as b.(n x c) = -(n x b).c.
    """
    c = a - np.cross(normals, b)
    c /= np.linalg.norm(c, axis=1, keepdims=True)
    return np.stack([c, np.cross(normals, c)], axis=1)

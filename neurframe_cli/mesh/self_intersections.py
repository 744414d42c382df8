"""Where a surface runs through itself."""

from __future__ import annotations

import numpy as np

from neurframe_cli.mesh.arrays import Bools, Floats, Ints

CHUNK = 1 << 18  # pairs tested at a time: some 100 MiB
# times coordinate times squared length: a volume that points in one plane can have from rounding, theirs included
ROUNDING = 32 * np.finfo(np.float64).eps


def self_intersections(V: Floats, F: Ints) -> int:
    """Number of pairs that `intersecting_pairs` finds."""
    return len(intersecting_pairs(V, F))


def intersecting_pairs(V: Floats, F: Ints) -> Ints:
    """Pairs (p,2) of triangles without a common vertex of which an edge of one passes through or touches the other.

    V (n,3), F (m,3).  In floating point: a touch off the coordinate planes may be missed, and so is an overlap of
    two triangles in one plane, though not that of the walls which end there.
    """
    pairs = _near_pairs(V, F)
    chunks = np.array_split(pairs, 1 + len(pairs) // CHUNK)
    return np.concatenate([chunk[_meet(V, F[chunk])] for chunk in chunks])


def _near_pairs(V: Floats, F: Ints) -> Ints:
    """(p,2) pairs of triangles whose boxes overlap and that share no vertex, the smaller number first."""
    from rtree import index

    low, high = V[F].min(axis=1), V[F].max(axis=1)
    boxes = np.column_stack([low, high])
    tree = index.Index(
        ((i, box, None) for i, box in enumerate(boxes.tolist())),
        properties=index.Property(dimension=3),
    )
    hits, counts = tree.intersection_v(low, high)  # type: ignore[no-untyped-call]  # rtree is half typed
    one = np.repeat(np.arange(len(F)), counts.astype(np.int64))
    pairs = np.column_stack([one, hits.astype(np.int64)])
    pairs = pairs[pairs[:, 0] < pairs[:, 1]]
    strangers = (F[pairs[:, 0]][:, :, None] != F[pairs[:, 1]][:, None, :]).all(axis=(1, 2))
    return np.asarray(pairs[strangers], np.int64)


def _meet(V: Floats, triangles: Ints) -> Bools:
    """(p,) whether an edge of one of the two triangles (p,2,3) reaches the other."""
    meeting = np.zeros(len(triangles), np.bool_)
    for mine, other in ((0, 1), (1, 0)):
        a, b, c = (V[triangles[:, other, i]] for i in range(3))
        for i in range(3):
            start, end = V[triangles[:, mine, i]], V[triangles[:, mine, (i + 1) % 3]]
            meeting |= _reaches(start, end, a, b, c)
    return meeting


def _reaches(start: Floats, end: Floats, a: Floats, b: Floats, c: Floats) -> Bools:
    """Whether the ends lie on both sides of the plane and the line turns the same way round all three edges.

    An end in the plane, or a line through an edge, counts; a line in the plane does not.
    """
    one, other = np.sign(_volume(a, b, c, start)), np.sign(_volume(a, b, c, end))
    turns = np.sign([_volume(start, end, a, b), _volume(start, end, b, c), _volume(start, end, c, a)])
    same_way = (turns.min(axis=0) >= 0) | (turns.max(axis=0) <= 0)
    return np.asarray((one * other <= 0) & (one != other) & same_way & (turns != 0).any(axis=0))


def _volume(a: Floats, b: Floats, c: Floats, d: Floats) -> Floats:
    """Six times the signed volume of tets, zero where that is no more than rounding.

    Without this, disjoint triangles of one slanted plane were said to cross.
    """
    sides = np.stack([b - a, c - a, d - a])
    volume = np.einsum("ij,ij->i", np.cross(sides[0], sides[1]), sides[2])
    coordinate = np.abs(np.stack([a, b, c, d])).max(axis=(0, 2))
    noise = ROUNDING * coordinate * np.einsum("kij,kij->ki", sides, sides).max(axis=0)
    return np.asarray(np.where(np.abs(volume) > noise, volume, 0.0))

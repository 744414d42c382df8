"""Points as tuples: a local operation on a mesh touches a handful, for which arrays are twenty times slower."""

from __future__ import annotations

import math

Vector = tuple[float, float, float]


def minus(a: Vector, b: Vector) -> Vector:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def plus(a: Vector, b: Vector) -> Vector:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def along(a: Vector, b: Vector, t: float) -> Vector:
    """a + t (b - a)."""
    return a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2])


def dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def length(a: Vector) -> float:
    return math.sqrt(dot(a, a))


def distance(a: Vector, b: Vector) -> float:
    return length(minus(a, b))


def unit(a: Vector) -> Vector:
    """a / |a|, zero for zero."""
    size = length(a)
    return (a[0] / size, a[1] / size, a[2] / size) if size > 0.0 else (0.0, 0.0, 0.0)


def cosine(a: Vector, b: Vector) -> float:
    """Of the angle between a and b, -1 where one of them is zero."""
    sizes = length(a) * length(b)
    return dot(a, b) / sizes if sizes > 0.0 else -1.0


def triangle_quality(a: Vector, b: Vector, c: Vector) -> float:
    """1 for an equilateral triangle, 0 for one without area: 4 sqrt(3) area / sum of the squared sides."""
    ab, bc, ca = minus(b, a), minus(c, b), minus(a, c)
    sides = dot(ab, ab) + dot(bc, bc) + dot(ca, ca)
    return 2.0 * math.sqrt(3.0) * length(cross(ab, minus(c, a))) / sides if sides > 0.0 else 0.0

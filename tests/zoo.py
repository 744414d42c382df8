"""A zoo of surfaces made by code: what people send, and what may become of each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints

Shape = tuple[Floats, Ints]
CUBE_F = np.array(
    [
        [0, 2, 1],
        [1, 2, 3],
        [4, 5, 6],
        [5, 7, 6],
        [0, 1, 4],
        [1, 5, 4],
        [2, 6, 3],
        [3, 6, 7],
        [0, 4, 2],
        [2, 4, 6],
        [1, 3, 5],
        [3, 7, 5],
    ]
)


def cube(low: float = 0.0, high: float = 1.0) -> Shape:
    """An axis-aligned cube, normals outwards."""
    return np.array([[x, y, z] for z in (low, high) for y in (low, high) for x in (low, high)]), CUBE_F


def together(*shapes: Shape) -> Shape:
    """All shapes as one surface, vertices not shared."""
    starts = np.cumsum([0, *(len(V) for V, _ in shapes)])
    return np.concatenate([V for V, _ in shapes]), np.concatenate(
        [F + start for (_, F), start in zip(shapes, starts, strict=False)]
    )


def moved(shape: Shape, *by: float) -> Shape:
    return shape[0] + np.array(by), shape[1]


def scaled(shape: Shape, *by: float) -> Shape:
    return shape[0] * np.array(by), shape[1]


def inside_out(shape: Shape) -> Shape:
    return shape[0], shape[1][:, ::-1]


def grid(rows: int, columns: int, place: Callable[[Floats, Floats], Floats], *, flip: bool = False) -> Shape:
    """Triangles of a rows x columns grid that closes on itself both ways; flip: mirrored where the rows close."""
    i, j = (a.ravel() for a in np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij"))

    def vertex(row: Ints, column: Ints) -> Ints:
        beyond = row >= rows
        column = np.where(beyond & flip, -column, column) % columns
        return np.asarray(row % rows * columns + column)

    corners = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)]
    F = np.concatenate([np.stack([corners[a] for a in k], axis=1) for k in ((0, 1, 2), (0, 2, 3))])
    return place(i / rows * 2 * np.pi, j / columns * 2 * np.pi), F


def torus() -> Shape:
    return grid(
        24,
        12,
        lambda u, v: np.stack([(3 + np.cos(v)) * np.cos(u), (3 + np.cos(v)) * np.sin(u), np.sin(v)], 1),
    )


def klein_bottle() -> Shape:
    """Lawson's figure-8 immersion: closed, not orientable, crosses itself."""

    def place(u: Floats, v: Floats) -> Floats:
        radius = 3 + np.cos(u / 2) * np.sin(v) - np.sin(u / 2) * np.sin(2 * v)
        height = np.sin(u / 2) * np.sin(v) + np.cos(u / 2) * np.sin(2 * v)
        return np.stack([radius * np.cos(u), radius * np.sin(u), height], 1)

    return grid(40, 20, place, flip=True)


def moebius_strip() -> Shape:
    n = 40
    u = np.arange(n) * 2 * np.pi / n
    edge = [
        np.stack(
            [(2 + w * np.cos(u / 2)) * np.cos(u), (2 + w * np.cos(u / 2)) * np.sin(u), w * np.sin(u / 2)], 1
        )
        for w in (-1, 1)
    ]
    i, following = np.arange(n), (np.arange(n) + 1) % n
    a, b = i, i + n
    c, d = following + np.where(following == 0, n, 0), following + np.where(following == 0, 0, n)
    return np.concatenate(edge), np.concatenate([np.stack([a, c, b], 1), np.stack([b, c, d], 1)])


def needles() -> Shape:
    """A cube whose faces are fans from points very near a corner: angles of a thousandth of a degree."""
    V, F = cube()
    fan_V, fan_F = [V], []
    for k, face in enumerate(F):
        a, b, c = V[face]
        fan_V.append((a + 1e-5 * (b - a) + 1e-5 * (c - a))[None])
        fan_F += [[face[0], face[1], 8 + k], [face[1], face[2], 8 + k], [face[2], face[0], 8 + k]]
    return np.concatenate(fan_V), np.array(fan_F)


def with_internal_wall() -> Shape:
    V, F = scaled(cube(), 2, 1, 1)
    wall = np.array([[1, y, z] for z in (0, 1) for y in (0, 1)])
    return together((V, F), (wall, np.array([[0, 1, 2], [1, 3, 2]])))


@dataclass(frozen=True)
class Animal:
    """codes: the exit codes that are right; volume: of the tets where there is one truth; edge_length: of the tets,
    as a fraction of the bounding-box diagonal."""

    shape: Shape
    codes: tuple[int, ...]
    volume: float | None = None
    edge_length: float = 0.15


def _with(value: float) -> Shape:
    V, F = cube()
    V = V.copy()
    V[3, 1] = value
    return V, F


NOTHING = (np.zeros((0, 3)), np.zeros((0, 3), np.int64))
ONE_TRIANGLE = (np.eye(3), np.array([[0, 1, 2]]))
SHEET = (np.array([[x, y, 0.0] for y in (0, 1) for x in (0, 1)]), np.array([[0, 1, 2], [1, 3, 2]]))
ZOO = {
    "nan": Animal(_with(np.nan), (2,)),
    "infinite": Animal(_with(np.inf), (2,)),
    "empty": Animal(NOTHING, (2,)),
    "one triangle": Animal(ONE_TRIANGLE, (2,)),
    "coplanar sheet": Animal(SHEET, (2,)),
    "doubled sheet": Animal(together(SHEET, inside_out(SHEET)), (2, 3)),
    "all points equal": Animal((np.ones((8, 3)), CUBE_F), (2,)),
    "index beyond the vertices": Animal((cube()[0], CUBE_F + 1), (2,)),
    "moebius strip": Animal(moebius_strip(), (2,)),
    "klein bottle": Animal(klein_bottle(), (0, 2, 3)),
    "box without a lid": Animal((cube()[0], CUBE_F[2:]), (2,)),
    "a small hole": Animal((torus()[0], torus()[1][1:]), (0,)),
    "crossing cubes": Animal(together(cube(), moved(cube(), 0.5, 0.5, 0.5)), (0,), 1.875),
    "nested shells": Animal(together(cube(), inside_out(cube(0.25, 0.75))), (0,), 1 - 0.125),
    "nested, both outwards": Animal(together(cube(), cube(0.25, 0.75)), (0,), 1.0),
    "touching at an edge": Animal(together(cube(), moved(cube(), 1, 1, 0)), (0,), 2.0),
    "touching at a vertex": Animal(together(cube(), moved(cube(), 1, 1, 1)), (0,), 2.0),
    "touching at a face": Animal(together(cube(), moved(cube(), 1, 0, 0)), (0,), 2.0),
    "inverted orientation": Animal(inside_out(torus()), (0,)),
    "tiny": Animal(scaled(cube(), 1e-9, 1e-9, 1e-9), (0,), 1e-27),
    "huge": Animal(scaled(cube(), 1e9, 1e9, 1e9), (0,), 1e27),
    "far from the origin": Animal(moved(cube(), 1e6, -1e6, 1e6), (0,), 1.0),
    "needle triangles": Animal(needles(), (0,), 1.0),
    "plate of no thickness": Animal(scaled(cube(), 1, 1, 1e-7), (2, 3)),
    "thin plate": Animal(scaled(cube(), 1, 1, 0.01), (0,), 0.01),
    "internal wall": Animal(with_internal_wall(), (0,), 2.0),
    "ten parts": Animal(together(*(moved(cube(), 2.0 * k, 0, 0) for k in range(10))), (0,), 10.0, 0.05),
}

"""Writes the sample models beside this file: `python samples/make_samples.py`.

Every model is made from formulas, so the same files come out on every machine.  Lengths are millimetres.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints, Surface, as_surface
from neurframe_cli.mesh.weld import weld
from neurframe_cli.mesh.write_mesh import write_surface

HERE = Path(__file__).resolve().parent
# the six sides of a hex in VTK order, outward
HEX_SIDES = np.array([[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]])
SEGMENTS = 48  # of a full circle
ROUNDING = 1e-9


def cube(side: float = 10.0) -> Surface:
    """One hex."""
    return _boundary_of_hexes([_box([0, side], [0, side], [0, side])])


def tetrahedron(edge: float = 10.0) -> Surface:
    """A regular one: no hex mesh of it exists without singular edges."""
    corners = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) * edge / np.sqrt(8)
    return as_surface(corners, [[1, 3, 2], [0, 2, 3], [0, 3, 1], [0, 1, 2]])


def cylinder(radius: float = 5.0, height: float = 15.0) -> Surface:
    """Two fans and a wall."""
    angles = 2 * np.pi * np.arange(SEGMENTS) / SEGMENTS
    circle = np.column_stack([radius * np.cos(angles), radius * np.sin(angles), np.zeros(SEGMENTS)])
    lift = np.array([0, 0, height])
    V = np.concatenate([circle, circle + lift, [0 * lift, lift]])
    a = np.arange(SEGMENTS)
    b = (a + 1) % SEGMENTS
    bottom, top = np.full(SEGMENTS, 2 * SEGMENTS), np.full(SEGMENTS, 2 * SEGMENTS + 1)
    fans = [(bottom, b, a), (top, a + SEGMENTS, b + SEGMENTS)]
    wall = [(a, b, b + SEGMENTS), (a, b + SEGMENTS, a + SEGMENTS)]
    return as_surface(V, np.concatenate([np.column_stack(triangles) for triangles in fans + wall]))


def torus(major: float = 10.0, minor: float = 4.0) -> Surface:
    """A surface without an edge."""
    around, across = np.meshgrid(np.arange(SEGMENTS), np.arange(SEGMENTS // 2), indexing="ij")
    u, v = 2 * np.pi * around.ravel() / SEGMENTS, 2 * np.pi * across.ravel() / (SEGMENTS // 2)
    ring = major + minor * np.cos(v)
    V = np.column_stack([ring * np.cos(u), ring * np.sin(u), minor * np.sin(v)])
    number = around * (SEGMENTS // 2) + across
    a, b = number.ravel(), np.roll(number, -1, axis=0).ravel()
    d, c = np.roll(number, -1, axis=1).ravel(), np.roll(number, (-1, -1), axis=(0, 1)).ravel()
    return as_surface(V, np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])]))


def bracket(
    width: float = 40.0, thickness: float = 8.0, height: float = 36.0, radius: float = 9.0
) -> Surface:
    """An L of two plates, the lower one with a round hole: a part that a hex mesher should get right.

    It is put together from hexes, so it is known to have a hex mesh.
    """
    steps = SEGMENTS // 4
    side = np.linspace(0, width, steps + 1)
    floor = [_plate_with_hole(width, thickness, radius, steps), _box([-thickness, 0], side, [0, thickness])]
    wall = _box([-thickness, 0], side, np.linspace(thickness, height, 4))
    return _boundary_of_hexes([*floor, wall])


def _box(x: Floats | list[float], y: Floats | list[float], z: Floats | list[float]) -> Floats:
    """(h,8,3) corners of the hexes of a rectilinear grid, in VTK order."""
    grid = np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=-1).astype(np.float64)
    return _hexes_of_grid(grid)


def _plate_with_hole(width: float, thickness: float, radius: float, steps: int) -> Floats:
    """Hexes of the square plate [0, width]^2 with a hole in its middle, `steps` along each side."""
    middle, hexes = width / 2, []
    along = np.linspace(-1, 1, steps + 1)
    for quarter in range(4):
        turn = np.array([[0, -1], [1, 0]]) if quarter % 2 else np.eye(2)
        turn = turn * (-1 if quarter > 1 else 1)
        outer = np.column_stack([np.ones(steps + 1), along]) * middle
        angle = along * np.pi / 4
        inner = np.column_stack([np.cos(angle), np.sin(angle)]) * radius
        blend = np.linspace(0, 1, 4)[:, None, None]
        layer = ((1 - blend) * inner + blend * outer) @ turn.T + middle
        levels = [np.concatenate([layer, np.full((*layer.shape[:2], 1), z)], axis=2) for z in (0, thickness)]
        hexes.append(_hexes_of_grid(np.stack(levels, axis=2)))
    return np.concatenate(hexes)


def _hexes_of_grid(grid: Floats) -> Floats:
    """(h,8,3) from a right-handed grid of points (a,b,c,3)."""
    low, high = slice(None, -1), slice(1, None)
    square = [(low, low), (high, low), (high, high), (low, high)]
    corners = [grid[(*ij, k)] for k in (low, high) for ij in square]
    return np.stack([corner.reshape(-1, 3) for corner in corners], axis=1)


def _boundary_of_hexes(hexes: list[Floats]) -> Surface:
    """The sides that belong to one hex only, as triangles."""
    corners = np.concatenate(hexes)
    V, H = weld(np.round(corners.reshape(-1, 3), 9), np.arange(8 * len(corners)).reshape(-1, 8), ROUNDING)
    sides = H[:, HEX_SIDES].reshape(-1, 4)
    _, side_of, count = np.unique(np.sort(sides, axis=1), axis=0, return_inverse=True, return_counts=True)
    outer = sides[count[side_of.reshape(-1)] == 1]
    used, quads = np.unique(outer, return_inverse=True)
    quads = quads.reshape(-1, 4)
    return as_surface(V[used], _split(quads))


def _split(quads: Ints) -> Ints:
    return np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


SAMPLES = {
    "cube.stl": cube,
    "tetrahedron.obj": tetrahedron,
    "cylinder.stl": cylinder,
    "torus.obj": torus,
    "bracket.stl": bracket,
}


def main() -> None:
    for name, make in SAMPLES.items():
        write_surface(HERE / name, make())
        print(HERE / name)


if __name__ == "__main__":
    main()

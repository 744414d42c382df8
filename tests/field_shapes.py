"""Small tet meshes and closed-form frame fields whose singular lines are known."""

from __future__ import annotations

from itertools import permutations

import numpy as np

from neurframe_cli.field.rotations import exponential
from neurframe_cli.mesh.arrays import Floats, Ints


def box_tets(cells: tuple[int, int, int]) -> tuple[Floats, Ints]:
    """The box [-1,1]^3 in cells of 6 positive tets each (Kuhn): V, T."""
    nx, ny, nz = (c + 1 for c in cells)
    grid = [np.linspace(-1, 1, n) for n in (nx, ny, nz)]
    V = np.stack(np.meshgrid(*grid, indexing="ij"), axis=-1).reshape(-1, 3)
    steps = np.array([ny * nz, nz, 1])
    corner = np.arange(nx * ny * nz).reshape(nx, ny, nz)[:-1, :-1, :-1].reshape(-1)
    tets = []
    for axes in permutations(range(3)):
        path = np.stack([corner + steps[list(axes[:k])].sum() for k in range(4)], axis=1)
        if np.linalg.det(np.eye(3)[list(axes)]) < 0:
            path = path[:, [0, 2, 1, 3]]
        tets.append(path)
    return V, np.concatenate(tets)


def cylinder_tets(across: int, up: int) -> tuple[Floats, Ints]:
    """The unit cylinder |xy| <= 1, |z| <= 1: the box with its square sections mapped to disks."""
    V, T = box_tets((across, across, up))
    x, y, z = V.T
    V = np.stack([x * np.sqrt(1 - y * y / 2), y * np.sqrt(1 - x * x / 2), z], axis=1)
    return V, T


def turned_about(axis: tuple[float, float, float], angle: Floats) -> Floats:
    """Frames (n,3,3): the standard one turned by angle (n,) about a unit axis."""
    return exponential(np.outer(angle, np.asarray(axis) / np.linalg.norm(axis)))


def polar_angle(points: Floats) -> Floats:
    return np.arctan2(points[:, 1], points[:, 0])


def four_line_frames(points: Floats, radius: float = 0.5) -> Floats:
    """The harmonic field of the unit cylinder: four vertical +1/4 lines at `radius` on the x and y axes.

    In the section the cross is exp(4 i phi) ~ (z^4 - r^4)(1 - r^4 z^4), which on |z| = 1 is a positive multiple of
    z^4: there one axis is normal.
    """
    z4 = (points[:, 0] + 1j * points[:, 1]) ** 4
    return turned_about((0, 0, 1), np.angle((z4 - radius**4) * (1 - radius**4 * z4)) / 4)

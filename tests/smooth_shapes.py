"""Closed-form quad and hex meshes with the triangulated surfaces that they are smoothed on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from neurframe_cli.mesh.arrays import Features, Floats, Ints, Surface
from neurframe_cli.mesh.features import features_by_angle
from neurframe_cli.mesh.quality.polygons import triangulated
from neurframe_cli.stages.smooth_hexes import boundary_quads


@dataclass(frozen=True)
class Shape:
    """V, cells (n,4 or 8): the exact mesh; surface and features to smooth it on."""

    V: Floats
    cells: Ints
    surface: Surface
    features: Features


def grid_quads(rows: int, columns: int) -> Ints:
    """Quads of a grid of (rows + 1) x (columns + 1) vertices, vertex i * (columns + 1) + j."""
    corner = (np.arange(rows)[:, None] * (columns + 1) + np.arange(columns)).ravel()
    return np.stack([corner, corner + 1, corner + columns + 2, corner + columns + 1], axis=1)


def grid_hexes(n: int) -> tuple[Floats, Ints]:
    """Unit cube of n^3 hexes in VTK order."""
    t = np.linspace(0.0, 1.0, n + 1)
    V = np.stack(np.meshgrid(t, t, t, indexing="ij"), axis=-1).reshape(-1, 3)
    i, j, k = (a.ravel() for a in np.meshgrid(*[np.arange(n)] * 3, indexing="ij"))

    def vertex(a: int, b: int, c: int) -> Ints:
        return ((i + a) * (n + 1) + j + b) * (n + 1) + k + c

    bottom = [vertex(0, 0, 0), vertex(1, 0, 0), vertex(1, 1, 0), vertex(0, 1, 0)]
    top = [vertex(0, 0, 1), vertex(1, 0, 1), vertex(1, 1, 1), vertex(0, 1, 1)]
    return V, np.stack(bottom + top, axis=1)


def compact(V: Floats, cells: Ints) -> tuple[Floats, Ints]:
    """Only the vertices that the cells use."""
    used, local = np.unique(cells, return_inverse=True)
    return V[used], local.reshape(cells.shape)


def cube_shell(n: int) -> tuple[Floats, Ints]:
    """Surface of the unit cube in 6 n^2 quads."""
    V, H = grid_hexes(n)
    return compact(V, boundary_quads(H))


def cube_hexes(n: int = 6, surface_n: int = 5) -> Shape:
    V, H = grid_hexes(n)
    surface_V, surface_Q = cube_shell(surface_n)
    surface = Surface(surface_V, triangulated(surface_Q))
    return Shape(V, H, surface, features_by_angle(surface.V, surface.F, 45.0))


def cube_quads(n: int = 6, surface_n: int = 5) -> Shape:
    V, Q = cube_shell(n)
    surface_V, surface_Q = cube_shell(surface_n)
    surface = Surface(surface_V, triangulated(surface_Q))
    return Shape(V, Q, surface, features_by_angle(surface.V, surface.F, 45.0))


def onto_sphere(V: Floats) -> Floats:
    """Points of the unit cube's surface, equiangular on the unit sphere."""
    P = np.tan((2 * V - 1) * np.pi / 4)
    return P / np.linalg.norm(P, axis=1, keepdims=True)


def sphere_quads(n: int = 12, surface_n: int = 20) -> Shape:
    V, Q = cube_shell(n)
    surface_V, surface_Q = cube_shell(surface_n)
    surface = Surface(onto_sphere(surface_V), triangulated(surface_Q))
    return Shape(onto_sphere(V), Q, surface, Features())


def sphere_hexes(n: int = 6, surface_n: int = 16) -> Shape:
    """A cube of hexes blown up to a ball; its corners and edges end up flat, so this needs smoothing."""
    V, H = grid_hexes(n)
    P = 2 * V - 1
    radius = np.abs(P).max(axis=1, keepdims=True)
    P = P * radius / np.maximum(np.linalg.norm(P, axis=1, keepdims=True), 1e-300)
    return Shape(P, H, sphere_quads(2, surface_n).surface, Features())


def torus_grid(rows: int, columns: int, ratio: float = 0.4) -> tuple[Floats, Ints]:
    u = 2 * np.pi * np.arange(rows) / rows
    v = 2 * np.pi * np.arange(columns) / columns
    U, W = (a.ravel() for a in np.meshgrid(u, v, indexing="ij"))
    V = np.stack(
        [(1 + ratio * np.cos(W)) * np.cos(U), (1 + ratio * np.cos(W)) * np.sin(U), ratio * np.sin(W)], axis=1
    )
    i, j = (a.ravel() for a in np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij"))
    ahead, beside = (i + 1) % rows, (j + 1) % columns
    Q = np.stack(
        [i * columns + j, ahead * columns + j, ahead * columns + beside, i * columns + beside], axis=1
    )
    return V, Q


def torus_quads(rows: int = 40, columns: int = 16) -> Shape:
    V, Q = torus_grid(rows, columns)
    surface_V, surface_Q = torus_grid(2 * rows + 3, 2 * columns + 5)
    return Shape(V, Q, Surface(surface_V, triangulated(surface_Q)), Features())


def disk_quads(n: int, m: int) -> tuple[Floats, Ints]:
    """Unit disk as an O-grid: an n x n square of quads in the middle, m rings of 4 n quads round it."""
    t = np.linspace(-0.5, 0.5, n + 1)
    core = np.stack(np.meshgrid(t, t, indexing="ij"), axis=-1).reshape(-1, 2)
    i = np.arange(n)
    rim = np.concatenate([i * (n + 1), n * (n + 1) + i, (n - i) * (n + 1) + n, n - i])
    angle = -3 * np.pi / 4 + np.pi / 2 * np.arange(4 * n) / n
    outer = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    s = np.arange(1, m + 1)[:, None, None] / m
    rings = ((1 - s) * core[rim] + s * outer).reshape(-1, 2)
    ids = np.concatenate([rim[None], len(core) + np.arange(4 * n * m).reshape(m, -1)])
    after = np.roll(ids, -1, axis=1)
    layers = np.stack([ids[:-1], ids[1:], after[1:], after[:-1]], axis=-1).reshape(-1, 4)
    square = grid_quads(n, n)[:, [0, 3, 2, 1]]
    return np.concatenate([core, rings]), np.concatenate([square, layers])


def cylinder_hexes(n: int = 4, m: int = 3, layers: int = 6, facets: int = 48) -> Shape:
    """Cylinder of radius 1, height 2, as an O-grid in each layer."""
    disk, quads = disk_quads(n, m)
    z = np.linspace(0.0, 2.0, layers + 1)
    V = np.concatenate([np.column_stack([disk, np.full(len(disk), h)]) for h in z])
    H = np.concatenate(
        [np.hstack([quads + k * len(disk), quads + (k + 1) * len(disk)]) for k in range(layers)]
    )
    surface = cylinder_surface(facets)
    return Shape(V, H, surface, features_by_angle(surface.V, surface.F, 45.0))


def cylinder_surface(facets: int) -> Surface:
    """Long thin triangles on the side and fans on the caps, as CAD programs export them."""
    angle = 2 * np.pi * (np.arange(facets) + 0.3) / facets
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    V = np.concatenate(
        [np.column_stack([ring, np.full(facets, h)]) for h in (0.0, 2.0)] + [[[0, 0, 0], [0, 0, 2.0]]]
    )
    i, j = np.arange(facets), np.roll(np.arange(facets), -1)
    side = [np.stack([i, j, j + facets], axis=1), np.stack([i, j + facets, i + facets], axis=1)]
    bottom, top = np.full(facets, 2 * facets), np.full(facets, 2 * facets + 1)
    caps = [np.stack([j, i, bottom], axis=1), np.stack([i + facets, j + facets, top], axis=1)]
    return Surface(V, np.concatenate(side + caps).astype(np.int64))


def patch_quads(n: int = 12, surface_n: int = 17) -> Shape:
    """Open square patch of a saddle."""

    def saddle(k: int) -> Floats:
        t = np.linspace(0.0, 1.0, k + 1)
        x, y = (a.ravel() for a in np.meshgrid(t, t, indexing="ij"))
        return np.stack([x, y, 0.3 * (x - 0.5) * (y - 0.5)], axis=1)

    surface = Surface(saddle(surface_n), triangulated(grid_quads(surface_n, surface_n)[:, ::-1]))
    return Shape(saddle(n), grid_quads(n, n)[:, ::-1].copy(), surface, Features())


def bump_quads(n: int = 10, surface_n: int = 40) -> Shape:
    """Plate with a bump, the quads finer on the bump."""

    def plate(t: Floats) -> Floats:
        x, y = (a.ravel() for a in np.meshgrid(t, t, indexing="ij"))
        return np.stack([x, y, 0.4 * np.exp(-12 * (x**2 + y**2))], axis=1)

    t = np.linspace(-1.0, 1.0, n + 1)
    surface_V = plate(np.linspace(-1.0, 1.0, surface_n + 1))
    surface = Surface(surface_V, triangulated(grid_quads(surface_n, surface_n)[:, ::-1]))
    V = plate(np.sign(t) * np.abs(t) ** 1.5)
    return Shape(V, grid_quads(n, n)[:, ::-1].copy(), surface, Features())


def jitter(V: Floats, amount: float, seed: int) -> Floats:
    """V moved by up to `amount` in every coordinate."""
    return V + amount * np.random.default_rng(seed).uniform(-1.0, 1.0, V.shape)

"""Tet meshes of any size, made by code: what load.py measures."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints, TetMesh
from neurframe_cli.mesh.check_tets import tet_volumes

# Kuhn: six tets round the diagonal of a cube, corners numbered by their bits
KUHN = np.array([[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]])
# a prism whose corners 0 < 1 < 2 lie below 3, 4, 5: neighbours cut their common side the same way
PRISM = np.array([[0, 1, 2, 5], [0, 1, 4, 5], [0, 3, 4, 5]])


def cube_tets(divisions: int) -> TetMesh:
    """The unit cube as 6 n^3 tets."""
    n = divisions + 1
    corner = np.indices((divisions,) * 3).reshape(3, -1)
    steps = np.array([[k & 1, k >> 1 & 1, k >> 2 & 1] for k in range(8)])
    numbers = [np.ravel_multi_index(tuple(corner + step[:, None]), (n, n, n)) for step in steps]
    V = np.indices((n, n, n)).reshape(3, -1).T / divisions
    return _turned(V.astype(np.float64), np.stack(numbers, axis=1)[:, KUHN].reshape(-1, 4))


def cylinder_tets(rings: int) -> TetMesh:
    """A cylinder of radius 1/2 and height 1 as 36 n^3 tets, in 2 n layers."""
    points, triangles = _disc(rings)
    layers = 2 * rings
    heights = np.repeat(np.arange(layers + 1) / layers, len(points))
    V = np.column_stack([np.tile(points / 2, (layers + 1, 1)), heights])
    low = np.sort(triangles, axis=1) + len(points) * np.arange(layers)[:, None, None]
    prisms = np.concatenate([low, low + len(points)], axis=2).reshape(-1, 6)
    return _turned(V, prisms[:, PRISM].reshape(-1, 4))


def write_exact_map(path: Path, mesh: TetMesh, hexes_per_side: int) -> None:
    """The identity of the cube, scaled, as .hexex: no transitions, no singularities."""
    parameters: Floats = (mesh.V * hexes_per_side)[mesh.T].reshape(len(mesh.T), 12)
    with path.open("w", encoding="ascii") as out:
        out.write(f"{len(mesh.V)}\n")
        np.savetxt(out, mesh.V, fmt="%.17g")
        out.write(f"{len(mesh.T)}\n")
        np.savetxt(out, np.hstack([mesh.T, parameters]), fmt=["%d"] * 4 + ["%.17g"] * 12)


def _disc(rings: int) -> tuple[Floats, Ints]:
    """Vertices of the unit disc on rings of 6, 12, 18, ... round the centre, and 6 n^2 triangles."""
    points = [np.zeros((1, 2))]
    triangles = []
    for ring in range(1, rings + 1):
        angle = np.arange(6 * ring) * (2 * np.pi / (6 * ring))
        points.append(ring / rings * np.column_stack([np.cos(angle), np.sin(angle)]))
        sector, j = (index.ravel() for index in np.indices((6, ring)))
        outer, inner = _on_ring(ring, sector * ring + j), _on_ring(ring - 1, sector * (ring - 1) + j)
        next_outer = _on_ring(ring, sector * ring + j + 1)
        triangles.append(np.column_stack([outer, next_outer, inner]))
        next_inner = _on_ring(ring - 1, sector * (ring - 1) + j + 1)
        between = np.column_stack([inner, next_outer, next_inner])
        triangles.append(between[j < ring - 1])
    return np.concatenate(points), np.concatenate(triangles)


def _on_ring(ring: int, place: Ints) -> Ints:
    """The numbers of the vertices at these places of a ring."""
    return np.zeros_like(place) if ring == 0 else 1 + 3 * ring * (ring - 1) + place % (6 * ring)


def _turned(V: Floats, T: Ints) -> TetMesh:
    """The mesh with every volume positive."""
    negative = tet_volumes(V, T) < 0
    T[negative] = T[negative][:, [0, 2, 1, 3]]
    return TetMesh(V, T)

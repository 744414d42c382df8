"""Edges, components and Euler characteristic of polygon meshes with one number of corners."""

from __future__ import annotations

import numpy as np

from neurframe_cli.mesh.arrays import Ints


def unique_edges(faces: Ints) -> tuple[Ints, Ints]:
    """Edges (e,2), smaller vertex first, of polygons (n,k), and how many polygons use each (e,)."""
    ends = np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2)
    edges, use = np.unique(np.sort(ends, axis=1), axis=0, return_counts=True)
    return edges, use


def valences(edges: Ints, n: int) -> Ints:
    """Number of edges at each of n vertices."""
    return np.bincount(edges.ravel(), minlength=n).astype(np.int64)


def count_components(edges: Ints) -> int:
    """Connected components of the vertices that occur in `edges`."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    used, local = np.unique(edges, return_inverse=True)
    pairs = local.reshape(-1, 2)
    graph = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(used), len(used)))
    return int(connected_components(graph, directed=False)[0])


def euler_characteristic(faces: Ints) -> int:
    """V - E + F over the vertices that occur in the polygons (n,k)."""
    return len(np.unique(faces)) - len(unique_edges(faces)[0]) + len(faces)


def topology(faces: Ints) -> tuple[int, int]:
    """Connected components and Euler characteristic of the polygons (n,k)."""
    return count_components(unique_edges(faces)[0]), euler_characteristic(faces)


def topology_problems(faces: Ints, against: Ints) -> list[str]:
    """What differs between the topology of the polygons `faces` (n,k) and that of `against` (m,l); empty if nothing."""
    found, expected = topology(faces), topology(against)
    if found == expected:
        return []
    problem = f"components, Euler characteristic {found} instead of {expected}"
    if expected[1] % 2 and (unique_edges(against)[1] == 2).all():
        problem += ", which no closed manifold has: the input touches itself in a vertex"
    return [problem]


def triangulated(quads: Ints) -> Ints:
    """Two triangles a quad (2n,3), first diagonal."""
    return np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])

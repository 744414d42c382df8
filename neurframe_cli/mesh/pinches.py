"""Hexes that touch in an edge or a vertex only, taken apart."""

from __future__ import annotations

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints, Surface
from neurframe_cli.mesh.hex_shell import HEX_FACES, hex_shell
from neurframe_cli.mesh.quality.polygons import topology, unique_edges


def has_topology_of(H: Ints, surface: Surface) -> bool:
    """Whether the shell of the hexes H (h,8) is closed, no edge in more than two of its quads, and has the components
    and the Euler characteristic of the surface."""
    quads = hex_shell(H).quads
    return bool((unique_edges(quads)[1] == 2).all()) and topology(quads) == topology(surface.F)


def separate_pinches(V: Floats, H: Ints) -> tuple[Floats, Ints]:
    """V (n,3) and H (h,8) with a vertex of its own for each group of hexes around a vertex that faces connect.

    A map whose boundary is folded back on itself leaves such hexes: their common edge is not one of the solid.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    one, other = _corners_across_faces(H)
    graph = coo_matrix((np.ones(len(one)), (one, other)), shape=(H.size, H.size))
    count, group = connected_components(graph, directed=False)
    apart = np.empty((count, 3))
    apart[group] = V[H.ravel()]
    return apart, np.asarray(group.reshape(H.shape), np.int64)


def _corners_across_faces(H: Ints) -> tuple[Ints, Ints]:
    """Pairs (k,), (k,) of corners, 8 h + i, that are one vertex of a face that two hexes share."""
    corners = (8 * np.arange(len(H))[:, None, None] + HEX_FACES).reshape(-1, 4)
    corners = np.take_along_axis(corners, np.argsort(H.ravel()[corners], axis=1), axis=1)
    vertices = H.ravel()[corners]
    order = np.lexsort(vertices.T)
    shared = (vertices[order][1:] == vertices[order][:-1]).all(axis=1)
    return corners[order[:-1][shared]].ravel(), corners[order[1:][shared]].ravel()

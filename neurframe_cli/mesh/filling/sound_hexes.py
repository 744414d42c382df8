"""Which hexes of a flawed mesh can stay: positive, inside, in nobody's way, and with a shell that can be continued."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from neurframe_cli.mesh.arrays import Bools, Floats, Ints, Surface
from neurframe_cli.mesh.hex_shell import HEX_FACES, hex_shell
from neurframe_cli.mesh.optimize.simplex_tree import SimplexTree
from neurframe_cli.mesh.quality.scaled_jacobian import hex_scaled_jacobians

ON_SURFACE = 0.1  # edge lengths between a corner of a quad and the surface that it covers
COVERS = 0.25  # ... between its centre and the surface
FACES_OUT = 0.5  # cosine between its normal and the surface's
TOO_NEAR = 0.2  # edge lengths between the surface and the centre of a quad that does not cover it
SMALLEST_GROUP = 8  # hexes; fewer in a void are in the way of good tets


@dataclass(frozen=True)
class SoundOptions:
    """least_jacobian: scaled Jacobian below which a hex is given up."""

    least_jacobian: float = 0.1


@dataclass(frozen=True)
class HexFaces:
    """All six faces of every hex: quads (6n,4) outward, size (6n,) mean edge length, covers (6n,) whether it lies on
    the surface, centre_distance (6n,); and of the vertices: distance (v,) to the surface."""

    quads: Ints
    size: Floats
    covers: Bools
    centre_distance: Floats
    distance: Floats


def measure_faces(V: Floats, H: Ints, surface: Surface) -> HexFaces:
    """How the faces of the hexes H (n,8) over V (v,3) lie to the surface."""
    tree = SimplexTree(surface.V, surface.F)
    quads = H[:, HEX_FACES].reshape(-1, 4)
    P = V[quads]
    size = np.linalg.norm(P - np.roll(P, -1, axis=1), axis=2).mean(axis=1)
    normal = np.cross(P[:, 2] - P[:, 0], P[:, 3] - P[:, 1])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    distance = np.full(len(V), np.inf)
    used = np.unique(H)
    distance[used] = tree.distances(V[used])
    centre_distance, triangles = tree.nearest(P.mean(axis=1))
    a, b, c = (tree.V[tree.S[triangles, i]] for i in range(3))
    under = np.cross(b - a, c - a)
    under /= np.maximum(np.linalg.norm(under, axis=1, keepdims=True), 1e-300)
    covers = (distance[quads].max(axis=1) < ON_SURFACE * size) & (centre_distance < COVERS * size)
    covers &= np.einsum("nd,nd->n", normal, under) > FACES_OUT
    return HexFaces(quads, size, covers, centre_distance, distance)


def sound_hexes(V: Floats, H: Ints, faces: HexFaces, surface: Surface, options: SoundOptions) -> Bools:
    """Which hexes (n,) are well shaped, inside the surface, and there only once."""
    import igl

    kept = hex_scaled_jacobians(V, H).min(axis=1) >= options.least_jacobian
    centres = V[H].mean(axis=1)
    kept &= np.asarray(igl.fast_winding_number(surface.V, surface.F, centres)) > 0.5
    quads = hex_shell(H[kept]).quads
    if len(quads):
        triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
        kept &= np.abs(np.asarray(igl.fast_winding_number(V, triangles, centres)) - 1.0) < 0.5
    return peeled(H, faces, kept)


def peeled(H: Ints, faces: HexFaces, kept: Bools) -> Bools:
    """The largest part of `kept` (n,) found whose shell is a manifold that leaves the surface along simple curves.

    Quads that face the void stay clear of the surface but for those curves.
    """
    kept = kept.copy()
    while kept.any():
        drop = _at_flaws(H, faces, kept)
        drop = drop if len(drop) else _small_groups(H, kept)
        if not len(drop):
            return kept
        kept[drop] = False
    return kept


def _at_flaws(H: Ints, faces: HexFaces, kept: Bools) -> Ints:
    """Hexes to give up because of where the shell is no manifold, pinches the void, or comes near the surface."""
    shell = hex_shell(H, kept)
    covers = faces.covers[shell.faces]
    free, size = shell.quads[~covers], faces.size[shell.faces][~covers]
    on_shell = np.zeros(len(faces.distance), bool)
    on_shell[np.unique(shell.quads[covers])] = True
    near = ((faces.distance[free] < ON_SURFACE * size[:, None]) & ~on_shell[free]).any(axis=1)
    near |= faces.centre_distance[shell.faces][~covers] < TOO_NEAR * size
    if near.any():
        return np.unique(shell.owner[~covers][near])
    exposed = np.bincount(shell.owner[~covers], minlength=len(H))
    drop = [_in_the_way(H, kept, v, exposed) for v in _pinched(shell.quads, covers).tolist()]
    return np.unique(np.concatenate(drop)) if drop else np.zeros(0, np.int64)


def _in_the_way(H: Ints, kept: Bools, v: int, exposed: Ints) -> Ints:
    """Of the hexes at v those that are not linked, across faces at v, with most of them; if all are, the one with the
    most quads in the void, exposed (n,)."""
    star: Ints = np.flatnonzero(kept & np.isin(H, v).any(axis=1))
    group = _linked(H[star], v)
    if group.max() > 0:
        return np.asarray(star[group != np.bincount(group).argmax()])
    return np.asarray(star[[exposed[star].argmax()]])


def _linked(cells: Ints, v: int | None = None) -> Ints:
    """Group (n,) of each hex (n,8): those that share a face, with the vertex v if one is given, are in one."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    keys = np.sort(cells[:, HEX_FACES].reshape(-1, 4), axis=1)
    order = np.lexsort(keys.T[::-1])
    same = (keys[order][1:] == keys[order][:-1]).all(axis=1)
    if v is not None:
        same &= (keys[order][1:] == v).any(axis=1)
    one, other = order[:-1][same] // 6, order[1:][same] // 6
    links = coo_matrix((np.ones(len(one)), (one, other)), shape=(len(cells), len(cells)))
    return np.asarray(connected_components(links, directed=False)[1])


def _pinched(quads: Ints, covers: Bools) -> Ints:
    """Vertices where the shell is no disc, or where the covering quads and the others change more than twice."""
    ends = np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2)
    edges, inverse, use = np.unique(np.sort(ends, axis=1), axis=0, return_inverse=True, return_counts=True)
    inverse = inverse.reshape(-1)
    crowded = edges[use != 2]
    covering = np.bincount(inverse, np.repeat(covers, 4), minlength=len(edges))
    rim = edges[(use == 2) & (covering == 1)]
    at_rim = np.bincount(rim.ravel(), minlength=int(quads.max()) + 1)
    return np.unique(
        np.concatenate([crowded.ravel(), np.flatnonzero(at_rim > 2), _several_fans(quads, inverse)])
    )


def _several_fans(quads: Ints, edge_of: Ints) -> Ints:
    """Vertices whose quads are not all linked across the edges at the vertex."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    # corner i of a quad has the edges i and i - 1; corners of one vertex that share an edge are linked
    corners = np.arange(quads.size)
    vertex = np.tile(quads.ravel(), 2)
    edge = np.concatenate([edge_of, np.roll(edge_of.reshape(-1, 4), 1, axis=1).ravel()])
    order = np.lexsort([edge, vertex])
    same = (vertex[order][1:] == vertex[order][:-1]) & (edge[order][1:] == edge[order][:-1])
    which = np.tile(corners, 2)[order]
    one, other = which[:-1][same], which[1:][same]
    links = coo_matrix((np.ones(len(one)), (one, other)), shape=(len(corners), len(corners)))
    fan = connected_components(links, directed=False)[1]
    pairs = np.unique(np.stack([quads.ravel(), fan], axis=1), axis=0)
    vertices, fans = np.unique(pairs[:, 0], return_counts=True)
    return np.asarray(vertices[fans > 1])


def _small_groups(H: Ints, kept: Bools) -> Ints:
    """Hexes of groups, linked across faces, of fewer than SMALLEST_GROUP."""
    numbers = np.flatnonzero(kept)
    group = _linked(H[numbers])
    return np.asarray(numbers[np.bincount(group)[group] < SMALLEST_GROUP])

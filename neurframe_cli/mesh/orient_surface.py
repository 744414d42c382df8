"""Which way the triangles of a surface face."""

from __future__ import annotations

import numpy as np

from neurframe_cli.mesh.arrays import Bools, Floats, Ints
from neurframe_cli.mesh.measure import enclosed_volume
from neurframe_cli.mesh.surface_edges import directed_edges

# an open patch is taken for a solid with a hole from this part of the volume of the ball with its area
LEAST_OF_BALL = 0.05


def orient(V: Floats, F: Ints) -> Ints:
    """F (m,3) with one orientation per patch, outward where a patch is closed.

    A patch is what is connected over edges with two triangles.  Where the file's own orientation has no
    contradiction it is kept, as only it can tell a cavity from a solid, unless a shell that lies in no other shell
    is inside out: that one is turned, with nothing else.  So is a patch with holes that encloses a volume all the
    same, measured from the middle of its border, if it hangs together with no other.
    """
    import igl

    if _consistent(F):
        patch = np.asarray(igl.orientable_patches(F), np.int64)
    else:
        F, patch = (np.asarray(array, np.int64) for array in igl.bfs_orient(F))
    inward = _inside_out(V, F, patch)
    return np.where(inward[patch][:, None], F[:, ::-1], F)


def _consistent(F: Ints) -> bool:
    """True when no two triangles run along an edge in the same direction."""
    directed = directed_edges(F)
    return len(np.unique(directed, axis=0)) == len(directed)


def _inside_out(V: Floats, F: Ints, patch: Ints) -> Bools:
    """(p,) which patches have a negative volume, and are not closed and inside another closed patch."""
    count = int(patch.max()) + 1
    closed = _closed(F, patch, count)
    alone = ~_joined(F, patch, count)
    volumes = np.array(
        [_volume(V, F[patch == i], bool(closed[i])) if closed[i] or alone[i] else 0.0 for i in range(count)]
    )
    inward = volumes < 0
    solids = [i for i in range(count) if volumes[i] > 0 and closed[i]]
    for i in np.flatnonzero(inward & closed):
        point = V[F[patch == i][:1]].mean(axis=1)
        inward[i] = not any(_contains(V, F[patch == j], point) for j in solids)
    return inward


def _volume(V: Floats, F: Ints, is_closed: bool) -> float:
    """Signed volume of a patch; 0 for an open one that encloses next to nothing, as a flat sheet does."""
    if is_closed:
        return enclosed_volume(V, F)
    directed = directed_edges(F)
    _, edge_of, count = np.unique(np.sort(directed, axis=1), axis=0, return_inverse=True, return_counts=True)
    border = directed[count[edge_of.reshape(-1)] == 1]
    if len(border) == 0:  # closed and not orientable, a Klein bottle: no volume has a meaning
        return 0.0
    middle = V[border].mean(axis=(0, 1))
    cones = np.cross(V[F[:, 1]] - V[F[:, 0]], V[F[:, 2]] - V[F[:, 0]])
    volume = float(np.einsum("ij,ij->", cones, V[F[:, 0]] - middle) / 6)
    ball = (np.linalg.norm(cones, axis=1).sum() / 2) ** 1.5 / (6 * np.sqrt(np.pi))
    return volume if abs(volume) > LEAST_OF_BALL * ball else 0.0


def _joined(F: Ints, patch: Ints, count: int) -> Bools:
    """(p,) which patches share an edge with another: only together they bound something."""
    edges, edge_of = np.unique(np.sort(directed_edges(F), axis=1), axis=0, return_inverse=True)
    incidence = np.unique(np.column_stack([edge_of.reshape(-1), np.repeat(patch, 3)]), axis=0)
    shared = np.bincount(incidence[:, 0], minlength=len(edges)) > 1
    joined = np.zeros(count, np.bool_)
    joined[incidence[shared[incidence[:, 0]], 1]] = True
    return joined


def _closed(F: Ints, patch: Ints, count: int) -> Bools:
    """(p,) whether every edge of a patch is run along as often one way as the other."""
    directed = directed_edges(F)
    edges, edge_of = np.unique(
        np.column_stack([np.repeat(patch, 3), np.sort(directed, axis=1)]), axis=0, return_inverse=True
    )
    sign = np.where(directed[:, 0] < directed[:, 1], 1, -1)
    balance = np.bincount(edge_of.reshape(-1), weights=sign, minlength=len(edges))
    closed = np.ones(count, np.bool_)
    closed[edges[balance != 0, 0]] = False
    return closed


def _contains(V: Floats, F: Ints, point: Floats) -> bool:
    """Whether the winding number of a closed surface round `point` (1,3) is one."""
    import igl

    corners = V[F]
    if not ((point > corners.min(axis=(0, 1))) & (point < corners.max(axis=(0, 1)))).all():
        return False
    return bool(igl.winding_number(V, F, point)[0] > 0.5)

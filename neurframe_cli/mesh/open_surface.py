"""Surfaces with holes: which still have an inside?"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from neurframe_cli.errors import InvalidMesh
from neurframe_cli.mesh.arrays import Floats, Ints, Surface
from neurframe_cli.mesh.surface_edges import directed_edges

# fTetWild fills where the winding number is above one half.  Holes of a tenth of the area leave it near one inside
# and near zero outside; of a box without its lid (a sixth) the inside is a matter of opinion.
LARGEST_HOLE_SHARE = 0.1


def hole_share(V: Floats, F: Ints) -> float:
    """Area of the flat lids over all open borders as a part of surface and lids together."""
    border = _border(F)
    if len(border) == 0:
        return 0.0
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    graph = coo_matrix((np.ones(len(border)), (border[:, 0], border[:, 1])), shape=(len(V), len(V)))
    loop = connected_components(graph, directed=False)[1][border[:, 0]]
    centred = V - V[border[:, 0]].mean(axis=0)
    sweeps = np.cross(centred[border[:, 0]], centred[border[:, 1]]) / 2
    lids = np.zeros((len(V), 3))
    np.add.at(lids, loop, sweeps)
    lid_area = float(np.linalg.norm(lids, axis=1).sum())
    areas = np.linalg.norm(np.cross(V[F[:, 1]] - V[F[:, 0]], V[F[:, 2]] - V[F[:, 0]]), axis=1) / 2
    return lid_area / (lid_area + float(areas.sum()))


def refuse_large_holes(surface: Surface, name: str | Path = "surface") -> list[str]:
    """Raises InvalidMesh for a surface that is too open to have an inside; a warning for one that is a bit open."""
    share = hole_share(surface.V, surface.F)
    if share > LARGEST_HOLE_SHARE:
        raise InvalidMesh(
            f"{name}: the surface is open: lids over its holes would be {share:.0%} of it, at most "
            f"{LARGEST_HOLE_SHARE:.0%} can be filled",
            hint="close the holes, or give the sheet a thickness",
        )
    return [f"the surface has holes ({share:.2%} of its area), which fTetWild closes"] if share > 0 else []


def _border(F: Ints) -> Ints:
    """(k,2) directed edges that no other triangle shares."""
    directed = directed_edges(F)
    _, edge_of, count = np.unique(np.sort(directed, axis=1), axis=0, return_inverse=True, return_counts=True)
    return np.asarray(directed[count[edge_of.reshape(-1)] == 1], np.int64)

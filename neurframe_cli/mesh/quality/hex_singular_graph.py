"""The singular graph of a hex mesh: interior edges of other than four hexes, as arcs between nodes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from neurframe_cli.mesh.arrays import Bools, Ints
from neurframe_cli.mesh.hex_shell import HEX_EDGES, hex_shell
from neurframe_cli.mesh.quality.polygons import unique_edges


@dataclass(frozen=True)
class HexSingularGraph:
    """edges (k,2): smaller vertex first; valence (k,): hexes at each; arc (k,): which arc each belongs to; nodes (n,):
    interior vertices where arcs end or meet."""

    edges: Ints
    valence: Ints
    arc: Ints
    nodes: Ints

    def summary(self) -> dict[str, Any]:
        """Numbers for a report."""
        valences, counts = np.unique(self.valence, return_counts=True)
        return {
            "interior_singular_edges": len(self.edges),
            "singular_edges_by_valence": dict(zip(map(str, valences.tolist()), counts.tolist(), strict=True)),
            "singular_arcs": int(self.arc.max(initial=-1)) + 1,
            "singular_nodes": len(self.nodes),
        }


def hex_singular_graph(H: Ints) -> HexSingularGraph:
    """The graph of hexes H (n,8) in VTK order; an arc goes on where exactly two edges of one valence meet inside."""
    all_edges, hexes = np.unique(np.sort(H[:, HEX_EDGES].reshape(-1, 2), axis=1), axis=0, return_counts=True)
    shell_edges = unique_edges(hex_shell(H).quads)[0]
    singular = (hexes != 4) & ~_among(all_edges, shell_edges)
    edges, valence = all_edges[singular].astype(np.int64), hexes[singular].astype(np.int64)
    on_shell = np.zeros(int(H.max()) + 1, bool)
    on_shell[shell_edges] = True
    passing = _passing(edges, valence, on_shell)
    met = np.setdiff1d(np.unique(edges), np.flatnonzero(passing))
    return HexSingularGraph(edges, valence, _arcs(edges, passing), met[~on_shell[met]])


def _among(edges: Ints, others: Ints) -> Bools:
    size = int(edges.max(initial=0)) + 1
    return np.isin(edges @ np.array([size, 1]), others @ np.array([size, 1]))


def _passing(edges: Ints, valence: Ints, on_shell: Bools) -> Bools:
    """Which vertices an arc passes through."""
    count = np.bincount(edges.ravel(), minlength=len(on_shell))
    low, high = np.full(len(on_shell), np.iinfo(np.int64).max), np.zeros(len(on_shell), np.int64)
    np.minimum.at(low, edges, valence[:, None])
    np.maximum.at(high, edges, valence[:, None])
    return np.asarray((count == 2) & (low == high) & ~on_shell)


def _arcs(edges: Ints, passing: Bools) -> Ints:
    """Number of the arc of each edge: edges that share a passing vertex are on one."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    ends, edge = edges.ravel(), np.repeat(np.arange(len(edges)), 2)
    kept = passing[ends]
    order = np.argsort(ends[kept], kind="stable")
    pairs = edge[kept][order].reshape(-1, 2)
    links = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(edges), len(edges)))
    return np.asarray(connected_components(links, directed=False)[1], np.int64)

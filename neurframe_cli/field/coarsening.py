"""Coarser versions of the energy: tets joined into connected clusters that share one coefficient vector."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from neurframe_cli.field.energy_terms import AlignmentTerm, EnergyTerms
from neurframe_cli.mesh.arrays import Floats, Ints

# voxel width in median dual edges; 4 makes clusters of about 15 tets
CLUSTER_WIDTH = 4.0


def coarsen(terms: EnergyTerms) -> tuple[EnergyTerms, Ints]:
    """(terms over clusters, cluster of every tet (m,)).

    A cluster is a connected part of the dual graph inside one voxel, so nothing joins across a thin gap.  Only dual
    edges between clusters remain.  Their weights shrink by length of dual edge / distance of cluster centers: a
    piecewise constant field takes all of its change in these few edges, and would be too stiff (by that ratio).
    """
    cluster = _clusters(terms)
    count = int(cluster.max()) + 1
    size = np.bincount(cluster, minlength=count)
    centers = np.stack([np.bincount(cluster, x, count) / size for x in terms.points.T], axis=1)
    edges = cluster[terms.dual_edges]
    between = edges[:, 0] != edges[:, 1]
    edges = edges[between]
    fine = _lengths(terms.points, terms.dual_edges[between])
    shrink = np.minimum(1.0, fine / np.maximum(_lengths(centers, edges), 1e-12))
    coarse = replace(
        terms,
        points=centers,
        dual_edges=edges,
        smooth_weights=terms.smooth_weights[between] * shrink,
        boundary=_moved(terms.boundary, cluster),
        feature=_moved(terms.feature, cluster),
    )
    return coarse, cluster


def _clusters(terms: EnergyTerms) -> Ints:
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    m, edges = len(terms.points), terms.dual_edges
    width = CLUSTER_WIDTH * float(np.median(_lengths(terms.points, edges)))
    voxel = np.floor(terms.points / width).astype(np.int64)
    first, second = edges[(voxel[edges[:, 0]] == voxel[edges[:, 1]]).all(axis=1)].T
    graph = coo_matrix((np.ones(len(first)), (first, second)), (m, m))
    _, cluster = connected_components(graph, directed=False)
    return np.asarray(cluster, np.int64)


def _lengths(points: Floats, edges: Ints) -> Floats:
    return np.asarray(np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1))


def _moved(term: AlignmentTerm, cluster: Ints) -> AlignmentTerm:
    return replace(term, tets=cluster[term.tets])

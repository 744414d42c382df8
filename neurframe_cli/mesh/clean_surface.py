"""From the triangles of a file to a surface: welded, without doubles, oriented outward."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from neurframe_cli.errors import InvalidMesh
from neurframe_cli.mesh.arrays import Floats, Ints, Surface, as_surface
from neurframe_cli.mesh.check_tets import check_indices
from neurframe_cli.mesh.inner_shells import inner_shells
from neurframe_cli.mesh.measure import box_diagonal
from neurframe_cli.mesh.orient_surface import orient
from neurframe_cli.mesh.self_intersections import self_intersections
from neurframe_cli.mesh.surface_edges import surface_edges
from neurframe_cli.mesh.weld import weld

# text formats round to six digits: corners that are one point may differ by this much of the diagonal
ROUNDING = 1e-6
# below this the squares and cubes of lengths underflow
SMALLEST_DIAGONAL = 1e-90


@dataclass(frozen=True)
class CleaningReport:
    """What was found and done.

    welded: vertices that fell together or were unused; degenerate, duplicate: triangles dropped; turned: triangles
    turned round; inner_sheets: triangles of walls inside the solid, dropped; nested: closed shells in solid material,
    which bound nothing; open_edges, nonmanifold_edges: edges with one triangle, with three or more; components: parts
    connected over vertices; euler: V - E + F; genus: sum over the parts of a closed manifold surface, None otherwise;
    self_intersections: pairs of triangles that meet without a common vertex.
    """

    welded: int
    degenerate: int
    duplicate: int
    turned: int
    inner_sheets: int
    nested: int
    open_edges: int
    nonmanifold_edges: int
    components: int
    euler: int
    genus: int | None
    self_intersections: int

    @property
    def closed(self) -> bool:
        return self.open_edges == 0

    @property
    def bounds_a_solid(self) -> bool:
        """Closed, manifold, nowhere through itself or within itself: inside and outside are beyond doubt."""
        return self.genus is not None and self.self_intersections == 0 and self.nested == 0


def clean_surface(surface: Surface, name: str | Path = "surface") -> tuple[Surface, CleaningReport]:
    """A surface for the tetrahedralizer and what was done to get it.

    Equal vertices are welded, and nearly equal ones where that closes gaps; triangles with a repeated vertex and
    doubles are dropped; each patch gets one orientation, each closed shell the one that makes solid what it bounds.
    Slivers without area stay: dropping them would open the surface.  Raises InvalidMesh.
    """
    _refuse_unusable(surface, name)
    V, F = weld(surface.V, surface.F, 0.0)
    if (surface_edges(V, F).face_count == 1).any():
        V, F = _weld_gaps(V, F)
    F, degenerate, duplicate = _drop(F)
    if len(F) == 0:
        raise InvalidMesh(f"{name}: all {len(surface.F)} triangles are degenerate")
    used, F = np.unique(F, return_inverse=True)
    V, F = V[used], F.reshape(-1, 3)
    oriented = orient(V, F)
    turned = int((oriented != F).any(axis=1).sum())
    inner = inner_shells(V, oriented)
    used, F = np.unique(inner.F, return_inverse=True)
    V, F = V[used], F.reshape(-1, 3)
    counts = (len(surface.V) - len(V), degenerate, duplicate, turned, inner.dropped, inner.nested)
    return as_surface(V, F), _report(V, F, counts)


def _refuse_unusable(surface: Surface, name: str | Path) -> None:
    """What makes fTetWild crash or return nothing."""
    if len(surface.F) == 0:
        raise InvalidMesh(f"{name}: the surface has no triangles")
    check_indices(surface.V, surface.F, name, "triangle")
    diagonal = box_diagonal(surface.V[surface.F.ravel()])
    if diagonal < SMALLEST_DIAGONAL:
        raise InvalidMesh(f"{name}: the bounding box has the diagonal {diagonal:g}, no surface to work on")


def _weld_gaps(V: Floats, F: Ints) -> tuple[Floats, Ints]:
    """Welds within the rounding of text formats, unless that closes no gap."""
    diagonal = box_diagonal(V)
    welded_V, welded_F = weld(V, F, ROUNDING * diagonal)
    before = (surface_edges(V, _drop(F)[0]).face_count == 1).sum()
    after = (surface_edges(welded_V, _drop(welded_F)[0]).face_count == 1).sum()
    return (welded_V, welded_F) if after < before else (V, F)


def _drop(F: Ints) -> tuple[Ints, int, int]:
    """The triangles with three different vertices, each set of vertices once; how many went for each reason."""
    corners = np.sort(F, axis=1)
    proper = (np.diff(corners, axis=1) > 0).all(axis=1)
    kept = F[proper]
    _, first = np.unique(corners[proper], axis=0, return_index=True)
    return kept[np.sort(first)], int((~proper).sum()), len(kept) - len(first)


def _report(V: Floats, F: Ints, counts: tuple[int, int, int, int, int, int]) -> CleaningReport:
    import igl
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    edges = surface_edges(V, F)
    a, b = edges.edges.T
    graph = coo_matrix((np.ones(len(a)), (a, b)), shape=(len(V), len(V)))
    components = int(connected_components(graph, directed=False)[0])
    euler = len(V) - len(edges.edges) + len(F)
    open_edges, nonmanifold = int((edges.face_count == 1).sum()), int((edges.face_count > 2).sum())
    manifold = open_edges == 0 and nonmanifold == 0 and bool(igl.is_vertex_manifold(F).all())
    genus = components - euler // 2 if manifold else None
    return CleaningReport(
        *counts, open_edges, nonmanifold, components, euler, genus, self_intersections(V, F)
    )

"""The part of the surface that no hex covers, cut out along the rim of the hexes."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from neurframe_cli.mesh.arrays import Bools, Floats, Ints, Surface
from neurframe_cli.mesh.filling.editable_surface import Edge, EditableSurface
from neurframe_cli.mesh.filling.insert_curves import Blocked, connect, insert_points
from neurframe_cli.mesh.optimize.simplex_tree import SimplexTree


class CutFailed(Exception):
    """The surface could not be cut along the rim; `vertices` of the hex mesh are where."""

    def __init__(self, vertices: set[int]) -> None:
        super().__init__(f"{len(vertices)} vertices of the rim")
        self.vertices = vertices


@dataclass(frozen=True)
class Uncovered:
    """patch: the part of the surface; hex_vertex: the vertex of the hex mesh that a vertex of the patch is."""

    patch: EditableSurface
    hex_vertex: dict[int, int]


def rim_edges(quads: Ints, covers: Bools) -> Ints:
    """Directed edges (r,2) of the covering quads (f,4) at which a quad that faces a void begins."""
    ends = np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2)
    covering = np.repeat(covers, 4)
    # of a manifold shell: the edge runs the other way in the quad beside it
    size = int(quads.max(initial=0)) + 1
    forward = ends[covering] @ np.array([size, 1])
    backward = ends[~covering] @ np.array([1, size])
    return np.asarray(ends[covering][np.isin(forward, backward)])


def uncovered_part(
    V: Floats, quads: Ints, covers: Bools, size: Floats, surface: Surface, sharp: Ints
) -> Uncovered:
    """The surface without what lies under the covering ones of the shell's quads (f,4) of the hex mesh V (v,3).

    size (f,): edge length of the quads; sharp (k,2): feature edges of the surface.  Raises CutFailed.
    """
    rim = rim_edges(quads, covers)
    cut = EditableSurface(surface.V, surface.F, sharp)
    vertices = np.unique(rim)
    scale = np.zeros(len(V))
    np.maximum.at(scale, quads[covers], size[covers][:, None])
    tree = SimplexTree(surface.V, surface.F)
    _, triangles = tree.nearest(V[vertices])
    placed = insert_points(cut, V[vertices], triangles, scale[vertices])
    of_hex = dict(zip(vertices.tolist(), placed, strict=True))
    locked, pieces = _cut_along(cut, rim, of_hex)
    faces = _open_side(cut, locked, pieces, of_hex)
    faces |= _untouched(cut, locked, faces, _covered_triangles(V, quads[covers], tree))
    return Uncovered(_sub_surface(cut, faces), {v: w for w, v in of_hex.items()})


def _cut_along(cut: EditableSurface, rim: Ints, of_hex: dict[int, int]) -> tuple[set[Edge], list[list[int]]]:
    """A path for each edge of the rim: the edges of all, and the vertices of each."""
    locked: set[Edge] = set()
    pieces = []
    failed: set[int] = set()
    closed = set(of_hex.values())
    for a, b in rim.tolist():
        try:
            pieces.append(connect(cut, of_hex[a], of_hex[b], closed, locked))
        except Blocked:
            failed |= {a, b}
    if failed:
        raise CutFailed(failed)
    return locked, pieces


def _open_side(
    cut: EditableSurface, locked: set[Edge], pieces: list[list[int]], of_hex: dict[int, int]
) -> set[int]:
    """Faces that are reached from the right-hand sides of the paths; raises CutFailed where that is a left one, too."""
    steps = [step for path in pieces for step in itertools.pairwise(path)]
    left = {cut.half[a, b] for a, b in steps if (a, b) in cut.half}
    right = {cut.half[b, a] for a, b in steps if (b, a) in cut.half}
    faces = _flood(cut, locked, right)
    # where the hexes cover a place twice a face is on both sides at once; else the whole of what leaked is to blame
    wrong = (right & left) or (faces & left)
    if wrong:
        corners = {v for face in wrong for v in cut.faces[face]}
        raise CutFailed({w for w, v in of_hex.items() if v in corners})
    return faces


def _flood(cut: EditableSurface, locked: set[Edge], seeds: set[int]) -> set[int]:
    """All faces that are linked to the seeds across edges that are not locked."""
    found, todo = set(seeds), sorted(seeds)
    while todo:
        a, b, c = cut.faces[todo.pop()]
        for x, y in ((a, b), (b, c), (c, a)):
            beside = cut.half.get((y, x))
            if beside is not None and beside not in found and tuple(sorted((x, y))) not in locked:
                found.add(beside)
                todo.append(beside)
    return found


def _covered_triangles(V: Floats, covering: Ints, tree: SimplexTree) -> set[int]:
    """Triangles of the input closest to the centres of the covering quads."""
    if not len(covering):
        return set()
    return set(tree.nearest(V[covering].mean(axis=1))[1].tolist())


def _untouched(cut: EditableSurface, locked: set[Edge], known: set[int], covered: set[int]) -> set[int]:
    """Faces of components of the surface that no rim touches and no quad covers."""
    found: set[int] = set()
    seen = set(known)
    at_rim = {v for edge in locked for v in edge}
    for face in sorted(cut.faces):
        if face in seen:
            continue
        component = _flood(cut, locked, {face})
        seen |= component
        touched = any(v in at_rim for f in component for v in cut.faces[f])
        if not touched and not any(cut.parent[f] in covered for f in component):
            found |= component
    return found


def _sub_surface(cut: EditableSurface, faces: set[int]) -> EditableSurface:
    """The faces alone, with the same vertex numbers."""
    V, _, sharp = cut.arrays()
    F = np.array([cut.faces[face] for face in sorted(faces)], np.int64).reshape(-1, 3)
    return EditableSurface(V, F, sharp[np.isin(sharp, F).all(axis=1)] if len(sharp) else sharp)

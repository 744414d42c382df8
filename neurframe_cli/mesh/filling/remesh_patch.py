"""A patch of a surface with straight pieces of its border, and triangles about as large as the hexes beside it."""

from __future__ import annotations

from neurframe_cli.mesh.filling.editable_surface import Edge, EditableSurface, corner_normal, sorted_edge
from neurframe_cli.mesh.filling.vectors import cosine, distance, minus, triangle_quality

SHORT, LONG = 0.6, 1.5  # of the edge length of the hexes
ROUNDS, SPLITTING = 5, 2  # the first two rounds split edges as well; later that would only spoil what is good
BENT = 0.94  # least cosine between the normals of a face before and after a collapse; 0.8 took 4 % of a thin torus
TURNED = 0.8  # ... of the two pieces of a sharp curve of which one goes
BENT_AT_BORDER = 0.3  # ... where a border becomes straight, which may cut off a bulge
FLAT = 0.94  # least cosine between the normals of two faces whose edge may be flipped
LEAST_QUALITY = 0.05  # that a collapse may leave


def remesh_patch(patch: EditableSurface, fixed: set[int], edge_length: float) -> set[int]:
    """Collapses, splits and flips in place; vertices `fixed` of the border stay, all others there go.

    Corners and curves of the sharp edges stay where they are.  Returns the border vertices that could not go.
    """
    left: set[int] = set()
    for turn in range(ROUNDS):
        _collapse_short(patch, fixed, SHORT * edge_length)
        left = _straighten(patch, fixed)
        _flip_all(patch)
        if turn < SPLITTING:
            _split_long(patch, LONG * edge_length)
            _flip_all(patch)
    return left


def _border(patch: EditableSurface) -> set[int]:
    return {v for (a, b) in patch.half if (b, a) not in patch.half for v in (a, b)}


def _straighten(patch: EditableSurface, fixed: set[int]) -> set[int]:
    """Collapses the border vertices that are not fixed into the next ones; returns those that are left."""
    left = _border(patch) - fixed
    for v in sorted(left):
        beside = [w for w in sorted(patch.neighbors(v)) if patch.is_boundary(v, w)]
        beside.sort(key=lambda w: distance(patch.points[v], patch.points[w]))
        for w in beside:
            _make_collapsible(patch, v, w)
            if patch.can_collapse(v, w) and _stays_flat(patch, v, w, BENT_AT_BORDER, 0.0):
                patch.collapse(v, w)
                left.discard(v)
                break
    return left


def _make_collapsible(patch: EditableSurface, v: int, w: int) -> None:
    """Halves the edges from v to those common neighbours that keep it from collapsing into w."""
    for x in sorted((patch.neighbors(v) & patch.neighbors(w)) - patch.opposites(v, w)):
        if patch.has_edge(v, x) and not patch.is_boundary(v, x):
            patch.halve_edge(v, x)


def _collapse_short(patch: EditableSurface, fixed: set[int], shortest: float) -> None:
    """Collapses edges below `shortest`, the shortest first."""
    border = _border(patch)
    edges = sorted({sorted_edge(a, b) for a, b in patch.half}, key=lambda e: _length(patch, e))
    for edge in edges:
        if not patch.has_edge(*edge) or _length(patch, edge) >= shortest:
            continue
        for v, w in (edge, edge[::-1]):
            if v in fixed or v in border or not _may_leave(patch, v, w):
                continue
            if patch.can_collapse(v, w) and _stays_flat(patch, v, w, BENT, LEAST_QUALITY):
                patch.collapse(v, w)
                break


def _may_leave(patch: EditableSurface, v: int, w: int) -> bool:
    """Whether sharp curves stay where they are when v becomes w."""
    curve = patch.sharp_neighbors(v)
    if not curve:
        return True
    if len(curve) != 2 or w not in curve:
        return False
    a, b = curve
    p, q, r = patch.points[a], patch.points[v], patch.points[b]
    return cosine(minus(q, p), minus(r, q)) > TURNED


def _stays_flat(patch: EditableSurface, v: int, w: int, least_cosine: float, least_quality: float) -> bool:
    """Whether no face at v turns much, or becomes a sliver that was none, when v becomes w."""
    mean = (0.0, 0.0, 0.0)
    for face in patch.around[v]:
        n = patch.normal(face)
        mean = (mean[0] + n[0], mean[1] + n[1], mean[2] + n[2])
    for face in patch.around[v]:
        corners = patch.faces[face]
        if w in corners:
            continue
        old = [patch.points[x] for x in corners]
        new = [patch.points[w if x == v else x] for x in corners]
        before, quality = patch.normal(face), triangle_quality(*old)
        reference = before if quality > LEAST_QUALITY else mean
        if cosine(corner_normal(*new), reference) < least_cosine:
            return False
        if triangle_quality(*new) < min(least_quality, quality):
            return False
    return True


def _split_long(patch: EditableSurface, longest: float) -> None:
    edges = sorted({sorted_edge(a, b) for a, b in patch.half}, key=lambda e: -_length(patch, e))
    for edge in edges:
        if _length(patch, edge) <= longest:
            return
        if patch.has_edge(*edge) and not patch.is_boundary(*edge):
            patch.halve_edge(*edge)


def _flip_all(patch: EditableSurface) -> None:
    """Flips flat edges while that makes the worse of the two triangles better."""
    for edge in sorted({sorted_edge(a, b) for a, b in patch.half}):
        if edge not in patch.sharp and all(pair in patch.half for pair in (edge, edge[::-1])):
            _flip_if_better(patch, edge)


def _flip_if_better(patch: EditableSurface, edge: Edge) -> None:
    a, b = edge
    c, d = patch.opposite(a, b), patch.opposite(b, a)
    if c is None or d is None or patch.has_edge(c, d):
        return
    p = {v: patch.points[v] for v in (a, b, c, d)}
    old = (p[a], p[b], p[c]), (p[b], p[a], p[d])
    new = (p[a], p[d], p[c]), (p[d], p[b], p[c])
    worst_old, worst_new = (min(triangle_quality(*t) for t in pair) for pair in (old, new))
    if worst_new <= worst_old + 1e-9:
        return
    flat = cosine(corner_normal(*old[0]), corner_normal(*old[1])) > FLAT or worst_old < LEAST_QUALITY
    same_side = all(
        cosine(corner_normal(*n), corner_normal(*o)) > BENT_AT_BORDER for n in new for o in old[:1]
    )
    if flat and same_side and cosine(corner_normal(*new[0]), corner_normal(*new[1])) > BENT_AT_BORDER:
        patch.flip(a, b)


def _length(patch: EditableSurface, edge: Edge) -> float:
    return distance(patch.points[edge[0]], patch.points[edge[1]])

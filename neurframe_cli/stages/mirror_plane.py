"""The mirror plane of a surface, and the half of the surface on its positive side."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from neurframe_cli.errors import UsageError
from neurframe_cli.mesh.arrays import Features, Floats, Ints, Surface
from neurframe_cli.mesh.features import features_from_edges
from neurframe_cli.mesh.measure import box_diagonal
from neurframe_cli.mesh.optimize.simplex_tree import SimplexTree
from neurframe_cli.mesh.quality.distance import sample_surface
from neurframe_cli.mesh.surface_edges import directed_edges

AXES = {"x": 0, "y": 1, "z": 2}
SAMPLES = 10_000


@dataclass(frozen=True)
class MirrorPlane:
    """The plane on which coordinate `axis` is `offset`."""

    axis: int
    offset: float

    def height(self, V: Floats) -> Floats:
        """Signed distance (n,) of points V (n,3)."""
        return np.asarray(V[:, self.axis] - self.offset)

    def reflect(self, vectors: Floats) -> Floats:
        """Mirror images of vectors (..., 3), which have no place."""
        mirrored = vectors.copy()
        mirrored[..., self.axis] *= -1.0
        return mirrored

    def mirror(self, V: Floats) -> Floats:
        """Mirror images of points V (n,3)."""
        mirrored = V.copy()
        mirrored[:, self.axis] = 2 * self.offset - V[:, self.axis]
        return mirrored


@dataclass(frozen=True)
class HalfSurface:
    """A surface cut off at a plane: `parents` (m,) the triangle of the whole that each triangle lies in; vertex i
    lies at share (n,) of the way between the two vertices ends (n,2) of the whole."""

    surface: Surface
    parents: Ints
    ends: Ints
    share: Floats

    def interpolate(self, values: Floats) -> Floats:
        """Values (n,) at the vertices of the half, from those at the vertices of the whole."""
        return np.asarray((1 - self.share) * values[self.ends[:, 0]] + self.share * values[self.ends[:, 1]])


def mirror_plane(surface: Surface, axis: str, tolerance: float, rng: np.random.Generator) -> MirrorPlane:
    """The plane through the centre of the bounding box, across `axis`.

    Raises UsageError unless the mirror image of the surface lies within `tolerance` bounding-box diagonals of it.
    """
    used = surface.V[np.unique(surface.F)]
    plane = MirrorPlane(AXES[axis], float((used.min(axis=0) + used.max(axis=0))[AXES[axis]] / 2))
    points = plane.mirror(np.concatenate([used, sample_surface(surface, SAMPLES, rng)]))
    off = float(SimplexTree(surface.V, surface.F).distances(points).max())
    diagonal = box_diagonal(used)
    if off > tolerance * diagonal:
        raise UsageError(
            f"the surface is not symmetric: mirrored at {axis} = {plane.offset:g} it is up to {off:g} away from "
            f"itself, {off / diagonal:.2%} of the diagonal; {tolerance:.1%} is allowed",
            hint="another axis, or without --symmetry",
        )
    return plane


def cut_off(surface: Surface, plane: MirrorPlane, snap: float) -> HalfSurface:
    """The part of a surface where the height over the plane is positive; its rim lies in the plane, to the last bit.

    Vertices nearer than `snap` edge lengths are moved into the plane instead of leaving slivers beside it: a smooth
    symmetric surface crosses its mirror plane at a right angle, so that they stay on it.  Raises UsageError where
    nothing is left, or nothing cut away.
    """
    V, height = surface.V.copy(), plane.height(surface.V)
    edges = np.unique(np.sort(directed_edges(surface.F), axis=1), axis=0)
    near = np.abs(height) <= snap * _mean_edges(V, edges)
    height[near] = 0.0
    V[near, plane.axis] = plane.offset
    sides = np.sign(height[surface.F])
    if (sides >= 0).all() or (sides <= 0).all():
        raise UsageError(
            "the mirror plane does not cut the surface", hint="another axis, or without --symmetry"
        )
    crossed = edges[height[edges[:, 0]] * height[edges[:, 1]] < 0]
    share = height[crossed[:, 0]] / (height[crossed[:, 0]] - height[crossed[:, 1]])
    cuts = (1 - share[:, None]) * V[crossed[:, 0]] + share[:, None] * V[crossed[:, 1]]
    cuts[:, plane.axis] = plane.offset
    number = {(int(a), int(b)): len(V) + i for i, (a, b) in enumerate(crossed)}
    F, parents = _clipped(surface.F, sides, number)
    ends = np.concatenate([np.repeat(np.arange(len(V))[:, None], 2, axis=1), crossed])
    used, local = np.unique(F, return_inverse=True)
    points = np.concatenate([V, cuts])[used]
    return HalfSurface(
        Surface(points, local.reshape(-1, 3).astype(np.int64)),
        parents,
        ends[used],
        np.concatenate([np.zeros(len(V)), share])[used],
    )


def _mean_edges(V: Floats, edges: Ints) -> Floats:
    """Mean length (n,) of the edges at each vertex."""
    length = np.repeat(np.linalg.norm(V[edges[:, 1]] - V[edges[:, 0]], axis=1), 2)
    use = np.maximum(np.bincount(edges.ravel(), minlength=len(V)), 1)
    return np.asarray(np.bincount(edges.ravel(), length, minlength=len(V)) / use)


def _clipped(F: Ints, sides: Ints, number: dict[tuple[int, int], int]) -> tuple[Ints, Ints]:
    """Triangles (m,3) on the positive side and what they are part of (m,); `number` names the point on a cut edge."""
    whole = (sides >= 0).all(axis=1) & (sides > 0).any(axis=1)
    pieces, parents = [F[whole]], [np.flatnonzero(whole)]
    for f in np.flatnonzero((sides > 0).any(axis=1) & (sides < 0).any(axis=1)).tolist():
        polygon = _clipped_polygon(F[f].tolist(), sides[f].tolist(), number)
        fan = [[polygon[0], polygon[i], polygon[i + 1]] for i in range(1, len(polygon) - 1)]
        pieces.append(np.array(fan, np.int64))
        parents.append(np.full(len(fan), f))
    return np.concatenate(pieces), np.concatenate(parents)


def _clipped_polygon(corners: list[int], sides: list[float], number: dict[tuple[int, int], int]) -> list[int]:
    polygon = []
    for i, (corner, side) in enumerate(zip(corners, sides, strict=True)):
        after = (i + 1) % 3
        if side >= 0:
            polygon.append(corner)
        if side * sides[after] < 0:
            polygon.append(number[min(corner, corners[after]), max(corner, corners[after])])
    return polygon


def features_of_half(half: HalfSurface, features: Features) -> Features:
    """The features (edges over the whole) as far as they lie on the half; its rim is none of them by itself."""
    edges = np.unique(np.sort(directed_edges(half.surface.F), axis=1), axis=0)
    size = int(max(half.ends.max(), features.edges.max(initial=0))) + 1
    known = features.edges @ np.array([size, 1])
    first, second = half.ends[edges[:, 0]], half.ends[edges[:, 1]]
    # both ends on one edge of the whole: together they name its two vertices
    names = np.sort(np.concatenate([first, second], axis=1), axis=1)
    lowest, highest = names[:, 0], names[:, -1]
    on_one_edge = ((names == lowest[:, None]) | (names == highest[:, None])).all(axis=1)
    kept = on_one_edge & np.isin(lowest * size + highest, known)
    corner = np.isin(half.ends[:, 0], features.corners) & (half.share == 0.0)
    return features_from_edges(half.surface.V, edges[kept], np.flatnonzero(corner))

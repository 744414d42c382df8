"""Stage singularities: points on the singular graph of the continuous field (paper, appendix A.1).

Random oriented triangles; where the field's rotation round the border of one is not the identity, a singular
line passes through it, and through one of the four parts that it is divided into (Solomon, Vaxman & Bommes
2017).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from neurframe_cli.field.frame_loops import loop_holonomies
from neurframe_cli.field.octahedral_group import AXIS, TURN, Turn
from neurframe_cli.field.rotations import random_rotations
from neurframe_cli.mesh.arrays import Bools, Floats, Ints, Progress, Surface, TetMesh, silent
from neurframe_cli.mesh.inside import depth_in_surface, random_points_in_tets
from neurframe_cli.mesh.measure import box_diagonal
from neurframe_cli.mesh.tet_adjacency import tet_adjacency
from neurframe_cli.stages.discretize import Query, sample_frames

# the first round looks everywhere, the others along the lines that are known so far
_ROUNDS = 6
_CIRCLE_POINTS = 48
_GRAZING = 0.25  # cosine between the line and the normal of its triangle


@dataclass(frozen=True)
class SingularitiesOptions:
    """samples: random triangles all over the volume, half as many follow near what they find; radius: their
    circumradius at most, and tolerance: the longest side of the last ones, both in bounding-box diagonals;
    points_per_side: where the field is asked on a border; seed: of the random numbers."""

    samples: int = 2000
    radius: float = 0.08
    tolerance: float = 2e-3
    points_per_side: int = 6
    seed: int = 0


@dataclass(frozen=True)
class SingularPoints:
    """Points (k,3) of the singular graph; turn (k,) a Turn each; quarters (k,) as in SingularEdges, its sign
    as the line crosses its triangle; axis (k,3): of the rotation, unit, zero for compounds."""

    points: Floats
    turn: Ints
    quarters: Ints
    axis: Floats

    def where(self, which: Bools) -> SingularPoints:
        """Some of the points."""
        return SingularPoints(self.points[which], self.turn[which], self.quarters[which], self.axis[which])


def find_singularities(
    query: Query,
    tets: TetMesh,
    options: SingularitiesOptions | None = None,
    progress: Progress = silent,
) -> SingularPoints:
    """Points of the singular graph of the field inside the tet mesh.

    Triangles are smaller near the boundary, so that lines there are met less often.  Raises StageError where the
    field is not finite.
    """
    options = options or SingularitiesOptions()
    rng = np.random.default_rng(options.seed)
    domain = _Domain(tets, options)
    found = _joined([])
    for done in range(_ROUNDS):
        count = options.samples if done == 0 else options.samples // 10
        centers = random_points_in_tets(tets, count, rng) if done == 0 else domain.near(found, count, rng)
        triangles = domain.triangles(centers, rng)
        tell = partial(_tell, progress, done)
        more = _search(query, triangles, options, domain.tolerance, tell)
        found = _joined([found, more.where(domain.depth(more.points) > 0)])
    progress(1.0, f"{len(found.points)} singular points")
    return found


def _tell(progress: Progress, done: int, fraction: float, text: str) -> None:
    progress((done + fraction) / _ROUNDS, text)


class _Domain:
    """The inside of a tet mesh, and triangles that fit into it."""

    def __init__(self, tets: TetMesh, options: SingularitiesOptions) -> None:
        self.surface = Surface(tets.V, tet_adjacency(tets.T).boundary_faces)
        self.diagonal = box_diagonal(tets.V)
        self.radius, self.tolerance = options.radius * self.diagonal, options.tolerance * self.diagonal

    def near(self, found: SingularPoints, count: int, rng: np.random.Generator) -> Floats:
        """Random points (count,3) along the lines that are known so far and beyond their ends; none if none is known.

        A line runs along its rotation axis, if it can be meshed at all; the noise takes care of the others.
        """
        _, spread = np.unique(np.floor(found.points / self.radius), axis=0, return_index=True)
        chosen = spread[rng.integers(len(spread), size=count)] if len(spread) else spread
        along = rng.uniform(-1.5, 1.5, (len(chosen), 1)) * found.axis[chosen]
        noise = 0.3 * rng.normal(size=(len(chosen), 3))
        return np.asarray(found.points[chosen] + self.radius * (along + noise))

    def triangles(self, centers: Floats, rng: np.random.Generator) -> Floats:
        """Equilateral triangles (k,3,3), randomly turned, round those centers that have room for one.

        A triangle is halved until its corners are inside.
        """
        angle = 2 * np.pi * np.arange(3) / 3
        corners = self.radius * np.stack([np.cos(angle), np.sin(angle), np.zeros(3)], axis=1)
        spokes = np.einsum("nij,kj->nki", random_rotations(len(centers), rng), corners)
        fitting = [np.zeros((0, 3, 3))]
        while len(centers) and np.linalg.norm(spokes[0, 0]) > self.tolerance:
            triangles = centers[:, None] + spokes
            inside = (self.depth(triangles.reshape(-1, 3)).reshape(-1, 3) > 0).all(axis=1)
            fitting.append(triangles[inside])
            centers, spokes = centers[~inside], 0.5 * spokes[~inside]
        return np.concatenate(fitting)

    def depth(self, points: Floats) -> Floats:
        """Distance (n,) to the boundary, negative outside."""
        return depth_in_surface(points, self.surface)


def _search(
    query: Query, triangles: Floats, options: SingularitiesOptions, longest_side: float, progress: Progress
) -> SingularPoints:
    """Centroids of the last of the singular triangles, each divided until its side is at most `longest_side`."""
    small = [triangles[:0]]
    rounds = 1 + int(np.ceil(np.log2(max(_sides(triangles).max(initial=0.0) / longest_side, 1.0))))
    for level in range(rounds):
        progress(level / rounds, f"{len(triangles)} triangles")
        border = _border(triangles, options.points_per_side)
        triangles = triangles[_holonomies(query, border)[0] != 0]
        is_small = _sides(triangles) <= longest_side
        small.append(triangles[is_small])
        triangles = _quarters_of(triangles[~is_small])
    return _classified(query, np.concatenate(small))


def _classified(query: Query, triangles: Floats) -> SingularPoints:
    """The centroids (n,3), each with the kind of its line.

    A line may run so near to the border of its triangle that the frames there cannot be followed: 58 % of all
    half turns were taken for quarter turns.  So the kind is found on a circle round the triangle, well away from
    the line.  Triangles that the line only grazes come near it on their circle as well and are left out.
    """
    a, b, c = np.swapaxes(triangles, 0, 1)
    centers, normals = (a + b + c) / 3, np.cross(b - a, c - a)
    first, angle = 2.0 * (a - centers), 2 * np.pi * np.arange(_CIRCLE_POINTS) / _CIRCLE_POINTS
    second = np.cross(normals, first) / np.linalg.norm(normals, axis=1, keepdims=True)
    ways = first[:, None] * np.cos(angle)[:, None] + second[:, None] * np.sin(angle)[:, None]
    holonomy, frames = _holonomies(query, centers[:, None] + ways)
    axis = np.einsum("nij,nj->ni", frames, AXIS[holonomy])
    turn = TURN[holonomy]
    slope = np.einsum("ni,ni->n", axis, normals) / np.linalg.norm(normals, axis=1)
    quarters = np.select([turn == Turn.QUARTER, turn == Turn.HALF], [np.where(slope > 0, 1, -1), 2], 0)
    found = (turn == Turn.COMPOUND) | (np.abs(slope) > _GRAZING)
    return SingularPoints(centers[found], turn[found], quarters[found], axis[found])


def _holonomies(query: Query, loops: Floats) -> tuple[Ints, Floats]:
    """Holonomies (n,) round loops (n,k,3), in the axes of the frames (n,3,3) at their first points."""
    frames = sample_frames(query, loops.reshape(-1, 3)).frames.reshape(*loops.shape, 3)
    return loop_holonomies(frames), frames[:, 0]


def _border(triangles: Floats, points_per_side: int) -> Floats:
    """Points (n, 3 points_per_side, 3) round each triangle (n,3,3), from its first corner."""
    t = (np.arange(points_per_side) / points_per_side)[:, None]
    following = np.roll(triangles, -1, axis=1)
    border = triangles[:, :, None] * (1 - t) + following[:, :, None] * t
    return np.asarray(border.reshape(len(triangles), 3 * points_per_side, 3))


def _quarters_of(triangles: Floats) -> Floats:
    """The four halves-by-two of each triangle (n,3,3), turned as it is: (4n,3,3)."""
    a, b, c = np.swapaxes(triangles, 0, 1)
    ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (bc, ca, ab)]
    return np.concatenate([np.stack(part, axis=1) for part in parts])


def _sides(triangles: Floats) -> Floats:
    return np.asarray(np.linalg.norm(triangles[:, 1] - triangles[:, 0], axis=1))


def _joined(parts: list[SingularPoints]) -> SingularPoints:
    none = SingularPoints(np.zeros((0, 3)), np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros((0, 3)))
    parts = [none, *parts]
    return SingularPoints(
        points=np.concatenate([part.points for part in parts]),
        turn=np.concatenate([part.turn for part in parts]),
        quarters=np.concatenate([part.quarters for part in parts]),
        axis=np.concatenate([part.axis for part in parts]),
    )

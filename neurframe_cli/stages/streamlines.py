"""Stage streamlines: curves along the axes of the continuous field (paper, appendix A.2)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from neurframe_cli.field.rotations import random_rotations
from neurframe_cli.mesh.arrays import Floats, Progress, Surface, TetMesh, silent
from neurframe_cli.mesh.inside import random_points_in_tets
from neurframe_cli.mesh.measure import box_diagonal
from neurframe_cli.mesh.quality.distance import sample_surface
from neurframe_cli.mesh.tet_adjacency import tet_adjacency
from neurframe_cli.stages.discretize import Query
from neurframe_cli.stages.streamline_steps import (
    Heads,
    Step,
    closest_on_surface,
    nearest_axes,
    step_in_volume,
    step_on_surface,
)


@dataclass(frozen=True)
class StreamlineOptions:
    """samples: seeds in the volume, and as many on the surface; step, and length: the longest way from a seed to
    one side, both in bounding-box diagonals; seed: of the random numbers."""

    samples: int = 120
    step: float = 0.01
    length: float = 0.5
    seed: int = 0


@dataclass(frozen=True)
class Streamlines:
    """Polylines (k,3) each, in input coordinates: through the volume, and on the surface."""

    volume: tuple[Floats, ...]
    surface: tuple[Floats, ...]


def trace_streamlines(
    query: Query,
    tets: TetMesh,
    surface: Surface,
    options: StreamlineOptions | None = None,
    progress: Progress = silent,
) -> Streamlines:
    """Streamlines both ways from random seeds along a random axis; raises StageError for a field not finite."""
    options = options or StreamlineOptions()
    rng = np.random.default_rng(options.seed)
    length = options.step * box_diagonal(tets.V)
    rounds = round(options.length / options.step)
    points, directions = (
        random_points_in_tets(tets, options.samples, rng),
        random_rotations(options.samples, rng),
    )
    heads = Heads(points, nearest_axes(query, points, directions[:, 0]), np.zeros_like(points))
    boundary = Surface(tets.V, tet_adjacency(tets.T).boundary_faces)
    step = step_in_volume(query, boundary, length)
    volume = trace(step, heads, rounds, lambda x, text: progress(0.5 * x, text))
    points, normals = closest_on_surface(surface, sample_surface(surface, options.samples, rng))
    heads = Heads(points, nearest_axes(query, points, directions[:, 1], normals), normals)
    step = step_on_surface(query, surface, length)
    on_surface = trace(step, heads, rounds, lambda x, text: progress(0.5 + 0.5 * x, text))
    progress(1.0, f"{len(volume) + len(on_surface)} streamlines")
    return Streamlines(volume, on_surface)


def trace(step: Step, seeds: Heads, rounds: int, progress: Progress = silent) -> tuple[Floats, ...]:
    """Polylines (k,3) through the seeds, forwards and backwards at most `rounds` steps."""
    there = _walk(step, seeds, rounds, lambda x, text: progress(0.5 * x, text))
    turned = Heads(seeds.points, -seeds.directions, seeds.normals)
    back = _walk(step, turned, rounds, lambda x, text: progress(0.5 + 0.5 * x, text))
    lines = (np.concatenate([b[:0:-1], a]) for a, b in zip(there, back, strict=True))
    return tuple(line for line in lines if len(line) > 1)


def _walk(step: Step, heads: Heads, rounds: int, progress: Progress) -> list[Floats]:
    """The points that each head passes, its own first."""
    walked = [[point] for point in heads.points]
    alive = np.arange(len(walked))
    for done in range(rounds):
        progress(done / rounds, f"{len(alive)} streamlines")
        heads, inside = step(heads)
        alive, heads = alive[inside], heads[inside]
        for line, point in zip(alive, heads.points, strict=True):
            walked[line].append(point)
        if not len(alive):
            break
    return [np.array(line) for line in walked]

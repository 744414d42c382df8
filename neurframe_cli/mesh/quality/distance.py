"""Distances between two surfaces, sampled both ways."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints, Surface
from neurframe_cli.mesh.measure import triangle_areas


@dataclass(frozen=True)
class SurfaceDistance:
    """Sampled distances in units of the meshes; hausdorff is the larger maximum of both ways, mean the larger mean."""

    hausdorff: float
    mean: float


def surface_distance(one: Surface, other: Surface, samples: int, rng: np.random.Generator) -> SurfaceDistance:
    """Distance of `samples` random points (and of the vertices) of each surface to the other one."""
    there, back = _one_way(one, other, samples, rng), _one_way(other, one, samples, rng)
    return SurfaceDistance(float(max(there.max(), back.max())), float(max(there.mean(), back.mean())))


def _one_way(source: Surface, target: Surface, samples: int, rng: np.random.Generator) -> Floats:
    import igl

    used = np.unique(source.F)
    points = np.concatenate([sample_surface(source, samples, rng), source.V[used]])
    squared = igl.point_mesh_squared_distance(points, target.V, target.F)[0]
    return np.asarray(np.sqrt(np.maximum(squared, 0.0)), np.float64)


def sample_surface(surface: Surface, samples: int, rng: np.random.Generator) -> Floats:
    """`samples` points (n,3), uniform by area."""
    A, B, C = (surface.V[surface.F[:, i]] for i in range(3))
    area = triangle_areas(surface.V, surface.F)
    chosen: Ints = rng.choice(len(area), size=samples, p=area / area.sum())
    r, s = np.sqrt(rng.random(samples))[:, None], rng.random(samples)[:, None]
    return np.asarray((1 - r) * A[chosen] + r * (1 - s) * B[chosen] + r * s * C[chosen])

"""Stage discretize: from a continuous field to frames on tets and crosses on triangles (paper, section 4.1)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from neurframe_cli.errors import StageError
from neurframe_cli.field.cross_field import crosses_of_frames
from neurframe_cli.field.frame_angles import Deviation, deviation, feature_angles_deg, normal_angles_deg
from neurframe_cli.field.frames import nearest_frames
from neurframe_cli.field.matching import best_matchings
from neurframe_cli.field.singular_edges import SingularEdges, singular_edges
from neurframe_cli.mesh.arrays import Bools, Features, Floats, Progress, Surface, TetMesh, silent
from neurframe_cli.mesh.surface_edges import face_normals
from neurframe_cli.mesh.tet_adjacency import tet_adjacency

# coefficients (n,9) of the field at points (n,3) in the coordinates of the input
Query = Callable[[Floats], Floats]


@dataclass(frozen=True)
class DiscretizeOptions:
    """batch: points per call of the field and of the projection; bounds the memory, does not change the result."""

    batch: int = 65536


@dataclass(frozen=True)
class SampledFrames:
    """A field at n points: coefficients (n,9) as the field gives them, frames (n,3,3) with axes as columns,
    distance (n,) from the one to the other, converged (n,) of the projection."""

    coefficients: Floats
    frames: Floats
    distance: Floats
    converged: Bools


@dataclass(frozen=True)
class Discretization:
    """Frames at tet centroids, crosses (k,2,3) at triangle centroids, and what there is to say about them.

    neighbors: rotation between the frames of neighbouring tets after matching; normals: boundary face normals
    against the frame of their tet; features: feature edges against the frames of the tets round them.
    """

    tets: SampledFrames
    crosses: Floats
    singular: SingularEdges
    neighbors: Deviation
    normals: Deviation
    features: Deviation

    def summary(self) -> dict[str, float]:
        """Numbers for the manifest and the report; lengths in bounding-box diagonals, angles in degrees."""
        return {
            "tets": len(self.tets.frames),
            "triangles": len(self.crosses),
            "mean_projection_distance": float(self.tets.distance.mean()),
            "unconverged_projections": int((~self.tets.converged).sum()),
            **self.singular.summary(),
            "neighbor_deg_mean": self.neighbors.mean_deg,
            "neighbor_deg_max": self.neighbors.max_deg,
            "normal_deg_mean": self.normals.mean_deg,
            "normal_deg_max": self.normals.max_deg,
            "feature_deg_mean": self.features.mean_deg,
            "feature_deg_max": self.features.max_deg,
        }


def discretize(
    query: Query,
    tets: TetMesh,
    surface: Surface,
    features: Features,
    options: DiscretizeOptions | None = None,
    progress: Progress = silent,
) -> Discretization:
    """The field at the centroids of `tets` and `surface`, projected to frames, with its singular edges.

    `features` are edges of `tets`.  Raises StageError where the field is not finite.
    """
    options = options or DiscretizeOptions()
    share = len(tets.T) / max(len(tets.T) + len(surface.F), 1)
    centroids = tets.V[tets.T].mean(axis=1)
    sampled = sample_frames(query, centroids, options, lambda x, text: progress(0.9 * share * x, text))
    crosses = sample_crosses(
        query, surface, options, lambda x, text: progress(0.9 * (share + (1 - share) * x), text)
    )
    progress(0.9, "singular edges")
    found = _describe(tets, features, sampled, crosses)
    progress(1.0, f"{len(found.singular.edges)} singular edges")
    return found


def sample_frames(
    query: Query, points: Floats, options: DiscretizeOptions | None = None, progress: Progress = silent
) -> SampledFrames:
    """The field at any points (n,3), projected to frames; raises StageError where the field is not finite."""
    options = options or DiscretizeOptions()
    parts = []
    for begin in range(0, len(points), options.batch):
        progress(begin / len(points), f"frames at {len(points)} points")
        coefficients = _checked(query(points[begin : begin + options.batch]), points, begin)
        projection = nearest_frames(coefficients)
        parts.append((coefficients, projection.frames, projection.distance, projection.converged))
    if not parts:
        return SampledFrames(np.zeros((0, 9)), np.zeros((0, 3, 3)), np.zeros(0), np.zeros(0, bool))
    return SampledFrames(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def sample_crosses(
    query: Query, surface: Surface, options: DiscretizeOptions | None = None, progress: Progress = silent
) -> Floats:
    """Crosses (m,2,3) at the centroids of the triangles, orthonormal and tangent; raises StageError."""
    sampled = sample_frames(query, surface.V[surface.F].mean(axis=1), options, progress)
    return crosses_of_frames(sampled.frames, face_normals(surface.V, surface.F))


def _checked(coefficients: Floats, points: Floats, begin: int) -> Floats:
    coefficients = np.asarray(coefficients, np.float64)
    bad = np.flatnonzero(~np.isfinite(coefficients).all(axis=1))
    if len(bad):
        where = ", ".join(f"{x:g}" for x in points[begin + bad[0]])
        raise StageError(
            f"the field is not finite at {len(bad)} of {len(coefficients)} points, the first is ({where})",
            hint="the training diverged: train again with --force, or with other weights of the loss",
        )
    return coefficients


def _describe(tets: TetMesh, features: Features, sampled: SampledFrames, crosses: Floats) -> Discretization:
    adjacency = tet_adjacency(tets.T)
    frames = sampled.frames
    return Discretization(
        tets=sampled,
        crosses=crosses,
        singular=singular_edges(tets.V, tets.T, frames, adjacency),
        neighbors=deviation(np.degrees(best_matchings(frames, adjacency).angle)),
        normals=deviation(normal_angles_deg(tets.V, adjacency, frames)),
        features=deviation(feature_angles_deg(tets.V, tets.T, features.edges, frames)),
    )

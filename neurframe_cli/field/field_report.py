"""What a field is worth on the tets that it was made for: losses, alignment, singular edges."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from neurframe_cli.field.energy_terms import EnergyTerms
from neurframe_cli.field.frame_angles import deviation, feature_angles_deg, normal_angles_deg
from neurframe_cli.field.frames import frame_to_band4, nearest_frames
from neurframe_cli.field.singular_edges import singular_edges
from neurframe_cli.mesh.arrays import Features, Floats, TetMesh
from neurframe_cli.mesh.tet_adjacency import TetAdjacency


def field_report(
    terms: EnergyTerms, q: Floats, tets: TetMesh, features: Features, adjacency: TetAdjacency
) -> dict[str, Any]:
    """Of coefficients q (m,9): the losses, those of the nearest frames, their deviations and singular edges.

    Angles in degrees, lengths in bounding-box diagonals; projection_distance is |q - frame|, mean over the tets.
    """
    projection = nearest_frames(q)
    frames = projection.frames
    normals = deviation(normal_angles_deg(tets.V, adjacency, frames))
    along = deviation(feature_angles_deg(tets.V, tets.T, features.edges, frames))
    return {
        "losses": asdict(terms.losses(q)),
        "projected_losses": asdict(terms.losses(frame_to_band4(frames))),
        "projection_distance": float(projection.distance.mean()),
        "unconverged_projections": int((~projection.converged).sum()),
        "normal_deg_mean": normals.mean_deg,
        "normal_deg_max": normals.max_deg,
        "feature_deg_mean": along.mean_deg,
        "feature_deg_max": along.max_deg,
        **singular_edges(tets.V, tets.T, frames, adjacency).summary(),
    }

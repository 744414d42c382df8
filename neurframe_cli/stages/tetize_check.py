"""Does what fTetWild returned fill the surface that it was given?"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from neurframe_cli.errors import StageError
from neurframe_cli.mesh.arrays import Surface, TetMesh
from neurframe_cli.mesh.check_tets import tet_volumes
from neurframe_cli.mesh.clean_surface import CleaningReport
from neurframe_cli.mesh.manifold_boundary import boundary_surface
from neurframe_cli.mesh.orient_surface import enclosed_volume
from neurframe_cli.mesh.surface_distance import distances, sample_surface

# The surface may move by epsilon; measured on the closed models at hand, the boundary of the tets stays within
# one epsilon of the input and the input within two of it.  Ten separates that from a part that is missing.
ALLOWED_EPSILONS = 10.0
# a shell of thickness epsilon round the surface, and not less than this part of the volume
ALLOWED_VOLUME = 0.02


@dataclass(frozen=True)
class Fit:
    """Distances as fractions of the bounding-box diagonal.

    boundary_to_input, input_to_boundary: largest of the samples; volume_ratio: tets over input, nan where the
    input encloses no well-defined volume.
    """

    boundary_to_input: float
    input_to_boundary: float
    volume_ratio: float


def fit(mesh: TetMesh, surface: Surface, report: CleaningReport) -> Fit:
    """Measures the tets against the input surface."""
    diagonal = float(np.linalg.norm(np.ptp(surface.V, axis=0)))
    V, F = boundary_surface(mesh)
    spacing = 0.01 * diagonal
    out = distances(sample_surface(V, F, spacing), surface.V, surface.F).max() / diagonal
    back = distances(sample_surface(surface.V, surface.F, spacing), V, F).max() / diagonal
    ratio = float("nan")
    if report.closed and report.nonmanifold_edges == 0:
        volume = enclosed_volume(surface.V, surface.F)
        if volume > 0:
            ratio = float(tet_volumes(mesh.V, mesh.T).sum()) / volume
    return Fit(float(out), float(back), ratio)


def refuse_misfit(found: Fit, epsilon: float, report: CleaningReport) -> list[str]:
    """Raises StageError where tets reach away from the input; returns warnings for the rest.

    Parts of the input inside the solid (walls, overlaps) are far from its boundary and rightly so, and they count
    in the enclosed volume: these two only warn.
    """
    allowed = ALLOWED_EPSILONS * epsilon
    if report.closed and found.boundary_to_input > allowed:
        raise StageError(
            f"the tets reach {found.boundary_to_input:.2%} of the bounding-box diagonal away from the surface, "
            f"{allowed:.2%} are allowed"
        )
    warnings = []
    if found.boundary_to_input > allowed:
        warnings.append(
            f"holes were closed: the boundary of the tets reaches {found.boundary_to_input:.2%} of the "
            "bounding-box diagonal away from the input"
        )
    if found.input_to_boundary > allowed:
        warnings.append(
            f"parts of the input are {found.input_to_boundary:.2%} of the bounding-box diagonal away from the "
            "boundary of the tets: inner walls, overlaps, or parts too thin for epsilon"
        )
    if abs(found.volume_ratio - 1) > ALLOWED_VOLUME:
        warnings.append(f"the tets have {found.volume_ratio:.4f} times the volume that the input encloses")
    return warnings

"""Does what fTetWild returned fill the surface that it was given?"""

from __future__ import annotations

from dataclasses import dataclass

from neurframe_cli.errors import StageError
from neurframe_cli.mesh.arrays import Surface, TetMesh
from neurframe_cli.mesh.check_tets import tet_volumes
from neurframe_cli.mesh.clean_surface import CleaningReport
from neurframe_cli.mesh.manifold_boundary import boundary_surface
from neurframe_cli.mesh.measure import box_diagonal, enclosed_volume
from neurframe_cli.mesh.surface_distance import distances, sample_surface

# The surface may move by epsilon; on the closed models at hand the boundary of the tets stays within 0.6 epsilon of
# the input and the input within one of it.  Ten separates that from a part that is missing.
ALLOWED_EPSILONS = 10.0
# where the input crosses itself fTetWild decides what is inside, and may bridge a gap or drop a sliver
ALLOWED_OF_MESSY = 0.05
# the part of the volume that a shell of thickness epsilon may have in a thin-walled model
ALLOWED_VOLUME = 0.02


@dataclass(frozen=True)
class Fit:
    """Distances as fractions of the bounding-box diagonal.

    boundary_to_input, input_to_boundary: largest of the samples; volume_ratio: tets over input, None where the
    input encloses no well-defined volume.
    """

    boundary_to_input: float
    input_to_boundary: float
    volume_ratio: float | None


def fit(mesh: TetMesh, surface: Surface, report: CleaningReport) -> Fit:
    """Measures the tets against the input surface."""
    diagonal = box_diagonal(surface.V)
    V, F = boundary_surface(mesh)
    spacing = 0.01 * diagonal
    out = distances(sample_surface(V, F, spacing), surface.V, surface.F).max() / diagonal
    back = distances(sample_surface(surface.V, surface.F, spacing), V, F).max() / diagonal
    ratio = None
    if report.closed and report.nonmanifold_edges == 0:
        volume = enclosed_volume(surface.V, surface.F)
        if volume > 0:
            ratio = float(tet_volumes(mesh.V, mesh.T).sum()) / volume
    return Fit(float(out), float(back), ratio)


def refuse_misfit(found: Fit, epsilon: float, report: CleaningReport) -> list[str]:
    """Raises StageError where the tets do not fill the input; returns warnings where that is a matter of opinion.

    An input that bounds a solid must come back as it is, within epsilon.  Of any other, walls inside the solid and
    overlaps are rightly far from the boundary of the tets and count twice in the enclosed volume.
    """
    allowed = ALLOWED_EPSILONS * epsilon
    problems = []
    if found.boundary_to_input > allowed:
        problems.append(f"the tets reach {_percent(found.boundary_to_input)} away from the surface")
    if found.input_to_boundary > allowed:
        problems.append(f"parts of the surface are {_percent(found.input_to_boundary)} away from the tets")
    if found.volume_ratio is not None and abs(found.volume_ratio - 1) > ALLOWED_VOLUME:
        problems.append(f"the tets have {found.volume_ratio:.3f} times the volume that the surface encloses")
    too_far = found.boundary_to_input > ALLOWED_OF_MESSY
    if problems and (report.bounds_a_solid or too_far):
        missing = found.input_to_boundary > allowed
        raise StageError("; ".join(problems), hint="try a smaller --edge-length" if missing else None)
    return problems


def _percent(fraction: float) -> str:
    return f"{fraction:.2%} of the bounding-box diagonal"

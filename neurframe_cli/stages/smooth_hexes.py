"""Smoothing and untangling of a hex mesh in the surface that it was made from."""

from __future__ import annotations

import numpy as np

from neurframe_cli.mesh.arrays import Features, Floats, Ints, Progress, Surface, silent
from neurframe_cli.mesh.hex_shell import hex_shell
from neurframe_cli.mesh.measure import box_diagonal
from neurframe_cli.mesh.optimize.cell_kind import HEXES
from neurframe_cli.mesh.optimize.distance_probe import BothDiagonals
from neurframe_cli.mesh.optimize.smooth import (
    MeshNumbers,
    SmoothedMesh,
    SmoothOptions,
    mesh_numbers,
    smooth_cells,
)
from neurframe_cli.mesh.quality.scaled_jacobian import hex_scaled_jacobians

# a mesh is valid up to 0.01, but samples do not see all of a distance
HEX_OPTIONS = SmoothOptions(hausdorff_limit=0.009)


def smooth_hexes(
    V: Floats,
    H: Ints,
    surface: Surface,
    features: Features,
    options: SmoothOptions,
    progress: Progress = silent,
    voids: bool = True,
) -> SmoothedMesh:
    """New positions of the vertices V (n,3) of hexes H (h,8) in VTK order.

    Boundary vertices stay on the surface, those on feature curves on these, those at corners in place; no hex becomes
    worse than the worst one was.  Where that leaves a hex bad or the mesh farther away than the limit of `options`,
    both are weighed against each other (mesh/optimize/approach.py), and hexes may become worse, but not inverted.
    `voids`: hexes may be missing; a boundary farther from the surface than three quarters of an edge does not move
    then.  Raises InvalidMesh if there are no hexes.
    """
    return smooth_cells(V, H, HEXES, boundary_quads(H), surface, features, options, progress, voids)


def measured_hexes(V: Floats, H: Ints, surface: Surface, options: SmoothOptions) -> MeshNumbers:
    """The numbers of hexes H (h,8) over V (n,3) as they are, by the samples that smoothing takes."""
    rng = np.random.default_rng(options.seed)
    distances = BothDiagonals(boundary_quads(H), surface, options.samples, rng).measure(V)
    return mesh_numbers(
        hex_scaled_jacobians(V, H).min(axis=1), distances, box_diagonal(surface.V[np.unique(surface.F)])
    )


def boundary_quads(H: Ints) -> Ints:
    """Faces (f,4) of exactly one hex, outward."""
    return hex_shell(H).quads

"""The verdict on a mesh of hexes, pyramids and tets."""

from __future__ import annotations

from dataclasses import asdict

import numpy as np

from neurframe_cli.mesh.arrays import Surface
from neurframe_cli.mesh.filling.hybrid_mesh import HybridMesh, measure_hybrid, outer_faces
from neurframe_cli.mesh.measure import box_diagonal, enclosed_volume
from neurframe_cli.mesh.quality.check import CheckOptions, Verdict
from neurframe_cli.mesh.quality.distance import surface_distance
from neurframe_cli.mesh.quality.polygons import (
    topology,
    topology_problems,
    triangulated,
)

VOLUME_TOLERANCE = (
    0.02  # of the input's; chords of round parts take less, a void that was left out takes more
)


def check_hybrid(mesh: HybridMesh, against: Surface, options: CheckOptions) -> Verdict:
    """Conforming, positive cells, closed, with the components, Euler characteristic and volume of the input.

    The Hausdorff distance is measured and does not decide: the surface is a choice of the hexes that stayed.
    """
    measured = measure_hybrid(mesh)
    quads, triangles = outer_faces(mesh)
    F = np.concatenate([triangulated(quads), triangles])
    rng = np.random.default_rng(options.seed)
    distance = surface_distance(Surface(mesh.V, F), against, options.samples, rng)
    diagonal = box_diagonal(against.V[np.unique(against.F)])
    ratio = measured.volume / enclosed_volume(against.V, against.F)
    components, euler = topology(F)
    counts = {
        "faces that do not conform": measured.nonconforming_faces,
        "edges of the outside that are open": measured.open_edges,
        "cells with a Jacobian or volume <= 0": measured.inverted,
    }
    problems = [f"{count} {what}" for what, count in counts.items() if count]
    problems += topology_problems(F, against.F)
    if abs(ratio - 1.0) > VOLUME_TOLERANCE:
        problems.append(f"{ratio:.3f} of the volume of the input")
    numbers = {
        "kind": "hybrid",
        **asdict(measured),
        "volume_ratio": ratio,
        "components": components,
        "euler_characteristic": euler,
        "hausdorff": distance.hausdorff / diagonal,
        "mean_distance": distance.mean / diagonal,
    }
    return Verdict(numbers, problems)

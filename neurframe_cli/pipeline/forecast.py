"""About how large and how long: tets of a model and seconds of each stage, before anything is computed.

The formulas are fits to runs on one thread (docs/run.md); they are good to a factor of two or three.  What earlier
runs took on this machine scales them.
"""

from __future__ import annotations

import statistics
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from neurframe_cli.mesh.arrays import Surface
from neurframe_cli.mesh.load import load_model
from neurframe_cli.mesh.measure import box_diagonal, enclosed_volume, surface_area
from neurframe_cli.mesh.tet_adjacency import tet_adjacency
from neurframe_cli.pipeline.manifest import Manifest
from neurframe_cli.pipeline.sizing import ElementSize

# seconds of a stage = constant + sum of rate * thousands of what the name says
_COSTS: dict[str, dict[str, float]] = {
    "tetize": {"constant": 4.0, "tets": 0.6, "faces": 1.5},
    "train": {"constant": 4.5, "tets": 1.2},
    "discretize": {"constant": 5.0, "tets": 0.2},
    "quad": {"constant": 2.5, "quads": 0.35},
    "hex": {"constant": 4.0, "tets": 1.8},
}
_PASSED_THROUGH = {"constant": 0.4, "tets": 0.04}  # tetize of a tet mesh only checks it
_SPEED_STAGES = ("train", "discretize", "hex")  # what their formulas need stands in every manifest


@dataclass(frozen=True)
class Amount:
    """What the stages work on; faces: triangles of the input, or of the carrier of the crosses; is_surface: fTetWild
    has to fill it."""

    tets: float
    faces: float = 0.0
    quads: float = 0.0
    hexes: float = 0.0
    is_surface: bool = True


def amount_of(
    model: Path, tet_edge_length: float, quad_size: ElementSize | None, hex_size: ElementSize | None = None
) -> Amount:
    """What a run on the file `model` will work on; tet_edge_length in bounding-box diagonals.

    Raises what reading raises.
    """
    loaded = load_model(model)
    if isinstance(loaded, Surface):
        surface, tets, faces = loaded, expected_tets(loaded, tet_edge_length), len(loaded.F)
    else:
        V, T = loaded[0].V, loaded[0].T
        surface, tets, faces = Surface(V, tet_adjacency(T).boundary_faces), float(len(T)), 0
    quads = expected_quads(surface, quad_size) if quad_size is not None else 0.0
    hexes = expected_hexes(surface, hex_size) if hex_size is not None else 0.0
    return Amount(tets, faces, quads, hexes, isinstance(loaded, Surface))


def expected_tets(surface: Surface, edge_length: float) -> float:
    """About how many tets fTetWild makes; edge_length in bounding-box diagonals.

    8.5 volumes of h^3 inside, 3 areas of h^2 for the finer layer at the boundary, and half a tet for each triangle of
    the input, whose detail must be kept within epsilon. A surface without extent, which tetize refuses, has none.
    """
    diagonal = box_diagonal(surface.V[np.unique(surface.F)])
    h = edge_length * diagonal
    if h == 0:
        return 0.0
    return (
        8.5 * abs(enclosed_volume(surface.V, surface.F)) / h**3
        + 3 * surface_area(surface.V, surface.F) / h**2
        + 0.5 * len(surface.F)
    )


def expected_quads(surface: Surface, size: ElementSize) -> float:
    """As many squares of that size as have the area of the surface."""
    return size.count or surface_area(surface.V, surface.F) / size.length(surface) ** 2


def expected_hexes(surface: Surface, size: ElementSize) -> float:
    """As many cubes of that size as have the volume that the surface encloses."""
    return size.count or abs(enclosed_volume(surface.V, surface.F)) / size.length(surface) ** 3


def seconds_of(stage: str, amount: Amount, speed: float = 1.0) -> float:
    """About how long a stage takes, on a machine that takes `speed` times as long as ours."""
    costs = _PASSED_THROUGH if stage == "tetize" and not amount.is_surface else _COSTS[stage]
    thousands = {"tets": amount.tets / 1000, "faces": amount.faces / 1000, "quads": amount.quads / 1000}
    return speed * (costs["constant"] + sum(costs.get(name, 0.0) * many for name, many in thousands.items()))


def measured_speed(manifests: Iterable[Manifest]) -> tuple[float, int]:
    """How many times as long as the formulas say earlier stages took (median), and how many there were; 1 of none."""
    ratios = []
    for manifest in manifests:
        tetize = manifest.stages.get("tetize")
        tets = tetize.report.get("tets") if tetize is not None else None
        for name in _SPEED_STAGES:
            record = manifest.stages.get(name)
            if tets and record is not None and record.status in ("done", "invalid") and record.seconds > 0:
                ratios.append(record.seconds / seconds_of(name, Amount(tets)))
    return (statistics.median(ratios), len(ratios)) if ratios else (1.0, 0)

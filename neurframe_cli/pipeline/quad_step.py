"""quad on files: crosses -> map.obj -> quad.obj."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path

import numpy as np

from neurframe_cli.mesh.arrays import Features, Floats, Surface, part
from neurframe_cli.mesh.features import features_by_angle
from neurframe_cli.mesh.optimize.smooth import SmoothedMesh
from neurframe_cli.mesh.read_cells import CellMesh
from neurframe_cli.pipeline.forecast import Amount, expected_quads
from neurframe_cli.pipeline.mesh_step import MadeMesh, MeshKind, MeshRequest, Model, mesh_step
from neurframe_cli.pipeline.quad_map import MappedQuads, MapProblem, mapped_quads
from neurframe_cli.pipeline.quad_source import CrossCarrier, quad_inputs, read_carrier, read_model
from neurframe_cli.pipeline.runner import StageContext, Step
from neurframe_cli.pipeline.workspace import Workspace
from neurframe_cli.stages.curvature_sizing import SizingOptions, curvature_sizing
from neurframe_cli.stages.mirror_plane import MirrorPlane, mirror_plane
from neurframe_cli.stages.smooth_quads import QUAD_OPTIONS, smooth_quads
from neurframe_cli.stages.symmetric_quads import half_model, mirrored_quads

SYMMETRY_TOLERANCE = (
    0.005  # bounding-box diagonals; half of the distance at which a mesh is not valid any more
)


def quad_step(workspace: Workspace, request: MeshRequest) -> Step:
    """The stage bound to its files (paper, section 5.1.1)."""
    inputs = quad_inputs(workspace, request.quads)
    # the file is an input, known by its content and not by its name
    keyed = {name: value for name, value in asdict(request.quads).items() if name != "surface_file"}
    return mesh_step(QUAD, inputs, request, lambda: read_model(inputs), keyed)


def _make(context: StageContext, inputs: Mapping[str, Path], model: Model, request: MeshRequest) -> MadeMesh:
    """Parametrize, extract, smooth, and mirror where a symmetry was asked for."""
    plane = _plane(model.surface, request)
    length = request.size.length(model.surface)
    carrier = read_carrier(inputs, model.surface, request.feature_angle_deg, length)
    context.expect("quad", Amount(0, len(carrier.surface.F), expected_quads(model.surface, request.size)))
    followed = features_by_angle(carrier.surface.V, carrier.surface.F, request.feature_angle_deg)
    sizing = None
    if request.quads.adaptive is not None:
        sizing = curvature_sizing(carrier.surface, followed, length, SizingOptions(request.quads.adaptive))
    if plane is not None:
        return _make_symmetric(context, model, plane, carrier, followed, sizing, request)
    mapped = mapped_quads(QUAD, context, _problem(carrier, sizing, length, request, copies=1))
    smoothed = _smoothed(context, mapped.cells, model)
    return _made(mapped, smoothed, CellMesh("quad", smoothed.V, mapped.cells.cells))


def _plane(surface: Surface, request: MeshRequest) -> MirrorPlane | None:
    if request.quads.symmetry is None:
        return None
    return mirror_plane(surface, request.quads.symmetry, SYMMETRY_TOLERANCE, np.random.default_rng(0))


def _make_symmetric(
    context: StageContext,
    model: Model,
    plane: MirrorPlane,
    carrier: CrossCarrier,
    followed: Features,
    sizing: Floats | None,
    request: MeshRequest,
) -> MadeMesh:
    """All of it for one half, with the cut as a feature, and then the mirror image; map.obj is that of the half."""
    half = half_model(plane, model.surface, model.features, carrier.surface, carrier.crosses, followed)
    problem = _problem(
        CrossCarrier(half.carrier.surface, half.crosses),
        None if sizing is None else half.carrier.interpolate(sizing),
        request.size.length(model.surface),
        request,
        copies=2,
    )
    mapped = mapped_quads(QUAD, context, problem)
    smoothed = _smoothed(context, mapped.cells, Model(half.surface, half.features))
    whole = CellMesh("quad", *mirrored_quads(smoothed.V, mapped.cells.cells, plane))
    return _made(mapped, smoothed, whole)


def _problem(
    carrier: CrossCarrier, sizing: Floats | None, length: float, request: MeshRequest, copies: int
) -> MapProblem:
    count = request.size.count
    return MapProblem(
        carrier,
        sizing,
        length if count is None else None,
        None if count is None else max(1, round(count / copies)),
        request.feature_angle_deg,
        request.limits,
    )


def _smoothed(context: StageContext, raw: CellMesh, model: Model) -> SmoothedMesh:
    progress = part(context.progress, 0.7, 0.9)
    return smooth_quads(raw.V, raw.cells, model.surface, model.features, QUAD_OPTIONS, progress)


def _made(mapped: MappedQuads, smoothed: SmoothedMesh, cells: CellMesh) -> MadeMesh:
    report = {"smoothing": asdict(smoothed.report)}
    return MadeMesh(cells, mapped.parametrization, mapped.extraction, report)


QUAD = MeshKind(
    name="quad",
    version=5,
    map_name="map.obj",
    outputs=("quad.obj",),
    extractor="qex",
    pictures={"quads": "quad.png"},
    make=_make,
)

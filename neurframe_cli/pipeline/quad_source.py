"""Where the quads come from: the surface that they shall lie on, the triangles with the crosses, the options."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from neurframe_cli.errors import InvalidMesh, UnreadableFile
from neurframe_cli.field.surface_cross_field import surface_cross_field
from neurframe_cli.mesh.arrays import Floats, Surface
from neurframe_cli.mesh.check_tets import check_indices
from neurframe_cli.mesh.features import features_by_angle
from neurframe_cli.mesh.open_archive import check_archive
from neurframe_cli.mesh.open_file import check_file, foreign_reader
from neurframe_cli.mesh.read_surface import read_surface
from neurframe_cli.mesh.read_tets import read_medit
from neurframe_cli.mesh.split_edges import with_short_edges
from neurframe_cli.mesh.surface_edges import face_normals, surface_edges
from neurframe_cli.pipeline.checking import load_surface
from neurframe_cli.pipeline.discretize_step import CROSSES
from neurframe_cli.pipeline.tetize_step import SURFACE, TETS
from neurframe_cli.pipeline.train_step import FIELD
from neurframe_cli.pipeline.workspace import Workspace
from neurframe_cli.stages.cross_surface import choose_cross_surface
from neurframe_cli.stages.discretize import sample_crosses

OWN_SURFACE = "--surface"  # label of the user's file among the inputs
CARRIER_EDGE = 1.5  # edges of the quads: what the triangles that carry crosses may measure


@dataclass(frozen=True)
class QuadOptions:
    """adaptive: strength of the sizing by curvature, None for equal quads; symmetry: axis of an exact mirror
    symmetry; field: the crosses are those of the trained field, or the smoothest of the surface alone; surface_file:
    what to put quads on instead of the workspace's surface; it may be open."""

    adaptive: float | None = None
    symmetry: Literal["x", "y", "z"] | None = None
    field: Literal["neural", "surface"] = "neural"
    surface_file: Path | None = None


@dataclass(frozen=True)
class CrossCarrier:
    """Triangles with a cross (m,2,3) each."""

    surface: Surface
    crosses: Floats


def quad_inputs(workspace: Workspace, options: QuadOptions) -> dict[str, Path]:
    """The files that the options ask for, by label; raises UsageError for a missing one."""
    if options.surface_file is None:
        inputs = {SURFACE: workspace.require(SURFACE, "tetize INPUT")}
        needed = (CROSSES, "discretize") if options.field == "neural" else (TETS, "tetize INPUT")
    else:
        inputs = {OWN_SURFACE: options.surface_file}
        needed = (FIELD, "train")
    if options.surface_file is None or options.field == "neural":
        inputs[needed[0]] = workspace.require(*needed)
    return inputs


def read_model(inputs: Mapping[str, Path]) -> Surface:
    """The surface to put quads on; raises InvalidMesh for a file whose surface is not manifold or has no area."""
    if SURFACE in inputs:
        return read_surface(inputs[SURFACE])
    path = inputs[OWN_SURFACE]
    surface = load_surface(path)
    flat = ~face_normals(surface.V, surface.F).any(axis=1)
    if flat.any():
        raise InvalidMesh(
            f"{path}: {int(flat.sum())} triangles have no area, the first is {int(flat.argmax())}",
            hint="remesh the surface, or tetize it first",
        )
    crowded = surface_edges(surface.V, surface.F).face_count > 2
    if crowded.any():
        raise InvalidMesh(
            f"{path}: {int(crowded.sum())} edges have more than two triangles",
            hint="only manifold surfaces carry crosses; tetize repairs solids",
        )
    return surface


def read_carrier(
    inputs: Mapping[str, Path], surface: Surface, feature_angle_deg: float, edge_length: float
) -> CrossCarrier:
    """The triangles and their crosses: cross.npz, or the field asked at the user's surface, or the surface's own."""
    if CROSSES in inputs:
        return read_crosses(inputs[CROSSES])
    if TETS in inputs:
        carrier, _ = choose_cross_surface(surface, read_medit(inputs[TETS])[0], "auto")
    else:
        carrier = with_short_edges(surface, CARRIER_EDGE * edge_length)
    if FIELD in inputs:
        from neurframe_cli.field.field_file import read_field

        return CrossCarrier(carrier, sample_crosses(read_field(inputs[FIELD]).query, carrier))
    features = features_by_angle(carrier.V, carrier.F, feature_angle_deg)
    return CrossCarrier(carrier, surface_cross_field(carrier.V, carrier.F, features.edges))


def read_crosses(path: Path) -> CrossCarrier:
    """From cross.npz; raises UnreadableFile or InvalidMesh."""
    check_file(path)
    with foreign_reader(path, "zipfile"), zipfile.ZipFile(path) as archive:
        check_archive(path, archive)
    # numpy leaves a file open that it opened itself and cannot read
    with foreign_reader(path, "numpy"), path.open("rb") as file, np.load(file, allow_pickle=False) as stored:
        V, F, crosses = (stored[name] for name in ("V", "F", "crosses"))
        V, F, crosses = V.astype(np.float64), F.astype(np.int64), crosses.astype(np.float64)
    if V.shape[1:] != (3,) or F.shape[1:] != (3,) or crosses.shape != (len(F), 2, 3):
        raise UnreadableFile(
            f"{path}: {V.shape} positions, {F.shape} triangles, {crosses.shape} crosses do not fit together",
            hint="neurframe discretize --force makes the file again",
        )
    check_indices(V, F, path, "triangle")
    return CrossCarrier(Surface(V, F), crosses)

"""The pipeline as functions on arrays: what `import neurframe_cli` offers to a program.

Each takes and returns numpy arrays and frozen dataclasses, prints nothing, and raises from neurframe_cli.errors.
A mesh that was made but does not pass its checks is returned, with valid = False.
"""

from __future__ import annotations

import tempfile
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from numpy.typing import ArrayLike

from neurframe_cli.errors import NotValid, UsageError
from neurframe_cli.mesh.arrays import Features, Floats, Ints, Progress, Surface, TetMesh, part, silent
from neurframe_cli.mesh.filling.hybrid_files import read_hybrid
from neurframe_cli.mesh.filling.hybrid_mesh import HybridMesh
from neurframe_cli.mesh.from_arrays import mesh_from_arrays
from neurframe_cli.mesh.read_cells import read_cells
from neurframe_cli.pipeline import artifacts
from neurframe_cli.pipeline.discretize_step import discretize_step
from neurframe_cli.pipeline.fill_step import FILLED
from neurframe_cli.pipeline.hex_options import HexOptions
from neurframe_cli.pipeline.hex_step import HEX, hex_step
from neurframe_cli.pipeline.manifest import StageRecord, read_manifest
from neurframe_cli.pipeline.mesh_step import MeshRequest
from neurframe_cli.pipeline.native import Limits
from neurframe_cli.pipeline.quad_source import QuadOptions
from neurframe_cli.pipeline.quad_step import QUAD, quad_step
from neurframe_cli.pipeline.runner import Step, run_stage
from neurframe_cli.pipeline.sizing import DEFAULT_SCALES, element_size
from neurframe_cli.pipeline.tetize_step import tetize_step
from neurframe_cli.pipeline.train_step import FIELD, train_step
from neurframe_cli.pipeline.workspace import Workspace
from neurframe_cli.stages.cross_surface import Choice, choose_cross_surface
from neurframe_cli.stages.tetize import TetizeOptions
from neurframe_cli.stages.train_options import TrainOptions

if TYPE_CHECKING:
    from neurframe_cli.stages.train import TrainResult

__all__ = [
    "Frames",
    "HexOptions",
    "HybridMesh",
    "Limits",
    "Mesh",
    "QuadOptions",
    "Result",
    "TetizeOptions",
    "Tets",
    "TrainOptions",
    "discretize",
    "hex",
    "quad",
    "run",
    "tetize",
    "train",
]

Kind = Literal["quad", "hex"]


@dataclass(frozen=True)
class Tets:
    """Tets that fill a model: V (n,3) in input coordinates, T (m,4) of positive volume.

    surface: the cleaned input; features: edges of the tets that bend sharply or were given; report: what the stage says
    of itself, ready for JSON, as in every result here.
    """

    V: Floats
    T: Ints
    surface: Surface
    features: Features
    report: dict[str, Any]

    @property
    def mesh(self) -> TetMesh:
        return TetMesh(self.V, self.T)


@dataclass(frozen=True)
class Frames:
    """The field on the meshes: frames (m,3,3) at the centroids of the tets, axes as columns; crosses (k,2,3), two unit
    tangents at the centroids of the carrier's triangles."""

    frames: Floats
    carrier: Surface
    crosses: Floats
    report: dict[str, Any]


@dataclass(frozen=True)
class Mesh:
    """A quad or hex mesh: V (n,3), cells (m,4) counter-clockwise from outside, or (m,8) in VTK order.

    quality: the numbers of the check by name, lengths in bounding-box diagonals; problems: why it is not valid;
    filled: with pyramids and tets, where the hexes are not valid and that was asked for.
    """

    kind: Kind
    V: Floats
    cells: Ints
    valid: bool
    problems: list[str]
    quality: dict[str, Any]
    report: dict[str, Any]
    filled: HybridMesh | None = None


@dataclass(frozen=True)
class Result:
    """Everything that run() has made; quad and hex are None where they were not asked for."""

    tets: Tets
    field: TrainResult
    frames: Frames
    quad: Mesh | None
    hex: Mesh | None


def tetize(
    V: ArrayLike, F: ArrayLike, options: TetizeOptions | None = None, *, progress: Progress = silent
) -> Tets:
    """Tets that fill the triangles F (m,3) over V (n,3); tets F (m,4) are checked and taken as they are.

    Raises InvalidMesh, StageError, TimedOut.
    """
    from neurframe_cli.stages.tetize import tetize as fill

    model = mesh_from_arrays(V, F)
    options = options or TetizeOptions()
    with tempfile.TemporaryDirectory(prefix="neurframe-") as scratch:
        given = model if isinstance(model, Surface) else (model, Features())
        found = fill(given, options, progress, Path(scratch))
    report = {"warnings": list(found.warnings), "seconds": found.seconds, "edge_length": found.edge_length}
    return Tets(found.tets.V, found.tets.T, found.surface, found.features, report)


def train(tets: Tets, options: TrainOptions | None = None, *, progress: Progress = silent) -> TrainResult:
    """The field in the tets (paper, section 4): `.field.query(points)` gives coefficients (n,9) at points (n,3).

    Raises InvalidMesh, StageError, UsageError.
    """
    from neurframe_cli.stages.train import train as learn

    return learn(tets.mesh, tets.features, options or TrainOptions(), progress)


def discretize(
    tets: Tets, field: TrainResult, *, surface: Choice = "auto", progress: Progress = silent
) -> Frames:
    """The field at the tets and on the surface; `surface`: whether the input's triangles carry the crosses or the
    tets'.  Raises StageError where the field is not finite."""
    from neurframe_cli.stages.discretize import discretize as query

    carrier, reason = choose_cross_surface(tets.surface, tets.mesh, surface)
    found = query(field.field.query, tets.mesh, carrier, tets.features, progress=progress)
    return Frames(found.tets.frames, carrier, found.crosses, {**found.summary(), "surface": reason})


def quad(
    tets: Tets,
    frames: Frames,
    *,
    scale: float | None = None,
    edge_length: float | None = None,
    count: int | None = None,
    feature_angle_deg: float = 45.0,
    options: QuadOptions | None = None,
    limits: Limits | None = None,
    progress: Progress = silent,
) -> Mesh:
    """Quads along the crosses; their edge is the bounding-box diagonal / scale (100 by default), or edge_length in
    input units, or whatever gives about `count` quads.

    Raises UsageError, StageError, TimedOut, and NotValid where there is no mesh at all.
    """
    size, most = element_size(scale, edge_length, count, DEFAULT_SCALES["quad"]), limits or Limits()
    request = MeshRequest(size, feature_angle_deg, most, pictures=False, quads=options or QuadOptions())
    return _from_arrays("quad", tets, frames, request, progress)


def hex(
    tets: Tets,
    frames: Frames,
    *,
    scale: float | None = None,
    edge_length: float | None = None,
    count: int | None = None,
    feature_angle_deg: float = 45.0,
    options: HexOptions | None = None,
    limits: Limits | None = None,
    progress: Progress = silent,
) -> Mesh:
    """Hexes along the frames; sizes as in quad(), scale 30 by default.  Raises as quad()."""
    size, most = element_size(scale, edge_length, count, DEFAULT_SCALES["hex"]), limits or Limits()
    request = MeshRequest(size, feature_angle_deg, most, pictures=False, hexes=options or HexOptions())
    return _from_arrays("hex", tets, frames, request, progress)


def run(
    V: ArrayLike,
    F: ArrayLike,
    *,
    quad: bool = False,
    hex: bool = False,
    scale: float | None = None,
    edge_length: float | None = None,
    tetize_options: TetizeOptions | None = None,
    train_options: TrainOptions | None = None,
    limits: Limits | None = None,
    workspace: str | Path | None = None,
    progress: Progress = silent,
) -> Result:
    """The whole pipeline on triangles F (m,3) or tets F (m,4) over V (n,3); quads and hexes where neither is asked for.

    scale, edge_length: of one of the two.  workspace: a folder that keeps all artifacts; what is unchanged in it is not
    done again, and `neurframe report -w` reads it.  Without one, nothing is left on disk.
    Raises UsageError, InvalidMesh, StageError, TimedOut, and NotValid where a mesh could not be made at all.
    """
    kinds: list[Kind] = ["quad"] if quad else []
    kinds += ["hex"] if hex else []
    kinds = kinds or ["quad", "hex"]
    if len(kinds) > 1 and (scale is not None or edge_length is not None):
        raise UsageError("scale and edge_length are for one mesh, two would be made")
    tetizing, training = tetize_options or TetizeOptions(), train_options or TrainOptions()
    sizes = {kind: element_size(scale, edge_length, None, DEFAULT_SCALES[kind]) for kind in kinds}
    model = mesh_from_arrays(V, F)
    with artifacts.kept_or_temporary(workspace) as where:
        steps = _Steps(where, 3 + len(kinds), progress)
        tets = steps.tets(model, tetizing)
        field = steps.field(training)
        frames = steps.frames()
        angle, most = tetizing.feature_angle_deg, limits or Limits()
        made = {
            kind: steps.mesh(kind, MeshRequest(sizes[kind], angle, most, pictures=False)) for kind in kinds
        }
    return Result(tets, field, frames, made.get("quad"), made.get("hex"))


class _Steps:
    """The stages on the files of a workspace, one after the other."""

    def __init__(self, workspace: Workspace, count: int, progress: Progress) -> None:
        self.workspace, self.count, self.progress = workspace, count, progress
        self.done = 0

    def tets(self, model: Surface | TetMesh, options: TetizeOptions) -> Tets:
        path, segments = artifacts.store_model(self.workspace, model), options.feature_segments
        features = None if segments is None else artifacts.store_segments(self.workspace, segments)
        report = self._run(tetize_step(path, features, replace(options, feature_segments=None))).report
        surface, tets, edges = artifacts.load_tets(self.workspace)
        return Tets(tets.V, tets.T, surface, edges, report)

    def field(self, options: TrainOptions) -> TrainResult:
        from neurframe_cli.field.field_file import read_field
        from neurframe_cli.stages.train import TrainResult

        report = self._run(train_step(self.workspace, options)).report
        return TrainResult(read_field(self.workspace / FIELD), report)

    def frames(self) -> Frames:
        report = self._run(discretize_step(self.workspace, "auto", pictures=False)).report
        return Frames(*artifacts.load_frames(self.workspace), report)

    def mesh(self, kind: Kind, request: MeshRequest) -> Mesh:
        return _mesh(kind, self.workspace, request, self._part())

    def _run(self, step: Step) -> StageRecord:
        return run_stage(self.workspace, step, self._part()).record

    def _part(self) -> Progress:
        self.done += 1
        return part(self.progress, (self.done - 1) / self.count, self.done / self.count)


def _from_arrays(kind: Kind, tets: Tets, frames: Frames, request: MeshRequest, progress: Progress) -> Mesh:
    with artifacts.kept_or_temporary(None) as workspace:
        artifacts.store_tets(workspace, tets.surface, tets.mesh, tets.features)
        artifacts.store_frames(workspace, frames.frames, frames.carrier, frames.crosses)
        return _mesh(kind, workspace, request, progress)


def _mesh(kind: Kind, workspace: Workspace, request: MeshRequest, progress: Progress) -> Mesh:
    step = (quad_step if kind == "quad" else hex_step)(workspace, request)
    try:
        run_stage(workspace, step, progress)
    except NotValid:
        if read_manifest(workspace.folder).stages[kind].status != "invalid":
            raise  # there is no mesh
    record = read_manifest(workspace.folder).stages[kind]
    cells = read_cells(workspace / (QUAD if kind == "quad" else HEX).outputs[0])
    report, valid = record.report, record.status == "done"
    filled = read_hybrid(workspace / FILLED[0]) if FILLED[0] in record.outputs else None
    return Mesh(kind, cells.V, cells.cells, valid, report["problems"], report["mesh"], report, filled)

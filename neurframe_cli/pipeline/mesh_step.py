"""What quad and hex share on files: map -> extract, and then write -> read back and check."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Literal

from neurframe_cli.errors import InputError, NotValid, StageError
from neurframe_cli.mesh.arrays import Features, Progress, Surface
from neurframe_cli.mesh.features import features_by_angle
from neurframe_cli.mesh.quality.check import Verdict
from neurframe_cli.mesh.read_cells import CellMesh, read_cells
from neurframe_cli.mesh.write_cells import write_cells
from neurframe_cli.picture.mesh_data import MeshData
from neurframe_cli.pipeline.atomic import atomic_path, scratch_folder
from neurframe_cli.pipeline.checking import check_file
from neurframe_cli.pipeline.hex_options import HexOptions
from neurframe_cli.pipeline.native import Limits, ProgramResult, run_program
from neurframe_cli.pipeline.pictures import draw_or_warn
from neurframe_cli.pipeline.quad_source import QuadOptions
from neurframe_cli.pipeline.runner import StageContext, Step
from neurframe_cli.pipeline.sizing import ElementSize
from neurframe_cli.pipeline.workspace import Workspace


@dataclass(frozen=True)
class MeshRequest:
    """What the user asked for; `quads` matters for quads only, `hexes` for hexes."""

    size: ElementSize
    feature_angle_deg: float
    limits: Limits
    pictures: bool
    quads: QuadOptions = field(default_factory=QuadOptions)
    hexes: HexOptions = field(default_factory=HexOptions)


@dataclass(frozen=True)
class Model:
    """The surface that a mesh is made of and checked against, and its features."""

    surface: Surface
    features: Features


@dataclass(frozen=True)
class MadeMesh:
    """A mesh before it is written: what the two programs said, and what else belongs into the report; extraction: None
    where nothing could be extracted, and the mesh was made in another way; replaced: cells of the map that this mesh
    is made instead of."""

    cells: CellMesh
    parametrization: ProgramResult
    extraction: ProgramResult | None
    report: Mapping[str, Any]
    replaced: CellMesh | None = None

    @property
    def statistics(self) -> dict[str, Any]:
        """Those of the two programs."""
        extraction = {} if self.extraction is None else {"extraction": self.extraction.statistics}
        return {"parametrization": self.parametrization.statistics, **extraction}


# make(context, inputs, model, request)
Maker = Callable[[StageContext, Mapping[str, Path], Model, MeshRequest], MadeMesh]
# complete(context, inputs, mesh, request, verdict): what else is made where not all is well, and its report
Completer = Callable[[StageContext, Mapping[str, Path], MadeMesh, MeshRequest, Verdict], dict[str, Any]]


def nothing_more(
    context: StageContext,
    inputs: Mapping[str, Path],
    made: MadeMesh,
    request: MeshRequest,
    verdict: Verdict,
) -> dict[str, Any]:
    """A mesh that is not valid is left as it is."""
    return {}


@dataclass(frozen=True)
class MeshKind:
    """How one kind of mesh is made.

    version: that of its Step, raised too where the programs make other maps; outputs: its files in the workspace, the
    first one is read back for the check; pictures: file by name of the drawing; extractor: the program that reads the
    map; extras: files that `complete` may write.
    """

    name: Literal["quad", "hex"]
    version: int
    map_name: str
    outputs: tuple[str, ...]
    extractor: str
    pictures: Mapping[str, str]
    make: Maker
    complete: Completer = nothing_more
    extras: tuple[str, ...] = ()


def mesh_step(
    kind: MeshKind,
    inputs: Mapping[str, Path],
    request: MeshRequest,
    read_model: Callable[[], Surface],
    options: Mapping[str, Any],
) -> Step:
    """The stage bound to its files; read_model() gives the surface; `options` are those of this kind alone."""

    def work(context: StageContext) -> dict[str, Any]:
        surface = read_model()
        features = features_by_angle(surface.V, surface.F, request.feature_angle_deg)
        made = kind.make(context, inputs, Model(surface, features), request)
        verdict = _write(kind, context, made.cells, surface, features)
        if request.pictures:
            draw_or_warn(context, kind.pictures, MeshData(made.cells.V, made.cells.cells))
        more = kind.complete(context, inputs, made, request, verdict)
        context.invalid = _what_is_wrong(kind, made, verdict)
        return {
            **made.statistics,
            **made.report,
            "mesh": verdict.numbers,
            "problems": verdict.problems,
            **more,
        }

    return Step(
        name=kind.name,
        version=kind.version,
        inputs=inputs,
        outputs=(kind.map_name, *kind.outputs, *kind.pictures.values(), *kind.extras),
        options={
            **asdict(request.size),
            "feature_angle_deg": request.feature_angle_deg,
            "pictures": request.pictures,
            **options,
        },
        unkeyed_options=asdict(request.limits),
        work=work,
        packages=("numpy", "scipy", "libigl", "meshio"),
        memory_mib=request.limits.memory_mib,
    )


def extract(
    kind: MeshKind,
    context: StageContext,
    limits: Limits,
    parametrization: ProgramResult,
    progress: Progress,
    map_file: Path | None = None,
) -> tuple[ProgramResult, CellMesh]:
    """The cells of the workspace's map, or of `map_file`; raises NotValid where there are none, or where a flawed map
    cannot be read."""
    with scratch_folder(context.workspace.folder) as scratch:
        raw = scratch / ("quads.obj" if kind.name == "quad" else "hexes.mesh")
        arguments: list[str | Path] = [map_file or context.workspace / kind.map_name, "-o", raw]
        try:
            result = run_program(kind.extractor, arguments, limits, progress)
            return result, read_cells(raw)
        except (InputError, StageError) as error:
            if isinstance(error, StageError) and parametrization.complete:
                raise
            # the file that cannot be used is our own, between two programs; an empty one has no cells
            empty = isinstance(error, InputError) and raw.exists() and raw.stat().st_size == 0
            reasons = "; ".join([*_flaws(parametrization), "there is none" if empty else str(error)])
            raise NotValid(
                f"no {kind.name} mesh could be extracted from the map: {reasons}",
                hint=f"{kind.map_name} is kept; try another scale, or another field (train --project)",
            ) from error


def _write(
    kind: MeshKind, context: StageContext, mesh: CellMesh, surface: Surface, features: Features
) -> Verdict:
    """Write every file of the workspace; the verdict is on what is read back."""
    for name in kind.outputs:
        with atomic_path(context.workspace / name) as temporary:
            write_cells(temporary, mesh)
    context.progress(0.95, "checking")
    return check_file(context.workspace / kind.outputs[0], surface, features)


def export_mesh(workspace: Workspace, kind: MeshKind, output: Path) -> None:
    """The mesh of the workspace once more, as another file in the format of its extension."""
    mesh = read_cells(workspace / kind.outputs[0])
    with atomic_path(output) as temporary:
        write_cells(temporary, mesh)


def _what_is_wrong(kind: MeshKind, made: MadeMesh, verdict: Verdict) -> str | None:
    """One line, None where the mesh is valid."""
    if verdict.valid:
        return None
    programs = [made.parametrization] if made.extraction is None else [made.parametrization, made.extraction]
    told = [flaw for program in programs for flaw in _flaws(program)]
    return "; ".join([f"the {kind.name} mesh is not valid: {', '.join(verdict.problems)}", *told])


def _flaws(result: ProgramResult) -> list[str]:
    """What a program that ended with exit code 4 says of its result: its last words, and the defects that it found."""
    if result.complete:
        return []
    found = result.statistics.get("defects", {})
    counted = {name: entry for name, entry in found.items() if entry.get("count")}
    told = [f"{entry['count']} x {name}{_place(entry)}" for name, entry in counted.items()]
    return [
        *filter(None, [result.last_words]),
        *([f"defects of the field: {', '.join(told)}"] if told else []),
    ]


def _place(entry: Mapping[str, Any]) -> str:
    places = entry.get("places")
    return f" (the first at {', '.join(f'{x:.4g}' for x in places[0])})" if places else ""

"""The stages as `run` and the single commands call them: options to step, step to runner, outcome to console."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from neurframe_cli.errors import NotValid
from neurframe_cli.pipeline.manifest import read_manifest
from neurframe_cli.pipeline.runner import StageOutcome, Step, run_stage
from neurframe_cli.pipeline.workspace import Workspace

if TYPE_CHECKING:
    from neurframe_cli.cli.console import Console
    from neurframe_cli.pipeline.mesh_step import MeshKind, MeshRequest

# options of `neurframe train` that TrainOptions knows by the same name
_TRAIN_OPTIONS = (
    "preset",
    "method",
    "iterations",
    "batch_fraction",
    "learning_rate",
    "lambda_smooth",
    "lambda_boundary",
    "lambda_feature",
    "sigma",
    "seed",
    "device",
    "precision",
    "project",
)


# options of `neurframe quad` that QuadOptions knows by the same name; `neurframe run` has not all of them
_QUAD_OPTIONS = ("adaptive", "symmetry", "field", "surface_file")


def tetize_of(model: Path, values: Mapping[str, Any]) -> Step:
    """INPUT -> tets."""
    from neurframe_cli.pipeline.tetize_step import tetize_step
    from neurframe_cli.stages.tetize import TetizeOptions

    options = TetizeOptions(
        edge_length=values["tet_edge_length"],
        epsilon=values["epsilon"],
        feature_angle_deg=values["feature_angle"],
        seed=values["seed"],
        timeout_s=values["timeout"],
        memory_mib=values["memory"],
    )
    return tetize_step(model, values["features"], options)


def train_of(workspace: Workspace, values: Mapping[str, Any], threads: int, *, fresh: bool = False) -> Step:
    """Tets -> field."""
    from neurframe_cli.pipeline.train_step import train_step
    from neurframe_cli.stages.train import TrainOptions

    options = TrainOptions(
        **{name: values[name] for name in _TRAIN_OPTIONS},
        time_budget_s=values["time_budget"],
        threads=threads,
    )
    return train_step(workspace, options, fresh=fresh, memory_mib=values["memory"])


def discretize_of(workspace: Workspace, values: Mapping[str, Any]) -> Step:
    """Field -> frames and crosses."""
    from neurframe_cli.pipeline.discretize_step import discretize_step

    return discretize_step(
        workspace, values["surface"], pictures=values["pictures"], memory_mib=values["memory"]
    )


def points_stage(
    workspace: Workspace, points: Path, console: Console, *, force: bool = False
) -> StageOutcome:
    """Field -> frames at given points."""
    from neurframe_cli.pipeline.discretize_step import points_step

    return run_step(workspace, points_step(workspace, points), console, force=force)


Kind = Literal["quad", "hex"]


def mesh_request(kinds: Sequence[Kind], values: Mapping[str, Any], threads: int) -> dict[Kind, MeshRequest]:
    """What is asked of each mesh, checked before anything is computed; raises UsageError or UnsupportedFormat."""
    from neurframe_cli.mesh.filling.hybrid_files import check_hybrid_output
    from neurframe_cli.mesh.write_cells import check_output
    from neurframe_cli.pipeline.hex_options import HexOptions
    from neurframe_cli.pipeline.mesh_step import MeshRequest
    from neurframe_cli.pipeline.native import Limits
    from neurframe_cli.pipeline.quad_source import QuadOptions
    from neurframe_cli.pipeline.sizing import DEFAULT_SCALES, element_size
    from neurframe_cli.stages.run_netgen import require_netgen

    quads = QuadOptions(**{name: values[name] for name in _QUAD_OPTIONS if name in values})
    hexes = HexOptions(
        padding=values.get("padding"),
        splitting=values.get("splitting", True),
        grid=values.get("grid"),
        fill=values.get("fill", False),
    )
    if hexes.fill and "hex" in kinds:
        require_netgen()
    limits = Limits(values["timeout"], values["memory"], threads)
    requests: dict[Kind, MeshRequest] = {}
    for kind in kinds:
        if values["output"] is not None:
            check_output(values["output"], kind)
        if values["output"] is not None and kind == "hex" and hexes.fill:
            check_hybrid_output(values["output"])
        size = element_size(values["scale"], values["edge_length"], values.get("count"), DEFAULT_SCALES[kind])
        requests[kind] = MeshRequest(size, values["feature_angle"], limits, values["pictures"], quads, hexes)
    return requests


def mesh_stage(
    kind: Kind,
    workspace: Workspace,
    request: MeshRequest,
    output: Path | None,
    console: Console,
    *,
    force: bool = False,
) -> StageOutcome:
    """Make the mesh; then the further file, also of a mesh that was there already."""
    try:
        outcome = run_step(workspace, mesh_of(kind, workspace, request), console, force=force)
    except NotValid:
        _export(workspace, mesh_kind(kind), output)
        raise
    _export(workspace, mesh_kind(kind), output)
    return outcome


def mesh_of(kind: Kind, workspace: Workspace, request: MeshRequest) -> Step:
    """Crosses -> quads, or frames -> hexes."""
    from neurframe_cli.pipeline.hex_step import hex_step
    from neurframe_cli.pipeline.quad_step import quad_step

    return (quad_step if kind == "quad" else hex_step)(workspace, request)


def mesh_kind(kind: Kind) -> MeshKind:
    """The files of quads or hexes."""
    from neurframe_cli.pipeline.hex_step import HEX
    from neurframe_cli.pipeline.quad_step import QUAD

    return QUAD if kind == "quad" else HEX


def _export(workspace: Workspace, kind: MeshKind, output: Path | None) -> None:
    from neurframe_cli.pipeline.fill_step import FILLED, export_filled
    from neurframe_cli.pipeline.mesh_step import export_mesh

    if output is None or not (workspace / kind.outputs[0]).is_file():
        return
    if FILLED[0] in read_manifest(workspace.folder).stages[kind.name].outputs:
        export_filled(workspace, output)
    else:
        export_mesh(workspace, kind, output)


def run_step(workspace: Workspace, step: Step, console: Console, *, force: bool = False) -> StageOutcome:
    """Run one step with its progress shown, and say what came of it, also where that is not valid."""
    try:
        with console.progress(step.name) as progress:
            outcome = run_stage(workspace, step, progress, force=force)
    except NotValid:
        record = read_manifest(workspace.folder).stages[step.name]
        if record.status == "invalid":  # else there is no mesh
            _say(step.name, StageOutcome(record, skipped=False), console)
        raise
    _say(step.name, outcome, console)
    return outcome


def _say(stage: str, outcome: StageOutcome, console: Console) -> None:
    record = outcome.record
    lines = summary(stage, record.report) if record.report else []
    console.ended(stage, record, skipped=outcome.skipped, said=lines[0] if lines else "")
    if outcome.skipped:
        console.log.info("%s: unchanged, skipped", stage)
    else:
        console.log.info("%s: done in %.1f s, peak %.0f MiB", stage, record.seconds, record.peak_mib)
    for line in lines:
        console.log.info("  %s", line)


def summary(stage: str, report: Mapping[str, Any]) -> list[str]:
    """A stage's most telling numbers, a line each."""
    if stage == "tetize":
        return [
            f"{report['tets']} tets, {report['vertices']} vertices, {report['feature_edges']} feature edges "
            f"in {report['feature_chains']} chains"
        ]
    if stage == "train":
        losses = report["losses"]
        return [
            f"loss {losses['total']:.5f} (smoothness {losses['smooth']:.5f}, boundary {losses['boundary']:.5f}, "
            f"feature {losses['feature']:.5f}) on {report['device']}"
        ]
    if stage == "discretize":
        return [
            f"{report['singular_edges']} singular edges, {report['singular_length']:.2f} diagonals long",
            f"normals off by {report['normal_deg_mean']:.2f} degrees (mean), {report['normal_deg_max']:.1f} (worst)",
            f"crosses on {report['surface']}",
        ]
    if stage == "distill":
        before, after = report["before"], report["after"]
        return [
            f"frames off those of the map by {after['mean_deg']:.2f} degrees (mean), {after['p95_deg']:.1f} (95th "
            f"percentile); before by {before['mean_deg']:.2f} and {before['p95_deg']:.1f}",
            f"{100 * after['same_matchings']:.2f} % of the faces have the map's matching; before "
            f"{100 * before['same_matchings']:.2f} %",
        ]
    if stage in ("quad", "hex"):
        mesh = report["mesh"]
        return [
            f"{mesh['cells']} {'quads' if stage == 'quad' else 'hexes'}, scaled Jacobian "
            f"{mesh['min_scaled_jacobian']:.3f} (worst) {mesh['mean_scaled_jacobian']:.3f} (mean)",
            f"distance to the input {100 * mesh['hausdorff']:.2f} % of the diagonal",
            *_hex_summary(report),
        ]
    return [", ".join(f"{value} {name}" for name, value in report.items())]


def _hex_summary(report: Mapping[str, Any]) -> list[str]:
    """How much of the volume is in hexes where that is not all of it, and what the rest was filled with."""
    share, filled = report["mesh"].get("valid_volume_share"), report.get("filled")
    lines = []
    if share is not None and report.get("problems"):
        lines.append(f"{100 * share:.1f} % of the volume in hexes that are not inverted")
    if filled and "error" not in filled:
        lines.append(
            f"filled: {filled['hexes']} hexes ({100 * filled['hex_volume_share']:.1f} % of the volume), "
            f"{filled['pyramids']} pyramids, {filled['tets']} tets, "
            f"{'conforming' if filled['valid'] else 'NOT VALID'}"
        )
    return lines

"""tetize on files: INPUT -> surface.ply, tets.mesh, features.json."""

from __future__ import annotations

from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from neurframe_cli.mesh.arrays import Features, Surface, TetMesh
from neurframe_cli.mesh.features import write_features
from neurframe_cli.mesh.load import load_model
from neurframe_cli.mesh.open_file import check_file
from neurframe_cli.mesh.read_feature_segments import read_feature_segments
from neurframe_cli.mesh.write_mesh import write_surface, write_tets
from neurframe_cli.pipeline.atomic import atomic_path, scratch_folder
from neurframe_cli.pipeline.forecast import Amount, expected_tets
from neurframe_cli.pipeline.runner import StageContext, Step
from neurframe_cli.stages.tetize import TetizeOptions, TetizeResult, tetize
from neurframe_cli.stages.tetize_attempts import COARSEST_FACTOR

SURFACE, TETS, FEATURES = "surface.ply", "tets.mesh", "features.json"
_UNKEYED = ("threads",)  # the limits count: where they are hit, coarser tets are made


def tetize_step(model: Path, features: Path | None, options: TetizeOptions) -> Step:
    """The stage bound to its files; `features` is a list of feature edges of the model, None to go by the angle."""
    values = asdict(options)
    values.pop("feature_segments")
    inputs = {"model": model} | ({"features": features} if features is not None else {})
    for path in inputs.values():
        check_file(path)

    def work(context: StageContext) -> dict[str, Any]:
        loaded = load_model(model)
        context.expect("tetize", _amount(loaded, options))
        given = None if features is None else read_feature_segments(features, loaded)
        with scratch_folder(context.workspace.folder) as scratch:
            chosen = replace(options, feature_segments=given)
            result = tetize(loaded, chosen, context.progress, scratch, name=str(model))
        for warning in result.warnings:
            context.warn(warning)
        _write(context, result)
        return {"model": model.name, **_report(result)}

    return Step(
        name="tetize",
        version=1,
        inputs=inputs,
        outputs=(SURFACE, TETS, FEATURES),
        options={name: value for name, value in values.items() if name not in _UNKEYED},
        unkeyed_options={name: values[name] for name in _UNKEYED},
        work=work,
        packages=("pytetwild", "trimesh", "meshio", "numpy"),
        memory_mib=options.memory_mib,
    )


def _amount(model: Surface | tuple[TetMesh, Features], options: TetizeOptions) -> Amount:
    """What there will be at the least: tets that do not fit into the memory are made again with longer edges."""
    if not isinstance(model, Surface):
        return Amount(len(model[0].T), is_surface=False)
    longest = min(COARSEST_FACTOR * options.edge_length, 1.0)
    return Amount(expected_tets(model, longest), len(model.F))


def _write(context: StageContext, result: TetizeResult) -> None:
    with atomic_path(context.workspace / SURFACE) as path:
        write_surface(path, result.surface)
    with atomic_path(context.workspace / TETS) as path:
        write_tets(path, result.tets, result.features)
    with atomic_path(context.workspace / FEATURES) as path:
        write_features(path, result.features)


def _report(result: TetizeResult) -> dict[str, Any]:
    return {
        "vertices": len(result.tets.V),
        "tets": len(result.tets.T),
        "divided_boundary_tets": result.divided,
        "feature_edges": len(result.features.edges),
        "feature_chains": len(result.features.chains),
        "feature_corners": len(result.features.corners),
        "edge_length": result.edge_length,
        "seeded": result.seeded,
        "attempts": [asdict(attempt) for attempt in result.attempts],
        "cleaning": None if result.cleaning is None else asdict(result.cleaning),
        "fit": None if result.fit is None else asdict(result.fit),
    }

"""Workspaces for the tests of reports: real files of small meshes, with a manifest as the stages leave it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from test_quality import cube_shell, hex_grid

from neurframe_cli.field.singular_edges import SingularEdges
from neurframe_cli.mesh.arrays import Floats, Ints, Surface
from neurframe_cli.mesh.features import features_by_angle
from neurframe_cli.mesh.quality.check import CheckOptions, check_hexes, check_quads
from neurframe_cli.mesh.quality.polygons import triangulated
from neurframe_cli.mesh.read_cells import CellMesh
from neurframe_cli.mesh.write_cells import write_cells
from neurframe_cli.mesh.write_mesh import write_surface
from neurframe_cli.picture.vtp import (
    write_singular_edges_vtp,
    write_singular_points_vtp,
    write_streamlines_vtp,
)
from neurframe_cli.pipeline.manifest import Manifest, StageRecord, write_manifest

SIDE = 4
DEFECT = [0.25, 0.5, 0.75]


def dented_cube() -> tuple[Floats, Ints]:
    """The unit cube as 4^3 hexes, one interior vertex moved so that exactly one hex is the worst."""
    V, H = hex_grid(SIDE)
    middle = int(np.abs(V - 0.5).sum(axis=1).argmin())
    V[middle] += [0.1, 0.07, 0.05]
    return V, H


def make_workspace(folder: Path, *, valid: bool = True, warning: str = "") -> Path:
    """A cube with quads, hexes, a singular line, streamlines and pictures; not `valid`: as after a failed hex."""
    folder.mkdir(parents=True)
    V, Q = cube_shell(SIDE)
    surface = Surface(V, triangulated(Q))
    features = features_by_angle(V, surface.F, 45.0)
    write_surface(folder / "surface.ply", surface)
    write_cells(folder / "quad.obj", CellMesh("quad", V, Q))
    hexes = dented_cube()
    write_cells(folder / "hex.vtk", CellMesh("hex", *hexes))
    _write_curves(folder)
    for name in ("quad.png", "hex.png", "hex-cut.png", "field-singular.png"):
        Image.new("RGB", (1600, 1200), "white").save(folder / name)
    stages = {
        "tetize": _record(
            {"vertices": 9, "tets": 12, "feature_edges": 12, "feature_chains": 12}, "surface.ply"
        ),
        "train": _record({"losses": {"total": 0.125}, "projected_losses": {"total": 0.25}}, "train.jsonl"),
        "discretize": _record(
            {"singular_edges": 1, "normal_deg_mean": 0.5, "normal_deg_max": 1.5},
            "singular_edges.vtp",
            "field-singular.png",
        ),
        "singularities": _record({"points": 5}, "singularities.vtp"),
        "streamlines": _record({"volume": 1, "surface": 1}, "streamlines.vtp"),
        "quad": _record(
            {"mesh": check_quads(V, Q, surface, features, CheckOptions()).numbers}, "quad.obj", "quad.png"
        ),
        "hex": _record(
            {"mesh": check_hexes(*hexes, surface, features, CheckOptions()).numbers},
            "hex.vtk",
            "hex.png",
            "hex-cut.png",
        ),
    }
    if warning:
        stages["tetize"].warnings.append(warning)
    if not valid:
        _spoil(stages["hex"])
    write_manifest(folder, Manifest(stages))
    return folder


def _record(report: dict[str, Any], *outputs: str) -> StageRecord:
    return StageRecord(
        "done",
        "0" * 64,
        options={"seed": 0},
        inputs={"model": "a" * 64},
        outputs=dict.fromkeys(outputs, "b" * 64),
        versions={"neurframe": "0.1.0"},
        started="2026-01-02T03:04:05+00:00",
        seconds=1.25,
        cpu_seconds=2.5,
        peak_mib=321.5,
        report=report,
    )


def _spoil(record: StageRecord) -> None:
    record.status, record.error = "invalid", "the hex mesh is not valid: 1 cells with a corner Jacobian <= 0"
    record.report["parametrization"] = {
        "defects": {"off-axis edge": {"count": 1, "places": [DEFECT]}},
        "map": {"valid": False, "folded_tets": {"count": 0, "places": []}},
    }


def _write_curves(folder: Path) -> None:
    line = np.stack([np.full(5, 0.5), np.full(5, 0.5), np.linspace(0, 1, 5)], axis=1)
    edges = np.stack([np.arange(4), np.arange(1, 5)], axis=1)
    ones = np.ones(4)
    singular = SingularEdges(edges, np.full(4, 1), np.full(4, 1), ones, ones, 1.0)
    write_singular_edges_vtp(folder / "singular_edges.vtp", line, singular)
    five = np.ones(5, np.int64)
    write_singular_points_vtp(folder / "singularities.vtp", line, five, five, line)
    write_streamlines_vtp(folder / "streamlines.vtp", [line], [line[:2]])
    steps = [
        {"event": "step", "objective": "distill", "round": 1, "seconds": 0.5 * k, "step": k, "value": 2.0**-k}
        for k in range(20)
    ]
    (folder / "train.jsonl").write_text("".join(json.dumps(step) + "\n" for step in steps))

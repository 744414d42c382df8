"""Everything that is known of a workspace, as one JSON document: what report.json holds and report.html shows."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import Any

import numpy as np

from neurframe_cli import __version__
from neurframe_cli.errors import NeurframeError, UsageError
from neurframe_cli.mesh.read_cells import CellMesh, read_cells
from neurframe_cli.mesh.read_surface import read_surface
from neurframe_cli.pipeline.manifest import Manifest, StageRecord, read_manifest
from neurframe_cli.pipeline.report_trouble import troubles
from neurframe_cli.pipeline.workspace import Workspace
from neurframe_cli.report.mesh_quality import cell_quality, describe_quality

FORMAT, VERSION = "neurframe-report", 1
# the order of the pipeline; the manifest's own is alphabetical
STAGES = ("tetize", "train", "discretize", "points", "singularities", "streamlines", "quad", "hex", "distill")
# the files by their names: to import the stages that write them is to import torch
SURFACE, TRAIN_LOG = "surface.ply", "train.jsonl"
MESH_FILES = {"quad": "quad.obj", "hex": "hex.vtk"}


def report_document(workspace: Workspace) -> tuple[dict[str, Any], dict[str, CellMesh]]:
    """The document and the meshes that it describes; raises UsageError where no stage has been run yet.

    An artifact that is damaged is left out, and the document's `notes` say so.
    """
    manifest = read_manifest(workspace.folder)
    if not manifest.stages:
        raise UsageError(f"nothing has been done in {workspace.folder}", hint="neurframe run INPUT")
    notes: list[str] = []
    meshes = _meshes(workspace, manifest, notes)
    ordered = sorted(manifest.stages, key=lambda name: STAGES.index(name) if name in STAGES else len(STAGES))
    records = {name: asdict(manifest.stages[name]) for name in ordered}
    document = {
        "format": FORMAT,
        "version": VERSION,
        "neurframe": __version__,
        "workspace": workspace.folder.resolve().name,
        "outcome": outcome(manifest),
        "totals": _totals(manifest),
        "stages": records,
        "surface": _surface(workspace, manifest, notes),
        "training": _training(workspace, manifest, notes),
        "meshes": {kind: describe_quality(mesh, cell_quality(mesh)) for kind, mesh in meshes.items()},
        "troubles": troubles(manifest),
        "notes": notes,
    }
    return document, meshes


def outcome(manifest: Manifest) -> str:
    """`failed`, `unfinished` and `invalid` before `valid`; `no mesh` where none was asked for yet."""
    statuses = {record.status for record in manifest.stages.values()}
    for status, name in (
        ("failed", "failed"),
        ("interrupted", "unfinished"),
        ("running", "unfinished"),
        ("invalid", "invalid"),
    ):
        if status in statuses:
            return name
    return "valid" if MESH_FILES.keys() & manifest.stages.keys() else "no mesh"


def has_output(manifest: Manifest, stage: str, name: str) -> bool:
    """Whether file `name` was left by a finished run of `stage`: what an earlier one left is out of date."""
    record = manifest.stages.get(stage)
    return record is not None and record.status in ("done", "invalid") and name in record.outputs


def _totals(manifest: Manifest) -> dict[str, float]:
    records: list[StageRecord] = list(manifest.stages.values())
    return {
        "seconds": round(sum(record.seconds for record in records), 3),
        "cpu_seconds": round(sum(record.cpu_seconds for record in records), 3),
        "peak_mib": max(record.peak_mib for record in records),
    }


def _meshes(workspace: Workspace, manifest: Manifest, notes: list[str]) -> dict[str, CellMesh]:
    meshes = {}
    for kind, name in MESH_FILES.items():
        if has_output(manifest, kind, name):
            try:
                meshes[kind] = read_cells(workspace / name)
            except NeurframeError as error:
                notes.append(str(error))
    return meshes


def _surface(workspace: Workspace, manifest: Manifest, notes: list[str]) -> dict[str, Any] | None:
    """Size of the cleaned input."""
    if not has_output(manifest, "tetize", SURFACE):
        return None
    try:
        surface = read_surface(workspace / SURFACE)
    except NeurframeError as error:
        notes.append(str(error))
        return None
    low, high = surface.V.min(axis=0), surface.V.max(axis=0)
    return {
        "vertices": len(surface.V),
        "triangles": len(surface.F),
        "bounding_box": [low.tolist(), high.tolist()],
        "diagonal": float(np.linalg.norm(high - low)),
    }


def _training(workspace: Workspace, manifest: Manifest, notes: list[str]) -> list[dict[str, Any]]:
    """The lines of train.jsonl, also of a training that is still under way or was interrupted."""
    path = workspace / TRAIN_LOG
    if "train" not in manifest.stages or not path.is_file():
        return []
    try:
        records = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
    except (OSError, ValueError) as error:
        notes.append(f"{path} cannot be read: {error}")
        return []
    return [record for record in records if isinstance(record, dict)]

"""Tets from a surface (fTetWild), or a checked tet mesh from a tet mesh."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from neurframe_cli.errors import InvalidMesh, UsageError
from neurframe_cli.mesh.arrays import Features, Floats, Ints, Progress, Surface, TetMesh
from neurframe_cli.mesh.check_tets import checked_tets
from neurframe_cli.mesh.clean_surface import CleaningReport, clean_surface
from neurframe_cli.mesh.features import features_by_angle, features_from_edges
from neurframe_cli.mesh.features_from_segments import features_from_segments
from neurframe_cli.mesh.manifold_boundary import boundary_surface, make_boundary_manifold
from neurframe_cli.mesh.measure import box_diagonal
from neurframe_cli.mesh.open_surface import refuse_large_holes
from neurframe_cli.mesh.subdivide_boundary_tets import subdivide_boundary_tets
from neurframe_cli.mesh.tet_adjacency import tet_adjacency
from neurframe_cli.stages.tetize_attempts import Attempt, Task, first_success, manifold_warnings
from neurframe_cli.stages.tetize_check import Fit


@dataclass(frozen=True)
class TetizeOptions:
    """Lengths are fractions of the diagonal of the input's bounding box.

    edge_length: target length of the tets' edges; epsilon: how far the surface may move; feature_angle_deg:
    edges of the tets' boundary that bend by more are features; feature_segments (k,2,3): feature edges given as
    end points in input coordinates, which then count instead of the angle; divide_boundary_tets: no tet keeps two
    boundary faces; threads: 0 for all cores; timeout_s: for all attempts together; memory_mib: of one attempt,
    None for what the machine has free.
    """

    edge_length: float = 0.025
    epsilon: float = 1e-3
    feature_angle_deg: float = 45.0
    feature_segments: Floats | None = None
    divide_boundary_tets: bool = True
    seed: int = 0
    threads: int = 1
    timeout_s: float = 600.0
    memory_mib: float | None = None

    def __post_init__(self) -> None:
        _check_range("edge length", self.edge_length, 1e-4, 1.0)
        _check_range("epsilon", self.epsilon, 1e-6, 0.1)
        _check_range("feature angle", self.feature_angle_deg, 0.0, 180.0)
        _check_range("seed", self.seed, 0, 2**63 - 1)
        _check_range("threads", self.threads, 0, 4096)
        _check_range("timeout", self.timeout_s, 0.0, float("inf"))
        if self.memory_mib is not None:
            _check_range("memory", self.memory_mib, 1.0, float("inf"))


@dataclass(frozen=True)
class TetizeResult:
    """What tetize found and made.

    surface: the cleaned input, or the boundary of an input tet mesh; tets in input coordinates; features on the
    vertices of tets; seeded: whether the same seed gives the same mesh again; divided: tets that were divided
    because they had two boundary faces; cleaning, fit: None for an input tet mesh; edge_length: the one that was
    reached, larger than asked where only that succeeded.
    """

    surface: Surface
    tets: TetMesh
    features: Features
    seeded: bool
    warnings: tuple[str, ...]
    seconds: float
    attempts: tuple[Attempt, ...]
    divided: int
    edge_length: float
    cleaning: CleaningReport | None
    fit: Fit | None


def tetize(
    model: Surface | tuple[TetMesh, Features],
    options: TetizeOptions,
    progress: Progress,
    scratch_dir: Path,
    *,
    name: str | Path = "the model",
) -> TetizeResult:
    """A tet mesh of positive volumes and manifold boundary that fills `model`.

    A surface is cleaned and filled by fTetWild (Hu et al., "Fast tetrahedral meshing in the wild", SIGGRAPH 2020)
    in a child process, whose files go to `scratch_dir`; a tet mesh is checked and passed through.
    `name` stands for the model in messages.  Raises InvalidMesh, StageError (ChildCrashed, ChildOutOfMemory among
    them), TimedOut.
    """
    started = time.monotonic()
    if isinstance(model, Surface):
        progress(0.0, "cleaning the surface")
        surface, report = clean_surface(model, name)
        warnings = _cleaning_warnings(report) + refuse_large_holes(surface, name)
        return _filled(Task(surface, report, options, progress, scratch_dir), warnings, started)
    return _passed_through(*model, options, started, name)


def _filled(task: Task, warnings: list[str], started: float) -> TetizeResult:
    """fTetWild's tets, divided, with their features."""
    found = first_success(task)
    tets, _, divided = _divide(found.tets, np.zeros((0, 2), np.int64), task.options)
    features, feature_warnings = _features(tets, task.options)
    task.progress(1.0, "tets done")
    return TetizeResult(
        surface=task.surface,
        tets=tets,
        features=features,
        seeded=found.seeded,
        warnings=tuple(warnings + found.warnings + feature_warnings),
        seconds=time.monotonic() - started,
        attempts=found.attempts,
        divided=divided,
        edge_length=found.attempts[-1].settings.edge_length_fac,
        cleaning=task.report,
        fit=found.fit,
    )


def _passed_through(
    mesh: TetMesh, features: Features, options: TetizeOptions, started: float, name: str | Path
) -> TetizeResult:
    """Checks and divides; the file's features win over the angle, given segments over both."""
    checked, new_number = checked_tets(mesh.V, mesh.T, name)
    edges = new_number[features.edges]
    repaired, report = make_boundary_manifold(checked)
    if not report.unchanged and len(edges):
        raise InvalidMesh(
            f"{name}: the boundary of the tet mesh is not manifold ({report.halved_edges} edges, "
            f"{report.copied_vertices + report.cut_vertices} vertices), and feature edges run over it",
            hint="take the parts apart where they touch, or drop the features from the file",
        )
    if report.pinched_vertices:
        raise InvalidMesh(f"{name}: the boundary touches itself at {report.pinched_vertices} vertices")
    warnings = manifold_warnings(report)
    surface = Surface(*boundary_surface(repaired))
    tets, edges, divided = _divide(repaired, edges, options)
    if len(edges) and options.feature_segments is None:
        tet_features = features_from_edges(tets.V, edges, new_number[features.corners])
    else:
        tet_features, more = _features(tets, options)
        warnings += more
    return TetizeResult(
        surface=surface,
        tets=tets,
        features=tet_features,
        seeded=True,
        warnings=tuple(warnings),
        seconds=time.monotonic() - started,
        attempts=(),
        divided=divided,
        edge_length=_mean_edge_length(tets),
        cleaning=None,
        fit=None,
    )


def _divide(mesh: TetMesh, edges: Ints, options: TetizeOptions) -> tuple[TetMesh, Ints, int]:
    """subdivide_boundary_tets where it is asked for; the result is checked again."""
    if not options.divide_boundary_tets:
        return mesh, edges, 0
    mesh, edges, divided = subdivide_boundary_tets(mesh, edges)
    checked, _ = checked_tets(mesh.V, mesh.T)
    return checked, edges, divided


def _features(tets: TetMesh, options: TetizeOptions) -> tuple[Features, list[str]]:
    faces = tet_adjacency(tets.T).boundary_faces
    if options.feature_segments is None:
        return features_by_angle(tets.V, faces, options.feature_angle_deg), []
    return features_from_segments(tets.V, faces, options.feature_segments)


def _cleaning_warnings(report: CleaningReport) -> list[str]:
    found = {
        "degenerate triangles dropped": report.degenerate,
        "duplicate triangles dropped": report.duplicate,
        "triangles turned round": report.turned,
        "triangles of walls inside the solid dropped": report.inner_sheets,
        "shells lie inside solid material and bound nothing": report.nested,
        "open edges": report.open_edges,
        "non-manifold edges": report.nonmanifold_edges,
        "pairs of triangles that cross or touch": report.self_intersections,
    }
    return [f"input: {count} {what}" for what, count in found.items() if count]


def _mean_edge_length(mesh: TetMesh) -> float:
    """As a fraction of the bounding-box diagonal."""
    a, b = (mesh.V[mesh.T[:, i]] for i in ([0, 0, 0, 1, 1, 2], [1, 2, 3, 2, 3, 3]))
    diagonal = box_diagonal(mesh.V)
    return float(np.linalg.norm(a - b, axis=2).mean() / diagonal)


def _check_range(name: str, value: float, lowest: float, highest: float) -> None:
    if not lowest <= value <= highest:
        raise UsageError(f"{name} is {value}, allowed is {lowest} to {highest}")

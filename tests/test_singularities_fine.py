"""Singular points lie where the singular edges of the same field go on ever finer tets: benchmarks/singularities.py."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from field_shapes import box_tets, cylinder_tets, four_line_frames

from neurframe_cli.field.frames import frame_to_band4
from neurframe_cli.mesh.arrays import Floats, TetMesh
from neurframe_cli.mesh.tet_adjacency import tet_adjacency
from neurframe_cli.stages.singularities import SingularitiesOptions, find_singularities

SCRIPT = Path(__file__).parent.parent / "benchmarks" / "singularities.py"


@pytest.fixture(scope="module")
def benchmark() -> ModuleType:
    spec = importlib.util.spec_from_file_location("singularities_benchmark", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # where dataclasses look up the names in their annotations
    spec.loader.exec_module(module)
    return module


def test_tets_in_eight_fill_the_same_box(benchmark: ModuleType) -> None:
    mesh = benchmark.divided(benchmark.divided(TetMesh(*box_tets((1, 1, 2)))))
    volumes = np.linalg.det(mesh.V[mesh.T][:, 1:] - mesh.V[mesh.T][:, :1]) / 6
    assert volumes.min() > 0
    whole = np.ptp(mesh.V, axis=0).prod()
    assert volumes.sum() == pytest.approx(whole)
    assert len(tet_adjacency(mesh.T).boundary_faces) == 16 * len(
        tet_adjacency(box_tets((1, 1, 2))[1]).boundary_faces
    )


@pytest.mark.slow
def test_singular_edges_of_finer_tets_come_nearer_to_the_points(benchmark: ModuleType) -> None:
    def query(points: Floats) -> Floats:
        return frame_to_band4(four_line_frames(points))

    mesh = TetMesh(*cylinder_tets(10, 6))
    diagonal = float(np.linalg.norm(np.ptp(mesh.V, axis=0)))
    points = find_singularities(query, mesh, SingularitiesOptions(samples=150, tolerance=0.005)).points
    levels = benchmark.levels(query, mesh, points, finest=0.025)
    assert len(levels) >= 3
    worst = [benchmark.distances(points, level.segments, diagonal)[0].max() for level in levels]
    assert worst == sorted(worst, reverse=True)
    # an edge of a zigzag round the line is off by less than the edge of the tets that it belongs to
    assert worst[-1] < 100 * levels[-1].edge

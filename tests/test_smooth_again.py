"""What is measured again after some vertices have moved is what a fresh measurement gives."""

from __future__ import annotations

import numpy as np
import pytest
from smooth_shapes import Shape, cube_hexes, cube_quads, jitter, torus_quads

from neurframe_cli.mesh.arrays import Floats
from neurframe_cli.mesh.optimize.cell_kind import HEXES, QUADS
from neurframe_cli.mesh.optimize.classify import classify
from neurframe_cli.mesh.optimize.distance_probe import DistanceProbe
from neurframe_cli.mesh.optimize.improve import ImproveOptions, Improver, quad_normals
from neurframe_cli.mesh.optimize.simplex_tree import SimplexTree
from neurframe_cli.mesh.quality.polygons import triangulated
from neurframe_cli.stages.smooth_hexes import boundary_quads


def some_moved(V: Floats, share: float) -> Floats:
    """V with the given share of the vertices moved by up to a tenth."""
    moved = np.random.default_rng(1).random(len(V)) < share
    return np.where(moved[:, None], jitter(V, 0.1, seed=2), V)


@pytest.mark.parametrize("shape", [torus_quads(20, 8), cube_hexes(4)])
@pytest.mark.parametrize("share", [0.0, 0.03, 1.0])
def test_quality_of_cells_that_moved(shape: Shape, share: float) -> None:
    quads = shape.cells.shape[1] == 4
    faces = shape.cells if quads else boundary_quads(shape.cells)
    constraints = classify(shape.V, faces, shape.surface, shape.features, solid=not quads).constraints
    normals = (lambda x, cells: quad_normals(x, shape.cells[cells])) if quads else None
    improver = Improver(
        shape.V, shape.cells, QUADS if quads else HEXES, constraints, normals, ImproveOptions()
    )
    x = some_moved(shape.V, share)
    again, fresh = improver.state(x, improver.first), improver.state(x)
    np.testing.assert_array_equal(again.quality, fresh.quality)
    assert (again.outside is None) == (fresh.outside is None) == (not quads)
    if fresh.outside is not None:
        np.testing.assert_array_equal(again.outside, fresh.outside)


@pytest.mark.parametrize("share", [0.01, 0.3, 1.0])
def test_distances_of_faces_that_moved(share: float) -> None:
    shape = torus_quads(20, 8)
    probe = DistanceProbe(shape.cells, shape.surface, 500, np.random.default_rng(0))
    before = probe.measure(shape.V)
    x = some_moved(shape.V, share)
    again, fresh = probe.measure(x, before), probe.measure(x)
    np.testing.assert_array_equal(again.there, fresh.there)
    np.testing.assert_allclose(again.back, fresh.back, rtol=1e-12)
    for sample in range(
        0, len(probe.points), 50
    ):  # the face that is blamed is at the distance it is blamed for
        face = SimplexTree(x, triangulated(shape.cells[again.nearest[sample : sample + 1]]))
        distance = face.distances(probe.points[sample : sample + 1])
        assert again.back[sample] == pytest.approx(distance[0], rel=1e-9, abs=1e-12)
    assert again.by_face.max() == pytest.approx(fresh.by_face.max(), rel=1e-12)
    assert probe.measure(shape.V.copy(), before) is before


def test_some_vertices_go_where_all_of_them_would() -> None:
    shape = cube_quads(6)
    constraints = classify(shape.V, shape.cells, shape.surface, shape.features, solid=False).constraints
    x = jitter(shape.V, 0.03, seed=3)
    chosen = np.flatnonzero(np.random.default_rng(4).random(len(x)) < 0.3)
    result, whole = constraints.project_some(x, chosen), constraints.project(x).points
    np.testing.assert_array_equal(result[chosen], whole[chosen])
    others = np.setdiff1d(np.arange(len(x)), chosen)
    np.testing.assert_array_equal(result[others], x[others])

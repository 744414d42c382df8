"""The stage on closed-form fields given as coefficients, with axes named anew at each point."""

from __future__ import annotations

import numpy as np
import pytest
from field_shapes import cylinder_tets, four_line_frames

from neurframe_cli.errors import StageError
from neurframe_cli.field.frames import frame_to_band4
from neurframe_cli.mesh.arrays import Features, Floats, Surface, TetMesh
from neurframe_cli.mesh.features import features_by_angle
from neurframe_cli.mesh.tet_adjacency import tet_adjacency
from neurframe_cli.stages.discretize import DiscretizeOptions, discretize, sample_frames


def four_lines(points: Floats) -> Floats:
    return frame_to_band4(four_line_frames(points))


@pytest.fixture(scope="module")
def cylinder() -> tuple[TetMesh, Surface, Features]:
    V, T = cylinder_tets(14, 6)
    F = tet_adjacency(T).boundary_faces
    return TetMesh(V, T), Surface(V, F), features_by_angle(V, F, 60)


def test_a_known_field_comes_back_with_its_lines_and_its_alignment(cylinder):
    tets, surface, features = cylinder
    found = discretize(four_lines, tets, surface, features)
    assert found.tets.distance.max() < 1e-11
    assert found.tets.converged.all()
    assert (found.singular.quarters == 1).all()
    assert found.singular.total_length == pytest.approx(4 * 2 / found.singular.diagonal, rel=0.5)
    assert found.normals.max_deg < 360 / 56 * 2  # the facets of 56 sides
    assert found.features.count > 0
    assert found.features.max_deg < 15
    summary = found.summary()
    assert summary["valence_3_edges"] == summary["singular_edges"] == len(found.singular.edges)
    assert summary["unconverged_projections"] == 0


def test_crosses_on_the_cylinder_run_up_and_round(cylinder):
    tets, surface, features = cylinder
    crosses = discretize(four_lines, tets, surface, features).crosses
    centroids = surface.V[surface.F].mean(axis=1)
    side = np.abs(centroids[:, 2]) < 0.999
    along_z = np.abs(crosses[side][:, :, 2])
    assert np.sort(along_z, axis=1) == pytest.approx(np.tile([0.0, 1.0], (side.sum(), 1)), abs=1e-9)


def test_batches_do_not_change_the_result_and_progress_never_falls(cylinder):
    tets, surface, features = cylinder
    seen: list[float] = []
    small = discretize(
        four_lines, tets, surface, features, DiscretizeOptions(batch=997), lambda x, _: seen.append(x)
    )
    whole = discretize(four_lines, tets, surface, features)
    assert np.array_equal(small.tets.frames, whole.tets.frames)
    assert np.array_equal(small.crosses, whole.crosses)
    assert seen == sorted(seen)
    assert seen[-1] == 1.0


def test_a_field_that_is_not_finite_is_a_stage_error_with_the_place(cylinder):
    tets, surface, features = cylinder

    def broken(points: Floats) -> Floats:
        q = four_lines(points)
        q[3] = np.nan
        return q

    with pytest.raises(StageError, match="not finite at 1 of") as error:
        discretize(broken, tets, surface, features)
    assert "train" in str(error.value.hint)


def test_any_points_can_be_sampled():
    points = np.random.default_rng(0).uniform(-0.5, 0.5, (1000, 3))
    sampled = sample_frames(four_lines, points, DiscretizeOptions(batch=300))
    assert sampled.coefficients == pytest.approx(four_lines(points))
    assert frame_to_band4(sampled.frames) == pytest.approx(four_lines(points), abs=1e-10)
    assert sample_frames(four_lines, points[:0]).frames.shape == (0, 3, 3)

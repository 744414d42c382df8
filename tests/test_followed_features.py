"""Which features elements of a size can follow."""

from __future__ import annotations

import numpy as np
import trimesh

from neurframe_cli.mesh.arrays import Features, as_surface
from neurframe_cli.mesh.features import features_by_angle
from neurframe_cli.mesh.followed_features import followed_features, surface_tips


def test_the_tip_of_a_cone_is_found_and_that_of_a_large_ball_is_not() -> None:
    cone = trimesh.creation.cone(0.5, 1.2, sections=32)
    surface = as_surface(cone.vertices, cone.faces)
    (tip,) = surface_tips(surface, 0.1)
    np.testing.assert_allclose(surface.V[tip], [0.0, 0.0, 1.2], atol=1e-9)
    ball = trimesh.creation.icosphere(3)
    assert len(surface_tips(as_surface(ball.vertices, ball.faces), 0.3)) == 0
    # a small ball is nothing but a tip for large elements
    assert len(surface_tips(as_surface(0.1 * ball.vertices, ball.faces), 0.3)) == 1


def test_short_curves_are_left_out_and_tips_are_corners() -> None:
    box = trimesh.creation.box(extents=(1.0, 1.0, 0.1))
    surface = as_surface(box.vertices, box.faces)
    features = features_by_angle(surface.V, surface.F, 45.0)
    assert len(features.chains) == 12
    kept = followed_features(surface, features, 0.2)
    assert len(kept.chains) == 8  # all but the four across the plate
    np.testing.assert_array_equal(kept.corners, features.corners)
    assert len(followed_features(surface, features, 0.05).chains) == 12
    cone = trimesh.creation.cone(0.5, 1.2, sections=32)
    surface = as_surface(cone.vertices, cone.faces)
    assert len(followed_features(surface, Features(), 0.1).corners) == 1

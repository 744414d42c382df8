"""The surface-only cross field: unit, tangent, aligned, and with the singularities that topology asks for."""

import numpy as np
import pytest

from neurframe_cli.field.surface_cross_field import surface_cross_field
from neurframe_cli.mesh.arrays import Floats, Ints


def torus(columns: int = 24, rows: int = 12) -> tuple[Floats, Ints]:
    i, j = (x.ravel() for x in np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij"))
    s, t = 2 * np.pi * i / columns, 2 * np.pi * j / rows
    V = np.stack([(2 + np.cos(t)) * np.cos(s), (2 + np.cos(t)) * np.sin(s), np.sin(t)], axis=1)
    a, b = i * rows + j, (i + 1) % columns * rows + j
    c, d = (i + 1) % columns * rows + (j + 1) % rows, i * rows + (j + 1) % rows
    return V, np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])


def flat_patch(n: int = 6) -> tuple[Floats, Ints]:
    i, j = (x.ravel() for x in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
    grid = (
        np.stack(np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij"), axis=-1).reshape(-1, 2) / n
    )
    a, b = i * (n + 1) + j, (i + 1) * (n + 1) + j
    V = np.column_stack([grid, np.zeros(len(grid))])
    return V, np.concatenate([np.stack([a, b, b + 1], axis=1), np.stack([a, b + 1, a + 1], axis=1)])


def no_features() -> Ints:
    return np.zeros((0, 2), dtype=np.int64)


def test_crosses_are_orthonormal_and_tangent() -> None:
    V, F = torus()
    crosses = surface_cross_field(V, F, no_features())
    normal = np.cross(V[F[:, 1]] - V[F[:, 0]], V[F[:, 2]] - V[F[:, 0]])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    gram = np.einsum("mij,mkj->mik", crosses, crosses)
    assert np.allclose(gram, np.eye(2), atol=1e-12)
    assert np.allclose(np.einsum("mij,mj->mi", crosses, normal), 0.0, atol=1e-12)
    assert np.allclose(np.cross(crosses[:, 0], crosses[:, 1]), normal, atol=1e-12)


def test_boundary_aligns_a_flat_patch_everywhere() -> None:
    V, F = flat_patch()
    crosses = surface_cross_field(V, F, no_features())
    assert np.allclose(np.abs(crosses).max(axis=2), 1.0, atol=1e-9)


def test_inner_feature_is_followed() -> None:
    V, F = torus()
    feature = F[:1, :2].astype(np.int64)
    crosses = surface_cross_field(V, F, feature)
    along = V[feature[0, 1]] - V[feature[0, 0]]
    along /= np.linalg.norm(along)
    beside = np.isin(F, feature[0]).sum(axis=1) == 2
    cosine = np.abs(crosses[beside] @ along)
    assert beside.sum() == 2
    assert np.allclose(cosine.max(axis=1), 1.0, atol=1e-9)


def test_motion_moves_the_crosses_along() -> None:
    V, F = flat_patch()
    V = V + 0.2 * np.sin(3 * V[:, [1, 2, 0]])
    rotation = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    rotation *= np.sign(np.linalg.det(rotation))
    at_rest = surface_cross_field(V, F, no_features())
    turned = surface_cross_field(V @ rotation.T + 5.0, F, no_features())
    assert np.allclose(turned, at_rest @ rotation.T, atol=1e-6)


def test_triangle_without_area_is_named() -> None:
    V, F = flat_patch()
    V[F[7, 1]] = V[F[7, 0]]
    with pytest.raises(ValueError, match="has no area"):
        surface_cross_field(V, F, no_features())

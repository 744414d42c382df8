"""Quality measures against meshes whose numbers are known in closed form."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from neurframe_cli.mesh.arrays import Features, Floats, Ints, Surface
from neurframe_cli.mesh.quality.check import CheckOptions, check_hexes, check_quads
from neurframe_cli.mesh.quality.feature_recall import feature_recall
from neurframe_cli.mesh.quality.polygons import euler_characteristic, triangulated, unique_edges
from neurframe_cli.mesh.quality.scaled_jacobian import hex_scaled_jacobians, quad_scaled_jacobians

Spoil = Callable[[Floats, Ints], tuple[Floats, Ints]]


def hex_grid(n: int) -> tuple[Floats, Ints]:
    """The unit cube as n^3 hexes in VTK order."""
    axis = np.linspace(0, 1, n + 1)
    V = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)
    i, j, k = (a.ravel() for a in np.meshgrid(*3 * [np.arange(n)], indexing="ij"))
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    H = np.stack([((i + a) * (n + 1) + j + b) * (n + 1) + k + c for a, b, c in corners], axis=1)
    return V, H.astype(np.int64)


def cube_shell(n: int) -> tuple[Floats, Ints]:
    """The boundary of the unit cube as 6 n^2 outward quads."""
    V, H = hex_grid(n)
    faces = H[
        :, [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
    ].reshape(-1, 4)
    _, first, use = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    return V, faces[first[use == 1]]


CUBE_EDGES = np.array(
    [[0, 1], [0, 2], [0, 4], [1, 3], [1, 5], [2, 3], [2, 6], [3, 7], [4, 5], [4, 6], [5, 7], [6, 7]]
)


@pytest.fixture
def cube() -> tuple[Surface, Features]:
    V, Q = cube_shell(1)
    return Surface(V, triangulated(Q)), Features(CUBE_EDGES)


def test_regular_grid_is_perfect(cube: tuple[Surface, Features]) -> None:
    verdict = check_hexes(*hex_grid(4), *cube, CheckOptions())
    assert verdict.valid
    numbers = verdict.numbers
    assert numbers["min_scaled_jacobian"] == pytest.approx(1, abs=1e-12)
    assert numbers["volume_ratio"] == pytest.approx(1, abs=1e-12)
    assert numbers["interior_singular_edges"] == 0
    assert numbers["hausdorff"] < 1e-12
    assert numbers["feature_recall"] == 1.0


def test_quad_shell_of_the_cube_has_eight_irregular_vertices(cube: tuple[Surface, Features]) -> None:
    verdict = check_quads(*cube_shell(5), *cube, CheckOptions())
    assert verdict.valid
    assert verdict.numbers["irregular_vertices"] == 8
    assert verdict.numbers["euler_characteristic"] == 2
    assert verdict.numbers["median_edge"] == pytest.approx(0.2 / np.sqrt(3))


@pytest.mark.parametrize("shear", [0.0, 0.5, 2.0])
def test_sheared_cells_have_the_sine_of_their_angle(shear: float) -> None:
    V, H = hex_grid(2)
    sheared = V @ np.array([[1, 0, 0], [shear, 1, 0], [0, 0, 1]])
    expected = 1 / np.hypot(1, shear)
    assert hex_scaled_jacobians(sheared, H) == pytest.approx(expected)
    square = np.array([[0, 0, 0], [1, 0, 0], [1 + shear, 1, 0], [shear, 1, 0]], float)
    assert quad_scaled_jacobians(square, np.arange(4)[None]) == pytest.approx(expected)


def test_mirrored_hex_and_folded_quad_are_inverted() -> None:
    V, H = hex_grid(1)
    assert hex_scaled_jacobians(V * [1, 1, -1], H).max() == pytest.approx(-1)
    arrow = np.array([[0, 0, 0], [1, 0, 0], [0.1, 0.1, 0], [0, 1, 0]])
    assert (quad_scaled_jacobians(arrow, np.arange(4)[None]) < 0).sum() == 1


@pytest.mark.parametrize(
    ("spoil", "problem"),
    [
        (lambda V, H: (V, H[1:]), "Hausdorff"),
        (lambda V, H: (V, np.concatenate([H, H[:1]])), "faces in more than two cells"),
        (lambda V, H: (V, np.concatenate([H[:-1], H[-1:, [0, 1, 2, 2, 4, 5, 6, 6]]])), "repeat a corner"),
        (lambda V, H: (V * [1, 1, -1], H), "corner Jacobian <= 0"),
        (lambda V, H: (np.concatenate([V, V + 3]), np.concatenate([H, H + len(V)])), "components"),
    ],
)
def test_each_defect_of_a_hex_mesh_is_named(
    cube: tuple[Surface, Features], spoil: Spoil, problem: str
) -> None:
    verdict = check_hexes(*spoil(*hex_grid(3)), *cube, CheckOptions())
    assert any(problem in found for found in verdict.problems)


def test_hole_and_doubled_quads_are_named(cube: tuple[Surface, Features]) -> None:
    V, Q = cube_shell(3)
    assert "4 open edges" in " ".join(check_quads(V, Q[1:], *cube, CheckOptions()).problems)
    doubled = np.concatenate([Q, Q[:1]])
    assert "4 edges in more than two quads" in " ".join(
        check_quads(V, doubled, *cube, CheckOptions()).problems
    )


def test_recall_counts_the_share_of_the_length(cube: tuple[Surface, Features]) -> None:
    surface, features = cube
    edges = features.edges[:3]
    assert feature_recall(surface.V, features.edges, surface.V, edges, 1e-3) == pytest.approx(
        3 / 12, abs=1e-2
    )
    assert feature_recall(surface.V, np.zeros((0, 2), np.int64), surface.V, edges, 1e-3) is None


def test_euler_characteristic_of_a_torus() -> None:
    n = 6
    i, j = (a.ravel() for a in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
    at = lambda a, b: (a % n) * n + b % n  # noqa: E731 - the formula of the grid, used once a corner
    Q = np.stack([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)], axis=1)
    assert euler_characteristic(Q) == 0
    edges, use = unique_edges(Q)
    assert len(edges) == 2 * n * n
    assert (use == 2).all()

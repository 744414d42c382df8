"""The loss: the quadratic form against a literal transcription of the paper, with 9x9 rotations and autograd."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from train_shapes import box_features, box_mesh, rotation, tilted_box

from neurframe_cli.errors import InvalidMesh
from neurframe_cli.field.block_jacobi import apply_blocks, block_jacobi
from neurframe_cli.field.coarsening import coarsen
from neurframe_cli.field.discrete_solver import solve_discrete
from neurframe_cli.field.energy import field_energy
from neurframe_cli.field.energy_terms import LossWeights, energy_terms, normalization_of
from neurframe_cli.field.frame_diffusion import diffuse_and_project
from neurframe_cli.field.frames import frame_to_band4, nearest_frames
from neurframe_cli.field.nearest_feature_edge import nearest_feature_edge
from neurframe_cli.field.objectives import sample_terms
from neurframe_cli.field.relaxed_solver import solve_relaxed
from neurframe_cli.field.sphere_lbfgs import unit_rows
from neurframe_cli.field.spherical_harmonics import rotation_band4
from neurframe_cli.mesh.arrays import Features, Floats, as_tets
from neurframe_cli.mesh.tet_adjacency import tet_adjacency


def rotation_to_z(d: Floats) -> Floats:
    """Some rotation (3,3) that takes the unit vector d to the z axis."""
    helper = np.eye(3)[np.argmin(np.abs(d))]
    x = np.cross(helper, d) / np.linalg.norm(np.cross(helper, d))
    return np.stack([x, np.cross(d, x), d])


def literal_loss(tets, edges, q: torch.Tensor, weights: LossWeights) -> torch.Tensor:
    """Equations 3 to 6 term by term in float64, in loops, with the rotation matrices of the paper."""
    low, high = tets.V.min(axis=0), tets.V.max(axis=0)
    V = (tets.V - (low + high) / 2) * 2 / (high - low).max()
    P, adjacency = V[tets.T].mean(axis=1), tet_adjacency(tets.T)
    aligned, smooth, boundary, feature = np.sqrt(7 / 12), 0.0, 0.0, 0.0
    for a, b in adjacency.dual_edges:
        smooth = smooth + ((q[a] - q[b]) ** 2).sum() / (np.linalg.norm(P[a] - P[b]) + weights.tau)
    for face, tet in zip(adjacency.boundary_faces, adjacency.boundary_tets, strict=True):
        n = np.cross(V[face[1]] - V[face[0]], V[face[2]] - V[face[0]])
        boundary = boundary + (aligned - rotated_middle(n, q[tet])) ** 2
    for p, coefficients in zip(P, q, strict=True):
        distance, direction = min((segment_distance(p, V[e]), tuple(V[e[1]] - V[e[0]])) for e in edges)
        residual = aligned - rotated_middle(np.array(direction), coefficients)
        feature = feature + np.exp(-weights.sigma * distance) * residual**2
    return (
        weights.smooth * smooth / len(adjacency.dual_edges)
        + weights.boundary * boundary / len(adjacency.boundary_faces)
        + weights.feature * feature / len(P)
    )


def rotated_middle(d: Floats, q: torch.Tensor) -> torch.Tensor:
    """e0' R(d->z) q."""
    R = torch.from_numpy(rotation_band4(rotation_to_z(d / np.linalg.norm(d))))
    return (R @ q)[4]


def segment_distance(p: Floats, ends: Floats) -> float:
    along = ends[1] - ends[0]
    t = np.clip((p - ends[0]) @ along / (along @ along), 0, 1)
    return float(np.linalg.norm(p - ends[0] - t * along))


def random_rows(m: int) -> Floats:
    return np.random.default_rng(3).normal(size=(m, 9))


def test_value_and_gradient_are_those_of_the_paper_by_autograd():
    tets = tilted_box(2)
    # one edge only, so that no tet has two nearest edges
    edges, weights = box_features(tets).edges[:1], LossWeights(0.7, 13.0, 2.0, 4.0)
    q = torch.from_numpy(random_rows(len(tets.T))).requires_grad_(True)
    expected = literal_loss(tets, edges, q, weights)
    (gradient,) = torch.autograd.grad(expected, q)
    expected = expected.detach()
    terms = energy_terms(tets, Features(edges), weights)
    energy, free = field_energy(terms), q.detach()
    assert terms.losses(free.numpy()).total == pytest.approx(float(expected), rel=1e-12)
    assert energy.value(free) == pytest.approx(float(expected), rel=1e-12)
    torch.testing.assert_close(2 * energy.half_gradient(free), gradient, rtol=1e-10, atol=1e-13)


def test_float32_energy_differs_by_rounding_only():
    terms = energy_terms(tilted_box(3), box_features(tilted_box(3)), LossWeights())
    q = random_rows(len(terms.points))
    value = field_energy(terms, dtype=torch.float32).value(torch.from_numpy(q).float())
    assert value == pytest.approx(terms.losses(q).total, rel=1e-5)


def test_the_loss_does_not_see_scale_position_or_rotation_of_the_model():
    tets, R = box_mesh(3), rotation()
    # one edge only: which of two equally near edges is taken depends on rounding
    features = Features(box_features(tets).edges[:1])
    # a rotation changes the bounding box, hence the normalisation: give the rotated model the scale of the first
    moved = as_tets(7.0 * tets.V + [1.0, -2.0, 3.0], tets.T)
    q = random_rows(len(tets.T))
    first, second = (energy_terms(t, features, LossWeights()).losses(q) for t in (tets, moved))
    assert second.total == pytest.approx(first.total, rel=1e-12)
    turned = energy_terms(
        as_tets(tets.V @ R.T, tets.T), features, LossWeights(), None, normalization_of(tets.V)
    )
    assert turned.losses(q @ rotation_band4(R).T).total == pytest.approx(first.total, rel=1e-10)


def test_the_constant_field_of_a_tilted_box_costs_nothing():
    tets = tilted_box(3)
    q = np.tile(frame_to_band4(rotation()), (len(tets.T), 1))
    assert energy_terms(tets, box_features(tets), LossWeights()).losses(q).total < 1e-25


@pytest.mark.parametrize("cells", [3, 8])  # one level and two levels
def test_the_discrete_solver_finds_the_field_of_a_tilted_box(cells):
    tets = tilted_box(cells)
    solution = solve_discrete(energy_terms(tets, box_features(tets), LossWeights()))
    assert solution.value < 1e-10
    assert np.abs(solution.q - frame_to_band4(rotation())).max() < 1e-4


def test_the_discrete_solver_reaches_a_stationary_point_and_repeats_itself():
    tets = box_mesh(6, bend=0.9)
    terms = energy_terms(tets, Features(), LossWeights())
    first, second = solve_discrete(terms), solve_discrete(terms)
    assert first.q.tobytes() == second.q.tobytes()
    assert np.abs(np.linalg.norm(first.q, axis=1) - 1).max() < 1e-12
    # no small move of the whole field does better by more than the solver's tolerance
    noise = unit_rows(torch.from_numpy(first.q + 1e-3 * random_rows(len(first.q)))).numpy()
    assert terms.losses(noise).total > first.value * (1 - 2e-4)


def test_the_relaxed_solution_solves_its_linear_system():
    terms = energy_terms(box_mesh(4, bend=0.9), Features(), LossWeights())
    energy = field_energy(terms)
    x = solve_relaxed(energy, tolerance=1e-10)
    assert float((energy.product(x) - energy.target).norm()) < 1e-8 * float(energy.target.norm())


def test_block_jacobi_inverts_the_diagonal_blocks():
    terms = energy_terms(box_mesh(2, bend=0.5), box_features(box_mesh(2)), LossWeights())
    energy, blocks = field_energy(terms), block_jacobi(field_energy(terms))
    for tet in (0, 7, 20):
        unit = torch.zeros(len(terms.points), 9, dtype=torch.float64)
        block = torch.empty(9, 9, dtype=torch.float64)
        for c in range(9):
            unit[tet] = torch.eye(9, dtype=torch.float64)[c]
            block[:, c] = energy.product(unit)[tet]
        torch.testing.assert_close(blocks[tet] @ block, torch.eye(9, dtype=torch.float64), rtol=0, atol=1e-6)
        unit[tet] = block[:, 3]
        torch.testing.assert_close(
            apply_blocks(blocks, unit)[tet], torch.eye(9).double()[3], rtol=0, atol=1e-6
        )


def test_coarsening_keeps_constant_fields_and_the_alignment():
    terms = energy_terms(tilted_box(8), box_features(tilted_box(8)), LossWeights())
    coarse, cluster = coarsen(terms)
    assert len(coarse.points) < len(terms.points) / 5
    q = np.tile(random_rows(1), (len(coarse.points), 1))
    fine, joined = terms.losses(q[cluster]), coarse.losses(q)
    assert joined.smooth == fine.smooth == 0.0
    assert joined.boundary == pytest.approx(fine.boundary)
    assert joined.feature == pytest.approx(fine.feature)


def test_sampled_terms_have_the_loss_as_their_mean():
    terms = energy_terms(box_mesh(3, bend=0.5), box_features(box_mesh(3)), LossWeights())
    q, generator = random_rows(len(terms.points)), np.random.default_rng(0)
    where = {p.tobytes(): i for i, p in enumerate(terms.points)}
    values = []
    for _ in range(300):
        part = sample_terms(terms, 0.25, generator)
        values.append(part.losses(q[[where[p.tobytes()] for p in part.points]]).total)
    # 300 draws of relative spread about 0.1 leave 0.6 % of standard error
    assert np.mean(values) == pytest.approx(terms.losses(q).total, rel=0.03)


def test_nearest_feature_edges_agree_with_brute_force():
    generator = np.random.default_rng(1)
    V, P = generator.normal(size=(30, 3)), generator.normal(size=(200, 3))
    edges = generator.permutation(30).reshape(-1, 2)
    distances, directions = nearest_feature_edge(P, V, edges)
    brute = np.array([[segment_distance(p, V[e]) for e in edges] for p in P])
    np.testing.assert_allclose(distances, brute.min(axis=1), rtol=1e-13)
    along = (V[edges[:, 1]] - V[edges[:, 0]])[brute.argmin(axis=1)]
    np.testing.assert_allclose(directions, along / np.linalg.norm(along, axis=1, keepdims=True), rtol=1e-13)


def test_a_mesh_without_extent_is_refused():
    with pytest.raises(InvalidMesh, match="extent 0"):
        normalization_of(np.zeros((4, 3)))


def test_projection_gives_true_frames_and_keeps_the_constant_field_of_a_box():
    tets = tilted_box(3)
    terms = energy_terms(tets, box_features(tets), LossWeights())
    frame = frame_to_band4(rotation())
    noisy = np.tile(frame, (len(tets.T), 1)) + 0.1 * random_rows(len(tets.T))
    q = diffuse_and_project(terms, noisy, rounds=6)
    # the noise that went in is up to 0.4, what the last short steps of diffusion leave of it 0.02
    assert np.abs(q - frame).max() < 0.05


def test_projection_lowers_the_energy_of_the_frames():
    terms = energy_terms(box_mesh(4, bend=1.2), Features(), LossWeights())
    q = solve_discrete(terms).q
    before = frame_to_band4(nearest_frames(q).frames)
    after = diffuse_and_project(terms, q)
    assert terms.losses(after).total <= terms.losses(before).total
    assert nearest_frames(after).distance.max() < 1e-9

"""Gradients of the network's parameters, the choice of device and precision, and the recipes."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from train_shapes import box_features, box_mesh

from neurframe_cli.field import objectives
from neurframe_cli.field.device import bf16_error, choose_device
from neurframe_cli.field.energy_terms import LossWeights, energy_terms
from neurframe_cli.field.network import Architecture, FieldNetwork, evaluate
from neurframe_cli.field.objectives import Distillation, FullLoss
from neurframe_cli.field.recipe import FastRecipe, PaperRecipe, distillation_round
from neurframe_cli.field.spherical_harmonics import ALIGNED

MESH = box_mesh(3, bend=0.9)
TERMS = energy_terms(MESH, box_features(box_mesh(3)), LossWeights())


def small_network() -> FieldNetwork:
    return FieldNetwork(Architecture(width=16, hidden=2), torch.Generator().manual_seed(0))


def loss_by_autograd(q: torch.Tensor) -> torch.Tensor:
    """The three losses written with torch operations on every term."""
    first, second = torch.from_numpy(TERMS.dual_edges).T
    loss = (torch.from_numpy(TERMS.smooth_weights).float() * ((q[first] - q[second]) ** 2).sum(dim=1)).sum()
    for term, factor in ((TERMS.boundary, 20.0), (TERMS.feature, 1.0)):
        along = (torch.from_numpy(term.vectors).float() * q[torch.from_numpy(term.tets)]).sum(dim=1)
        loss = loss + factor * (torch.from_numpy(term.weights).float() * (ALIGNED - along) ** 2).sum()
    return loss


@pytest.mark.parametrize("kept", [10**6, 0])  # activations kept for the backward pass, or computed again
def test_gradients_in_chunks_are_those_of_autograd(kept, monkeypatch):
    monkeypatch.setattr(objectives, "KEPT_POINTS", kept)
    monkeypatch.setitem(objectives.CHUNK, "cpu", 50)
    network, reference = small_network(), small_network()
    value = FullLoss(TERMS, "cpu").backpropagate(network, 0)
    expected = loss_by_autograd(reference(torch.from_numpy(TERMS.points).float()))
    expected.backward()
    assert value == pytest.approx(float(expected.detach()), rel=1e-5)
    for ours, theirs in zip(network.parameters(), reference.parameters(), strict=True):
        scale = float(theirs.grad.abs().max())
        torch.testing.assert_close(ours.grad, theirs.grad, rtol=1e-4, atol=1e-4 * scale)


def test_an_epoch_of_batches_visits_every_tet_once():
    target = np.random.default_rng(0).normal(size=(len(TERMS.points), 9))
    distillation = Distillation(TERMS.points, target, 36, [0, 1], "cpu")
    assert len(TERMS.points) % 36 == 0
    steps = range(len(TERMS.points) // 36)
    first, second = (
        torch.cat([distillation._chosen(epoch * len(steps) + step) for step in steps]) for epoch in (0, 1)
    )
    assert sorted(first.tolist()) == sorted(second.tolist()) == list(range(len(TERMS.points)))
    assert first.tolist() != second.tolist()


def test_a_batch_in_chunks_has_the_gradient_of_the_whole(monkeypatch):
    target = np.random.default_rng(0).normal(size=(len(TERMS.points), 9))
    distillation = Distillation(TERMS.points, target, 36, [0, 1], "cpu")
    network, chunked = small_network(), small_network()
    value = distillation.backpropagate(network, 0)
    monkeypatch.setitem(objectives.CHUNK, "cpu", 7)
    assert distillation.backpropagate(chunked, 0) == pytest.approx(value, rel=1e-6)
    for ours, theirs in zip(chunked.parameters(), network.parameters(), strict=True):
        torch.testing.assert_close(ours.grad, theirs.grad, rtol=1e-4, atol=1e-6)


def test_precision_is_float32_when_asked_and_bfloat16_rounds_its_operands():
    assert choose_device("cpu", "fp32").hidden_dtype == torch.float32
    assert choose_device("cpu", "bf16").hidden_dtype == torch.bfloat16
    # eight bits of mantissa: far from float32's 1e-6, far from a wrong product's 1
    assert 1e-4 < bf16_error("cpu") < 1e-2


def test_a_network_in_bfloat16_is_the_same_up_to_rounding_and_evaluated_in_float32():
    network = FieldNetwork(Architecture(), torch.Generator().manual_seed(0))
    points = torch.from_numpy(TERMS.points).float()
    exact = evaluate(network, points)
    network.hidden_dtype = torch.bfloat16
    rounded = network(points).detach()
    # measured rms 0.007
    assert 1e-4 < float((rounded - exact).norm(dim=1).mean()) < 0.05
    assert torch.equal(evaluate(network, points), exact)


def test_the_recipes_follow_what_was_reached():
    paper = PaperRecipe().next_round([])
    assert (paper.optimizer, paper.steps, paper.peak, paper.cosine) == ("adam", 10_000, 5e-5, False)
    assert PaperRecipe().next_round([1.0]) is None
    fast = FastRecipe(floor=1.0, constant=12.0, distill=distillation_round(8000, None, None, None))
    assert fast.next_round([]).objective == "distill"
    assert fast.next_round([1.001]) is None
    assert [fast.next_round([1.1] * n).steps for n in (1, 2, 3)] == [15, 30, 60]
    assert fast.next_round([1.1] * 4) is None
    box = FastRecipe(floor=1e-13, constant=12.0, distill=distillation_round(8000, None, None, None))
    assert box.next_round([1e-5]) is None
    assert box.next_round([1e-2]).objective == "loss"

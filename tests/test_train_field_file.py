"""The network, its file, and the fields that are read back from it."""

from __future__ import annotations

import json

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from safetensors.torch import load, save

from neurframe_cli.errors import InputError, TooNewFile, UnreadableFile
from neurframe_cli.field.checkpoint import TrainingState, checkpoint_from_bytes, state_to_bytes
from neurframe_cli.field.energy_terms import Normalization
from neurframe_cli.field.field_file import (
    NeuralField,
    SampledField,
    field_from_bytes,
    field_to_bytes,
    read_field,
)
from neurframe_cli.field.network import Architecture, FieldNetwork
from neurframe_cli.field.optimizers import Adam, MuonAndAdam, Schedule, orthogonalized

NORMALIZATION = Normalization(np.array([1.0, 2.0, 3.0]), 0.5)


def small_network(seed: int = 0) -> FieldNetwork:
    return FieldNetwork(Architecture(width=16, hidden=2), torch.Generator().manual_seed(seed))


def points(n: int) -> np.ndarray:
    return np.random.default_rng(0).uniform(-1, 1, (n, 3))


def test_the_network_of_the_paper_has_266505_parameters_and_unit_outputs():
    network = FieldNetwork(Architecture(), torch.Generator().manual_seed(0))
    assert sum(p.numel() for p in network.parameters()) == 266_505
    lengths = network(torch.from_numpy(points(50)).float()).norm(dim=1)
    assert torch.allclose(lengths, torch.ones(50), atol=1e-6)


def test_the_forward_pass_is_a_siren():
    network, p = small_network(), points(20)
    weights = {n: t.double().numpy() for n, t in network.state_dict().items()}
    x = np.sin(30 * (p @ weights["first.weight"].T + weights["first.bias"]))
    for i in range(2):
        x = np.sin(30 * (x @ weights[f"hidden.{i}.weight"].T + weights[f"hidden.{i}.bias"]))
    x = x @ weights["last.weight"].T + weights["last.bias"]
    expected = x / np.linalg.norm(x, axis=1, keepdims=True)
    got = NeuralField(network, Normalization(np.zeros(3), 1.0)).query(p)
    # float32 through two sines of slope 30
    np.testing.assert_allclose(got, expected, atol=2e-5)


def test_query_is_in_input_coordinates_in_float64_and_takes_no_points():
    field, p = NeuralField(small_network(), NORMALIZATION), points(30)
    q = field.query(p / 0.5 + [1.0, 2.0, 3.0])
    same = NeuralField(field.network, Normalization(np.zeros(3), 1.0)).query(p)
    np.testing.assert_allclose(q, same, atol=1e-5)
    assert q.dtype == np.float64
    np.testing.assert_allclose(np.linalg.norm(q, axis=1), 1.0, rtol=1e-14)
    assert field.query(np.zeros((0, 3))).shape == (0, 9)


def test_a_neural_field_survives_its_file(tmp_path):
    field, p = NeuralField(small_network(), NORMALIZATION), points(30)
    (tmp_path / "field.safetensors").write_bytes(field_to_bytes(field, {"loss": 0.25}))
    assert read_field(tmp_path / "field.safetensors").query(p).tobytes() == field.query(p).tobytes()


def test_a_sampled_field_survives_its_file_and_is_exact_at_its_samples():
    p, q = points(100), np.random.default_rng(1).normal(size=(100, 9))
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    field = SampledField(p, q, NORMALIZATION)
    back = field_from_bytes(field_to_bytes(field))
    at = p / NORMALIZATION.scale + NORMALIZATION.center
    np.testing.assert_allclose(back.query(at), q, atol=1e-9)
    assert back.query(at + 0.05).tobytes() == field.query(at + 0.05).tobytes()


def with_document(content: bytes, **changes: object) -> bytes:
    length = int.from_bytes(content[:8], "little")
    document = json.loads(json.loads(content[8 : 8 + length])["__metadata__"]["neurframe"])
    return bytes(save(load(content), {"neurframe": json.dumps(document | changes)}))


def test_a_later_version_is_refused():
    content = with_document(field_to_bytes(NeuralField(small_network(), NORMALIZATION)), version=2)
    with pytest.raises(TooNewFile, match=r"format version 2.*up to 1"):
        field_from_bytes(content)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"format": "other"}, "holds other"),
        ({"kind": "spline"}, "incomplete"),
        ({"architecture": {"width": 8, "hidden": 2}}, "incomplete"),
        ({"architecture": {"depth": 8}}, "incomplete"),
        ({"normalization": {"center": [0, 0, 0]}}, "incomplete"),
    ],
)
def test_a_file_that_does_not_fit_together_is_refused(changes, message):
    content = with_document(field_to_bytes(NeuralField(small_network(), NORMALIZATION)), **changes)
    with pytest.raises(UnreadableFile, match=message):
        field_from_bytes(content)


def test_a_missing_file_and_a_plain_safetensors_file_are_refused(tmp_path):
    with pytest.raises(UnreadableFile, match="no such file"):
        read_field(tmp_path / "field.safetensors")
    with pytest.raises(UnreadableFile, match="not written by neurframe"):
        field_from_bytes(save({"a": torch.zeros(2)}))


FIELD_BYTES = field_to_bytes(NeuralField(small_network(), NORMALIZATION))


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 1200), st.binary(min_size=1, max_size=8), st.integers(0, len(FIELD_BYTES)))
def test_damaged_files_are_refused_or_still_fields(position, patch, length):
    damaged = FIELD_BYTES[:position] + patch + FIELD_BYTES[position + len(patch) :]
    for content in (damaged, FIELD_BYTES[:length]):
        try:
            field = field_from_bytes(content)
        except InputError:
            continue
        assert isinstance(field, NeuralField)


def test_a_checkpoint_brings_back_network_optimizer_and_numbers():
    state = trained_state(3)
    found = checkpoint_from_bytes(state_to_bytes(state, "key"))
    other = TrainingState(small_network(9))
    found.restore_into(other)
    other.optimizer = MuonAndAdam(other.network)
    other.optimizer.restore(found.optimizer_state())
    assert state_to_bytes(other, "key") == state_to_bytes(state, "key")
    with pytest.raises(UnreadableFile):
        checkpoint_from_bytes(FIELD_BYTES)


def test_one_changed_bit_of_a_checkpoint_is_found():
    content = bytearray(state_to_bytes(trained_state(1), "key"))
    content[-1] ^= 1  # in the last weight
    with pytest.raises(UnreadableFile, match="damaged"):
        checkpoint_from_bytes(bytes(content))


def test_a_checkpoint_of_another_network_is_refused():
    found = checkpoint_from_bytes(state_to_bytes(trained_state(1), "key"))
    other = TrainingState(FieldNetwork(Architecture(width=4), torch.Generator().manual_seed(0)))
    with pytest.raises(UnreadableFile, match="does not fit the network"):
        found.restore_into(other)


def trained_state(steps: int) -> TrainingState:
    network = small_network()
    optimizer = MuonAndAdam(network)
    for _ in range(steps):
        network.zero_grad()
        network(torch.from_numpy(points(40)).float()).pow(4).sum().backward()
        optimizer.step(1e-3)
    return TrainingState(network, optimizer, points(5), 0.5, [1.0, 2.0], 17, 3.5, 2.5)


def test_adam_is_algorithm_1_of_its_paper():
    x = torch.nn.Parameter(torch.tensor([1.0, -2.0, 3.0]))
    adam, y, m, v = Adam([x]), x.detach().double().numpy(), np.zeros(3), np.zeros(3)
    for t in range(1, 6):
        gradient = 4 * y**3
        x.grad = 4 * x.detach() ** 3
        adam.step(0.01)
        m, v = 0.9 * m + 0.1 * gradient, 0.999 * v + 0.001 * gradient**2
        y = y - 0.01 * (m / (1 - 0.9**t)) / (np.sqrt(v / (1 - 0.999**t)) + 1e-8)
    np.testing.assert_allclose(x.detach().numpy(), y, rtol=1e-5)


def test_orthogonalized_keeps_singular_vectors_and_moves_singular_values_near_one():
    generator = torch.Generator().manual_seed(0)
    U, _ = torch.linalg.qr(torch.randn(32, 32, generator=generator))
    V, _ = torch.linalg.qr(torch.randn(32, 32, generator=generator))
    values = torch.linspace(0.05, 1.0, 32)
    inner = U.mT @ orthogonalized(U @ torch.diag(values) @ V.mT) @ V
    diagonal = torch.diagonal(inner)
    assert (inner - torch.diag(diagonal)).abs().max() < 1e-4
    assert 0.6 < float(diagonal.min()) <= float(diagonal.max()) < 1.3


def test_the_schedule_warms_up_and_falls_to_zero():
    schedule = Schedule(2.0, 100, warm_up=0.1, cosine=True)
    assert schedule.rate(0) == pytest.approx(0.2)
    assert schedule.rate(10) == pytest.approx(2.0)
    assert schedule.rate(55) == pytest.approx(1.0)
    assert schedule.rate(99) < 0.001
    assert Schedule(2.0, 100).rate(99) == 2.0

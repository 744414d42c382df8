"""The network as the field of an integer-grid map."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import torch
from field_shapes import box_tets, four_line_frames
from scipy.spatial.transform import Rotation
from test_hex_command import request, stored
from train_shapes import tilted_box

from neurframe_cli.cli.main import run_command_line
from neurframe_cli.errors import UnreadableFile, UsageError
from neurframe_cli.field.energy_terms import normalization_of
from neurframe_cli.field.field_file import NeuralField, SampledField, field_to_bytes, read_field
from neurframe_cli.field.map_frames import map_frames, map_matchings
from neurframe_cli.field.matching import best_matchings
from neurframe_cli.field.network import Architecture, FieldNetwork
from neurframe_cli.field.octahedral_group import GROUP
from neurframe_cli.mesh.arrays import Floats, silent
from neurframe_cli.mesh.read_hex_map import HexMap, read_hex_map
from neurframe_cli.mesh.tet_adjacency import tet_adjacency
from neurframe_cli.pipeline.hex_options import HexOptions
from neurframe_cli.pipeline.hex_step import hex_step
from neurframe_cli.pipeline.runner import run_stage
from neurframe_cli.pipeline.sizing import element_size
from neurframe_cli.pipeline.workspace import Workspace
from neurframe_cli.stages.distill_map import DistillOptions, distill_map

AXES = Rotation.from_euler("xyz", (0.3, -0.4, 0.2)).as_matrix()  # columns


def linear_map(charts: Floats | None = None) -> HexMap:
    """A box whose parameters are its coordinates along AXES, two cells a unit; charts (m,3,3): turned in each tet."""
    tets = tilted_box(3)
    parameters = 2.0 * tets.V[tets.T] @ AXES
    if charts is not None:
        parameters = np.einsum("mij,mcj->mci", charts, parameters) + 3.0
    return HexMap(tets.V, tets.T, parameters)


def small_field(hex_map: HexMap) -> NeuralField:
    network = FieldNetwork(Architecture(width=32, hidden=2), torch.Generator().manual_seed(1))
    return NeuralField(network, normalization_of(hex_map.V))


def text_of(hex_map: HexMap) -> str:
    rows = np.concatenate([hex_map.T, hex_map.parameters.reshape(len(hex_map.T), 12)], axis=1)
    vertices = [" ".join(map(repr, v)) for v in hex_map.V.tolist()]
    tets = [" ".join([*map(str, map(int, row[:4])), *map(repr, row[4:])]) for row in rows.tolist()]
    return "\n".join([str(len(vertices)), *vertices, str(len(tets)), *tets]) + "\n"


def test_frames_of_a_linear_map_are_its_axes() -> None:
    frames = map_frames(linear_map())
    np.testing.assert_allclose(frames, np.tile(AXES, (len(frames), 1, 1)), atol=1e-12)


def test_frames_of_a_sheared_map_are_the_nearest_rotation() -> None:
    box = linear_map()
    shear = np.array([[1.0, 0.4, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 2.0]])
    frames = map_frames(HexMap(box.V, box.T, box.parameters @ shear))
    J = shear.T @ AXES.T * 2.0
    left, _, right = np.linalg.svd(J)
    np.testing.assert_allclose(frames, np.tile((left @ right).T, (len(frames), 1, 1)), atol=1e-12)
    assert np.linalg.det(frames) == pytest.approx(1.0)


def test_matchings_are_those_of_the_charts() -> None:
    plain = linear_map()
    chosen = np.random.default_rng(3).integers(0, 24, len(plain.T))
    turned = linear_map(GROUP[chosen])
    adjacency = tet_adjacency(plain.T)
    frames, index = map_frames(turned), map_matchings(turned, adjacency)
    a, b = adjacency.dual_edges.T
    np.testing.assert_allclose(frames[a], frames[b] @ GROUP[index], atol=1e-9)
    np.testing.assert_array_equal(index, best_matchings(frames, adjacency).index)
    assert (index > 0).any()
    np.testing.assert_array_equal(map_matchings(plain, adjacency), 0)


def test_a_network_takes_over_the_field_of_a_map() -> None:
    hex_map = linear_map()
    field = small_field(hex_map)
    before = {name: tensor.clone() for name, tensor in field.network.state_dict().items()}
    made = distill_map(field, hex_map, DistillOptions(iterations=60))
    report = made.report
    assert report["before"]["mean_deg"] > 10.0
    assert report["after"]["mean_deg"] < 3.0
    assert report["after"]["same_matchings"] == 1.0
    assert report["steps"] == 60
    assert all(torch.equal(tensor, before[name]) for name, tensor in field.network.state_dict().items())
    again = distill_map(field, hex_map, DistillOptions(iterations=60))
    points = hex_map.V[hex_map.T].mean(axis=1)
    np.testing.assert_array_equal(made.field.query(points), again.field.query(points))


def test_a_field_without_a_network_is_refused() -> None:
    sampled = SampledField(np.zeros((1, 3)), np.ones((1, 9)), normalization_of(linear_map().V))
    with pytest.raises(UsageError, match="no network"):
        distill_map(sampled, linear_map())


def test_a_map_is_read_as_it_was_written(tmp_path: Path) -> None:
    hex_map = linear_map()
    path = tmp_path / "map.hexex"
    path.write_text(text_of(hex_map))
    found = read_hex_map(path)
    np.testing.assert_array_equal(found.V, hex_map.V)
    np.testing.assert_array_equal(found.T, hex_map.T)
    np.testing.assert_array_equal(found.parameters, hex_map.parameters)


def test_exact_fractions_are_read(tmp_path: Path) -> None:
    path = tmp_path / "map.hexex"
    path.write_text("4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1\n0 1 2 3 0 0 0 1/2 0 0 0 -3/4 0 0 0 1\n")
    np.testing.assert_array_equal(read_hex_map(path).parameters[0, 1:3], [[0.5, 0.0, 0.0], [0.0, -0.75, 0.0]])


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (("1\n0 1 2 3", "1\n0 1 2 4"), "a corner that is not one of 4"),
        (("1\n0 1 2 3", "2\n0 1 2 3"), "2 lines of 16 numbers expected"),
        (("4\n0 0 0", "four\n0 0 0"), "no map in the format of HexEx"),
        (("0 0 0 1\n", "0 0 0 inf\n"), "not finite"),
        (("0 0 0 1\n", "0 0 0 1/0\n"), "no map in the format of HexEx"),
        (("1\n0 1 2 3 0 0 0 1 0 0 0 1 0 0 0 1\n", "0\n"), "no tets"),
    ],
)
def test_damaged_maps_are_refused(tmp_path: Path, change: tuple[str, str], words: str) -> None:
    text = "4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1\n0 1 2 3 0 0 0 1 0 0 0 1 0 0 0 1\n"
    path = tmp_path / "map.hexex"
    path.write_text(text.replace(*change))
    with pytest.raises(UnreadableFile, match=words):
        read_hex_map(path)


def test_the_command_goes_from_a_map_with_singular_lines_to_its_field(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    V, T = box_tets((6, 6, 3))
    workspace: Workspace = stored(tmp_path / "box", V, T, four_line_frames(V[T].mean(axis=1)))
    size = element_size(None, 0.3 * float(np.ptp(V[:, 0])), None, 30.0)
    run_stage(workspace, hex_step(workspace, request(size, HexOptions(grid=False))), silent)
    assert run_command_line(["distill", "-w", str(workspace.folder)]) == 2
    assert "train" in capsys.readouterr().err
    hex_map = read_hex_map(workspace / "map.hexex")
    (workspace / "field.safetensors").write_bytes(field_to_bytes(small_field(hex_map)))
    words = ["distill", "-w", str(workspace.folder), "--iterations", "150", "--device", "cpu"]
    assert run_command_line(words) == 0
    manifest = json.loads((workspace / "manifest.json").read_text())
    report = manifest["stages"]["distill"]["report"]
    assert report["after"]["mean_deg"] < 0.3 * report["before"]["mean_deg"]
    found = read_field(workspace / "map-field.safetensors")
    frames, points = map_frames(hex_map), hex_map.V[hex_map.T].mean(axis=1)
    assert isinstance(found, NeuralField)
    assert found.query(points).shape == (len(frames), 9)
    assert not manifest["stages"]["distill"]["warnings"]
    manifest["stages"]["hex"]["report"]["grid"] = []  # as where a grid took the place of the map's hexes
    (workspace / "manifest.json").write_text(json.dumps(manifest))
    assert run_command_line([*words, "--iterations", "2"]) == 0
    assert "are of a regular grid" in capsys.readouterr().err

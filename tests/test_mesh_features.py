"""Features, chains and corners against shapes whose features one can count."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from neurframe_cli.errors import InvalidMesh, TooNewFile, UnreadableFile
from neurframe_cli.mesh.arrays import Surface
from neurframe_cli.mesh.clean_surface import clean_surface
from neurframe_cli.mesh.features import features_by_angle, features_from_edges, read_features, write_features
from neurframe_cli.mesh.features_from_segments import features_from_segments
from neurframe_cli.mesh.read_surface import read_surface
from neurframe_cli.mesh.surface_edges import surface_edges

SAMPLES = Path(__file__).parent.parent / "samples"


def sample(name: str) -> Surface:
    return clean_surface(read_surface(SAMPLES / name))[0]


@pytest.mark.parametrize(
    ("name", "edges", "chains", "corners"),
    [
        ("cube.stl", 12, 12, 8),
        ("tetrahedron.obj", 6, 6, 4),
        ("cylinder.stl", 2 * 48, 2, 0),
        ("torus.obj", 0, 0, 0),
        # the L-profile has 6 corners at each of its 2 ends: 18 edges; the hole has 2 closed chains
        ("bracket.stl", None, 18 + 2, 12),
    ],
)
def test_features_of_the_samples(name: str, edges: int | None, chains: int, corners: int) -> None:
    surface = sample(name)
    found = features_by_angle(surface.V, surface.F, 45.0)
    assert edges is None or len(found.edges) == edges
    assert len(found.chains) == chains
    assert len(found.corners) == corners


def test_dihedral_angles_of_a_prism() -> None:
    """A regular 12-gon turns by 30 degrees at each wall edge and by 90 at its caps."""
    angles = 2 * np.pi * np.arange(12) / 12
    ring = np.column_stack([np.cos(angles), np.sin(angles)])
    V = np.concatenate([np.column_stack([ring, np.full(12, z)]) for z in (0, 1)])
    a, b = np.arange(12), np.roll(np.arange(12), -1)
    wall = np.concatenate([np.column_stack([a, b, b + 12]), np.column_stack([a, b + 12, a + 12])])
    caps = [[[0, i + 1, i], [12, 12 + i, 13 + i]] for i in range(1, 11)]
    edges = surface_edges(V, np.concatenate([wall, np.array(caps).reshape(-1, 3)]))
    found = np.unique(np.round(edges.angles_deg, 6))
    assert found.tolist() == [0.0, 30.0, 90.0]
    assert (np.round(edges.angles_deg, 6) == 30.0).sum() == 12


def test_an_open_edge_is_a_feature() -> None:
    V, F = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.0]]), np.array([[0, 1, 2], [1, 3, 2]])
    assert len(features_by_angle(V, F, 45.0).edges) == 4


def test_a_sharp_bend_is_a_corner() -> None:
    V = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [2, 1, 0], [2, 2, 0.0]])
    found = features_from_edges(V, np.array([[0, 1], [1, 2], [2, 3], [3, 4]]))
    assert found.corners.tolist() == [0, 2, 4]
    assert [chain.tolist() for chain in found.chains] == [[0, 1, 2], [2, 3, 4]]


@given(st.lists(st.tuples(st.integers(0, 9), st.integers(0, 9)), max_size=40))
def test_chains_cover_every_edge_once(pairs: list[tuple[int, int]]) -> None:
    V = np.random.default_rng(0).normal(size=(10, 3))
    found = features_from_edges(V, np.array(pairs, np.int64).reshape(-1, 2))
    walked = [tuple(sorted(pair)) for chain in found.chains for pair in itertools.pairwise(chain)]
    assert sorted(walked) == sorted({tuple(sorted(pair)) for pair in pairs if pair[0] != pair[1]})
    for chain in found.chains:
        assert not set(chain[1:-1].tolist()) & set(found.corners.tolist())


def test_features_file_round_trip(tmp_path: Path) -> None:
    surface = sample("bracket.stl")
    written = features_by_angle(surface.V, surface.F, 45.0)
    write_features(tmp_path / "features.json", written)
    read = read_features(tmp_path / "features.json")
    assert np.array_equal(read.edges, written.edges)
    assert np.array_equal(read.corners, written.corners)
    assert all(np.array_equal(a, b) for a, b in zip(read.chains, written.chains, strict=True))


@pytest.mark.parametrize(
    ("text", "error"),
    [
        ("[]", UnreadableFile),
        ("{", UnreadableFile),
        ('{"format":"neurframe-features","version":2}', TooNewFile),
        ('{"format":"neurframe-features","version":1,"edges":[[0,1],[2]]}', UnreadableFile),
        ('{"format":"neurframe-features","version":1,"edges":[[0,-1]]}', UnreadableFile),
        ('{"format":"neurframe-features","version":1,"edges":[[0,1]],"chains":[[0,2]]}', InvalidMesh),
    ],
)
def test_broken_features_files(text: str, error: type[Exception], tmp_path: Path) -> None:
    (tmp_path / "features.json").write_text(text)
    with pytest.raises(error, match=r"features\.json"):
        read_features(tmp_path / "features.json")


def test_given_segments_become_the_edges_that_lie_on_them() -> None:
    """The circles of the cylinder, drawn twice as fine and slightly off, come back as the same 96 edges."""
    surface = sample("cylinder.stl")
    angles = 2 * np.pi * (np.arange(96) + 0.2) / 96
    ring = 5.01 * np.column_stack([np.cos(angles), np.sin(angles)])
    rings = [np.column_stack([ring, np.full(96, z)]) for z in (0.0, 15.0)]
    segments = np.concatenate([np.stack([r, np.roll(r, -1, axis=0)], axis=1) for r in rings])
    found, warnings = features_from_segments(surface.V, surface.F, segments)
    assert np.array_equal(found.edges, features_by_angle(surface.V, surface.F, 45.0).edges)
    assert warnings == []

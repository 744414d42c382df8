"""Feature lists in each of their formats name the same four edges of a square."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from neurframe_cli.errors import InputError
from neurframe_cli.mesh.arrays import Features, Surface, as_surface, as_tets
from neurframe_cli.mesh.features import features_by_angle, write_features
from neurframe_cli.mesh.read_feature_segments import read_feature_segments
from neurframe_cli.mesh.write_mesh import write_tets


@pytest.fixture
def square() -> Surface:
    V = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]])
    return as_surface(V, [[0, 1, 2], [0, 2, 3]])


def edge_set(segments: np.ndarray) -> set[tuple[tuple[float, ...], ...]]:
    return {tuple(sorted(map(tuple, segment))) for segment in segments.tolist()}


def test_four_formats(square: Surface, tmp_path: Path) -> None:
    V = square.V
    rim = edge_set(np.stack([V, np.roll(V, -1, axis=0)], axis=1))
    write_features(tmp_path / "features.json", features_by_angle(V, square.F, 45.0))
    (tmp_path / "rim.sharp").write_text("4\n1,0,0\n1,0,1\n0,1,1\n1,1,2\n")
    (tmp_path / "rim.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nl 1 2 3\nl -2 -1 -4\n")
    tets = as_tets(np.concatenate([V, [[0.5, 0.5, 1]]]), [[0, 1, 2, 4], [0, 2, 3, 4]])
    write_tets(tmp_path / "rim.mesh", tets, features_by_angle(V, square.F, 45.0))
    for name in ("features.json", "rim.sharp", "rim.obj", "rim.mesh"):
        assert edge_set(read_feature_segments(tmp_path / name, square)) == rim, name


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.sharp", "1\n1,2,0\n"),
        ("a.sharp", "1\n1,0,3\n"),
        ("a.sharp", "2\n1,0,0\n"),
        ("a.sharp", "x"),
        ("a.obj", "v 0 0 0\nv 1 0 0\nl 1 3\n"),
        ("a.obj", "v 0 0\nl 1 1\n"),
        ("a.obj", "v 0 0 0\n"),
        ("a.off", "OFF\n0 0 0\n"),
        ("a.json", '{"format":"neurframe-features","version":1,"edges":[[0,9]],"chains":[[0,9]]}'),
    ],
)
def test_broken_lists(name: str, text: str, square: Surface, tmp_path: Path) -> None:
    (tmp_path / name).write_text(text)
    with pytest.raises(InputError, match=name.replace(".", r"\.")):
        read_feature_segments(tmp_path / name, square)


def test_sharp_needs_a_surface(tmp_path: Path) -> None:
    (tmp_path / "a.sharp").write_text("0\n")
    tets = as_tets(np.eye(4, 3), [[0, 1, 2, 3]])
    with pytest.raises(InputError, match="tet mesh"):
        read_feature_segments(tmp_path / "a.sharp", (tets, Features()))

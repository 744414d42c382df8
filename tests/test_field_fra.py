"""FRA files: exact round trip, the sample dialects, and classed errors for anything else."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from neurframe_cli.errors import InputError, InvalidMesh, TooNewFile, UnreadableFile
from neurframe_cli.field.fra import read_fra, read_frames, write_fra


def test_frames_survive_a_round_trip(tmp_path: Path):
    frames = Rotation.random(50, random_state=0).as_matrix()
    write_fra(tmp_path / "a.fra", frames)
    assert (read_fra(tmp_path / "a.fra") == frames.transpose(0, 2, 1)).all()
    assert read_frames(tmp_path / "a.fra") == pytest.approx(frames, abs=1e-15)
    assert (tmp_path / "a.fra").read_text().startswith("FRA 1\n50 3 0\n")


def test_no_frames_survive_too(tmp_path: Path):
    write_fra(tmp_path / "a.fra", np.zeros((0, 3, 3)))
    assert read_frames(tmp_path / "a.fra").shape == (0, 3, 3)


def test_long_and_left_handed_vectors_mean_the_nearest_rotation(tmp_path: Path):
    (tmp_path / "a.fra").write_text("FRA 1\n1 3 4\n2.5 0 0\n0 0 1e-3\n0 1 0\n")
    frame = read_frames(tmp_path / "a.fra")[0]
    assert np.linalg.det(frame) == pytest.approx(1)
    assert np.abs(frame) == pytest.approx(np.array([[1, 0, 0], [0, 0, 1], [0, 1, 0]]), abs=1e-15)


def test_skew_vectors_mean_the_polar_factor(tmp_path: Path):
    R = Rotation.random(random_state=1).as_matrix()
    stretch = np.array([[1.0, 0.2, 0.1], [0.2, 1.0, 0.0], [0.1, 0.0, 1.0]])
    skew = R @ (stretch / np.linalg.norm(stretch, axis=0))
    np.savetxt(tmp_path / "a.fra", skew.T, header="FRA 1\n1 3 0", comments="")
    from scipy.linalg import polar

    assert read_frames(tmp_path / "a.fra")[0] == pytest.approx(polar(skew)[0], abs=1e-12)


@pytest.mark.parametrize(
    ("text", "error", "says"),
    [
        ("", UnreadableFile, "empty"),
        ("PERM 1\n", UnreadableFile, "FRA"),
        ("FRA", UnreadableFile, "expected at the top"),
        ("FRA one\n1 3 0\n", UnreadableFile, "expected at the top"),
        ("FRA 2\n0 3 0\n", TooNewFile, "version 2"),
        ("FRA 1\n-1 3 0\n", UnreadableFile, "-1 tets"),
        ("FRA 1\n1 0 0\n", UnreadableFile, "0 vectors"),
        ("FRA 1\n1 3 0\n1 0 0\n0 1 0\n", UnreadableFile, "6 numbers"),
        ("FRA 1\n1 3 0\n1 0 0\n0 1 0\n0 0 1\n0\n", UnreadableFile, "10 numbers"),
        ("FRA 1\n99999999999999999999 3 0\n1 0 0\n", UnreadableFile, "numbers"),
        ("FRA 1\n1 3 0\n1 0 0\n0 x 0\n0 0 1\n", UnreadableFile, "not a number"),
        ("FRA 1\n1 3 0\n1 0 0\n0 nan 0\n0 0 1\n", UnreadableFile, "tet 0 is not finite"),
        ("FRA 1\n1 2 0\n1 0 0\n0 1 0\n", InvalidMesh, "2 vectors"),
        ("FRA 1\n1 3 0\n1 0 0\n0 1 0\n1 1 0\n", InvalidMesh, "plane"),
        ("FRA 1\n1 3 0\n1 0 0\n0 1 0\n0 0 0\n", InvalidMesh, "plane"),
    ],
)
def test_bad_files_are_classed_errors(tmp_path: Path, text: str, error: type[Exception], says: str):
    (tmp_path / "a.fra").write_text(text)
    with pytest.raises(error, match=says):
        read_frames(tmp_path / "a.fra")


def test_a_missing_file_is_a_classed_error(tmp_path: Path):
    with pytest.raises(UnreadableFile, match="no such file"):
        read_fra(tmp_path / "none.fra")


VALID = b"FRA 1\n2 3 0\n1 0 0\n0 1 0\n0 0 1\n0 1 0\n0 0 1\n1 0 0\n"


@settings(max_examples=300, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.integers(0, len(VALID)), st.integers(0, 8), st.binary(max_size=8))
def test_damaged_files_are_frames_or_classed_errors(tmp_path: Path, at: int, cut: int, put: bytes):
    (tmp_path / "a.fra").write_bytes(VALID[:at] + put + VALID[at + cut :])
    try:
        frames = read_frames(tmp_path / "a.fra")
    except InputError:
        return
    gram = frames.transpose(0, 2, 1) @ frames
    assert gram == pytest.approx(np.broadcast_to(np.eye(3), gram.shape), abs=1e-12)
    assert np.linalg.det(frames) == pytest.approx(1.0)


@settings(max_examples=100, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.binary(max_size=200))
def test_arbitrary_bytes_are_classed_errors(tmp_path: Path, content: bytes):
    (tmp_path / "a.fra").write_bytes(content)
    with pytest.raises(InputError):
        read_frames(tmp_path / "a.fra")

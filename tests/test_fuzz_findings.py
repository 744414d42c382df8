"""What fuzzing has found, one file each: it is refused in one line, at once."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from damage import reading_limits
from fuzz_targets import TARGETS

from neurframe_cli.errors import InvalidMesh, NeurframeError, UnreadableFile
from neurframe_cli.field.field_file import read_field
from neurframe_cli.mesh.off import read_off
from neurframe_cli.mesh.read_cells import read_cells
from neurframe_cli.mesh.read_points import read_points

PLY_HEADER = b"ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\n"


def refused(
    read: Callable[[Path], object], path: Path, content: bytes, kind: type[NeurframeError], match: str
) -> None:
    path.write_bytes(content)
    with reading_limits(), pytest.raises(kind, match=match) as caught:
        read(path)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("end", [b"", b"comment end_header\n", b"end_header_\n"])
def test_a_ply_header_without_end(end: bytes, tmp_path: Path) -> None:
    """meshio looked for the end for ever."""
    refused(read_cells, tmp_path / "a.ply", PLY_HEADER + end, UnreadableFile, "header does not end")


@pytest.mark.parametrize("count", [b"2147483648", b"9" * 5000])
def test_a_ply_file_with_too_many_faces(count: bytes, tmp_path: Path) -> None:
    """meshio stepped through all of them, and asked for memory for each."""
    content = PLY_HEADER.replace(b"ascii", b"binary_little_endian") + b"element face " + count
    content += b"\nproperty list uchar int vertex_indices\nend_header\n" + bytes(64)
    refused(read_cells, tmp_path / "a.ply", content, UnreadableFile, "elements face in")


@pytest.mark.parametrize("counts", [b"-inf 1 0", b"3 -inf 0", b"nan nan nan", b"3.5 1 0", b"1e300 1 0"])
def test_counts_of_an_off_file(counts: bytes, tmp_path: Path) -> None:
    """Minus infinity was an OverflowError."""
    content = b"OFF\n" + counts + b"\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"
    refused(read_off, tmp_path / "a.off", content, UnreadableFile, "do not fit")


def test_points_that_are_comments(tmp_path: Path) -> None:
    """NumPy's warning went to the terminal."""
    refused(read_points, tmp_path / "points.txt", b"\n# 1 2 3\n", InvalidMesh, "at least one point")


def test_a_field_whose_tensors_have_other_names(tmp_path: Path) -> None:
    """PyTorch lists them on lines of their own."""
    next(target for target in TARGETS if target.name == "field").prepare(tmp_path)
    content = (tmp_path / "field.safetensors").read_bytes().replace(b"hidden.3.weight", b"hidden.3.height")
    refused(read_field, tmp_path / "field.safetensors", content, UnreadableFile, "incomplete")

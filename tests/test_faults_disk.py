"""A disk that is full or cannot be written, in every stage: one clear line, nothing torn, and it goes on afterwards."""

from __future__ import annotations

import contextlib
import ctypes
import errno
import os
import resource
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from faults import OUTPUTS, STAGES, assert_clear, assert_same, assert_whole, copy_of, neurframe, words

from neurframe_cli.errors import NotValid, StageError

PR_CAPBSET_DROP = 24
# what lets root ignore the permissions of files: CAP_DAC_OVERRIDE, CAP_DAC_READ_SEARCH
OVERRIDES = (1, 2)


def size_of(stage: str, workspace: Path) -> int:
    return sum((workspace / name).stat().st_size for name in OUTPUTS[stage])


@contextlib.contextmanager
def small_disk(folder: Path, size: int) -> Iterator[Path]:
    """A file system of so many bytes; skips the test where we may not mount one."""
    folder.mkdir()
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", folder], capture_output=True, check=False
    )
    if mounted.returncode != 0:
        pytest.skip("only root can mount a small disk; the limit on the size of a file is tested instead")
    try:
        yield folder
    finally:
        subprocess.run(["umount", "--lazy", folder], check=True)


@pytest.mark.slow
@pytest.mark.skipif(os.geteuid() != 0, reason="only root can mount a small disk")
@pytest.mark.parametrize("stage", STAGES)
def test_full_disk(stage: str, staged: dict[str, Path], tmp_path: Path) -> None:
    needed = size_of(stage, staged["done"])
    with small_disk(tmp_path / "disk", 64 << 20) as disk:
        workspace = copy_of(staged[stage], disk)
        ballast = disk / "ballast"
        left = os.statvfs(disk)
        # room for the manifest and for some of the artifacts, not for all
        ballast.write_bytes(b"\0" * max(left.f_bavail * left.f_frsize - needed // 2, 0))
        ended = neurframe(*words(stage, workspace))
        assert_clear(ended, StageError.exit_code)
        # in our words, or in those of a program
        assert "disk is full" in ended.said or os.strerror(errno.ENOSPC) in ended.said
        assert_whole(stage, workspace, staged["done"])
        ballast.unlink()
        assert neurframe(*words(stage, workspace)).code == 0
        assert_same(stage, workspace, staged["done"])


def limit_file_size(size: int) -> Callable[[], None]:
    """A limit that any user has: no file may grow beyond it."""
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


# the small disk shows the rest to root; programs end by a signal here
LIMITED = [*STAGES] if os.geteuid() != 0 else ["quad", "hex"]


@pytest.mark.slow
@pytest.mark.parametrize("stage", LIMITED)
def test_file_that_may_not_grow(stage: str, staged: dict[str, Path], tmp_path: Path) -> None:
    workspace = copy_of(staged[stage], tmp_path)
    largest = max((staged["done"] / name).stat().st_size for name in OUTPUTS[stage])
    ended = neurframe(*words(stage, workspace), preexec_fn=limit_file_size(largest // 2))
    assert_clear(ended, StageError.exit_code)
    assert_whole(stage, workspace, staged["done"])
    assert neurframe(*words(stage, workspace)).code == 0
    assert_same(stage, workspace, staged["done"])


def obey_permissions() -> None:
    """Take from root what lets it write everywhere; an ordinary user has no such thing."""
    if os.geteuid() == 0:
        for capability in OVERRIDES:
            if ctypes.CDLL(None, use_errno=True).prctl(PR_CAPBSET_DROP, capability, 0, 0, 0) != 0:
                os._exit(errno.EPERM)


@contextlib.contextmanager
def read_only(folder: Path) -> Iterator[None]:
    """A folder that nothing can be written to; its owner may open it again."""
    folder.chmod(0o555)
    try:
        yield
    finally:
        folder.chmod(0o755)


@pytest.mark.slow
@pytest.mark.parametrize("stage", STAGES)
def test_read_only_workspace(stage: str, staged: dict[str, Path], tmp_path: Path) -> None:
    workspace = copy_of(staged[stage], tmp_path)
    with read_only(workspace):
        ended = neurframe(*words(stage, workspace), preexec_fn=obey_permissions)
    assert_clear(ended, StageError.exit_code)
    assert "permission denied" in ended.said
    assert_whole(stage, workspace, staged["done"])


def test_read_only_place_for_a_workspace(tmp_path: Path) -> None:
    (tmp_path / "shelf").mkdir()
    with read_only(tmp_path / "shelf"):
        ended = neurframe(*words("tetize", tmp_path / "shelf" / "new"), preexec_fn=obey_permissions)
    assert_clear(ended, StageError.exit_code)
    assert list((tmp_path / "shelf").iterdir()) == []


def test_read_only_place_for_the_further_file(staged: dict[str, Path], tmp_path: Path) -> None:
    workspace = copy_of(staged["done"], tmp_path)
    (tmp_path / "shelf").mkdir()
    with read_only(tmp_path / "shelf"):
        output = tmp_path / "shelf" / "hex.vtu"
        ended = neurframe(*words("hex", workspace), "-o", str(output), preexec_fn=obey_permissions)
    assert_clear(ended, StageError.exit_code)
    assert list((tmp_path / "shelf").iterdir()) == []


def test_workspace_that_may_not_be_read(staged: dict[str, Path], tmp_path: Path) -> None:
    workspace = copy_of(staged["train"], tmp_path)
    (workspace / "tets.mesh").chmod(0)
    ended = neurframe(*words("train", workspace), preexec_fn=obey_permissions)
    assert_clear(ended, 2, StageError.exit_code)
    assert "tets.mesh" in ended.said


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full")
def test_output_that_cannot_be_written_is_no_success(staged: dict[str, Path], tmp_path: Path) -> None:
    check = ["check", str(staged["done"] / "hex.vtk"), "--against", str(staged["done"] / "surface.ply")]
    script = [sys.executable, "-m", "neurframe_cli", *check]
    with open("/dev/full", "w") as full:
        ended = subprocess.run(script, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
        silent = subprocess.run(script, stdout=subprocess.DEVNULL, stderr=full, check=False)
    assert ended.returncode == StageError.exit_code
    assert ended.stderr.startswith("neurframe: error: cannot write to standard output")
    assert silent.returncode == 0


def test_a_reader_that_goes_away_does_not_make_a_bad_mesh_good(tmp_path: Path) -> None:
    (tmp_path / "bad.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n")
    reader, writer = os.pipe()
    os.close(reader)
    check = [
        "check",
        str(tmp_path / "bad.obj"),
        "--against",
        str(Path(__file__).parent.parent / "samples/cube.stl"),
    ]
    ended = subprocess.run(
        [sys.executable, "-m", "neurframe_cli", *check], stdout=writer, stderr=subprocess.PIPE, check=False
    )
    os.close(writer)
    assert ended.returncode == NotValid.exit_code

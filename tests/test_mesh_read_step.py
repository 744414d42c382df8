"""STEP through Gmsh: the real one where it is installed, and programs that misbehave in its place."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from neurframe_cli.errors import UnreadableFile
from neurframe_cli.mesh.clean_surface import clean_surface
from neurframe_cli.mesh.read_step import find_gmsh
from neurframe_cli.mesh.read_surface import read_surface

MODELS = Path(os.environ.get("NEURFRAME_MODELS", Path(__file__).parent.parent.parent / "shared" / "meshes"))
STEP_MODEL = MODELS / "cad" / "i14o_s7.step"

WRITES_A_TETRAHEDRON = """
import sys
out = sys.argv[sys.argv.index("-o") + 1]
points = "0 0 0\\n1 0 0\\n0 1 0\\n0 0 1\\n"
faces = "3 0 2 1\\n3 0 1 3\\n3 1 2 3\\n3 0 3 2\\n"
open(out, "w").write(
    "# vtk DataFile Version 2.0\\nx\\nASCII\\nDATASET UNSTRUCTURED_GRID\\nPOINTS 4 double\\n" + points
    + "CELLS 4 16\\n" + faces + "CELL_TYPES 4\\n5\\n5\\n5\\n5\\n"
)
"""


@pytest.fixture
def step_file(tmp_path: Path) -> Path:
    path = tmp_path / "part.stp"
    path.write_text("ISO-10303-21;\nHEADER;\nENDSEC;\nEND-ISO-10303-21;\n")
    return path


def stand_in(folder: Path, code: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A `gmsh` as the wheel installs it: a script for a Python."""
    script = folder / "gmsh"
    script.write_text(f"#!{sys.executable}\n{code}")
    script.chmod(0o755)
    monkeypatch.setenv("NEURFRAME_GMSH", str(script))


def test_command_line_and_result(step_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stand_in(tmp_path, WRITES_A_TETRAHEDRON, monkeypatch)
    surface, report = clean_surface(read_surface(step_file))
    assert report.genus == 0
    assert len(surface.F) == 4


@pytest.mark.parametrize(
    ("code", "words"),
    [
        ("import sys; print('Error: bad STEP', file=sys.stderr); sys.exit(1)", "bad STEP"),
        ("import os; os.kill(os.getpid(), 11)", "SIGSEGV"),
        ("pass", "found no faces"),
    ],
)
def test_a_gmsh_that_fails(
    code: str, words: str, step_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stand_in(tmp_path, code, monkeypatch)
    with pytest.raises(UnreadableFile, match=words) as caught:
        read_surface(step_file)
    assert "part.stp" in str(caught.value)


@pytest.mark.skipif(
    find_gmsh() is None or not STEP_MODEL.exists(), reason="needs Gmsh and the model collection"
)
def test_a_real_step_file() -> None:
    _, report = clean_surface(read_surface(STEP_MODEL))
    assert report.closed
    assert report.genus == 2

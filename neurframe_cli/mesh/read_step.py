"""STEP files through Gmsh, which runs as a program of its own because of its licence (GPL)."""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from pathlib import Path

from neurframe_cli.errors import InputError, StageError, UnreadableFile, UnsupportedFormat
from neurframe_cli.mesh.arrays import Surface, as_surface
from neurframe_cli.mesh.meshio_cells import meshio_cells
from neurframe_cli.process import run_child

TIMEOUT_S = 600.0
# the chord of an arc: 24 triangles round a full circle keep a hole within 1 % of its radius
ELEMENTS_PER_CIRCLE = 24


def find_gmsh() -> str | None:
    """The Gmsh executable: $NEURFRAME_GMSH, the one beside this Python, the one on PATH; None without one."""
    named = os.environ.get("NEURFRAME_GMSH")
    if named:
        return named
    return shutil.which("gmsh", path=str(Path(sys.executable).parent)) or shutil.which("gmsh")


def _command(gmsh: str) -> list[str]:
    """How to start it.  The wheel's `gmsh` is a script for whatever `python` comes first on PATH: its own is named."""
    try:
        with Path(gmsh).open("rb") as file:
            first_line = file.readline(200)
    except OSError:
        return [gmsh]
    if not (first_line.startswith(b"#!") and b"python" in first_line):
        return [gmsh]
    beside = Path(gmsh).parent / "python"
    return [str(beside) if beside.exists() else sys.executable, gmsh]


def read_step(path: Path) -> Surface:
    """The faces of a STEP model, triangulated by Gmsh.

    Raises UnsupportedFormat where there is no Gmsh, UnreadableFile when it cannot read the file, TimedOut.
    """
    gmsh = find_gmsh()
    if gmsh is None:
        raise UnsupportedFormat(
            f"{path}: STEP files need Gmsh, which is not installed",
            hint="pip install 'neurframe[step]', or apt install gmsh, or point NEURFRAME_GMSH at it",
        )
    with tempfile.TemporaryDirectory(prefix="neurframe-step-") as folder:
        out = Path(folder) / "surface.vtk"
        # a copy under a name with the extension that Gmsh goes by
        copy = Path(folder) / "model.step"
        shutil.copyfile(path, copy)
        settings = ["-clcurv", str(ELEMENTS_PER_CIRCLE), "-setnumber", "Geometry.OCCAutoFix", "1"]
        try:
            run_child(
                [*_command(gmsh), copy, "-2", "-format", "vtk", "-o", out, *settings],
                name="gmsh",
                timeout_s=TIMEOUT_S,
                cwd=Path(folder),
            )
        except (StageError, InputError) as error:
            raise UnreadableFile(f"{path}: {error}", hint=error.hint) from error
        if not out.exists():
            raise UnreadableFile(f"{path}: Gmsh found no faces in it")
        cells = meshio_cells(out, "vtk")
    return as_surface(cells.V, cells.triangles)

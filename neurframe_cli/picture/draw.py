"""Pictures of fields and meshes, drawn in a process of their own.

Where there is no OpenGL, VTK does not raise: it ends the process with a segmentation fault.
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

import neurframe_cli
from neurframe_cli.errors import ChildCrashed, StageError
from neurframe_cli.mesh.arrays import Progress, silent
from neurframe_cli.picture.field_data import FieldData
from neurframe_cli.picture.mesh_data import HybridData, MeshData
from neurframe_cli.process.memory import usable_mib
from neurframe_cli.process.run_child import run_child

# the pictures that can be asked for
FIELD_PICTURES = ("crosses", "singular", "frames", "tets", "singularities", "streamlines")
MESH_PICTURES = ("quads", "hexes", "hexes_cut", "hexes_singular", "hexes_trouble")
HYBRID_PICTURES = ("filled",)
TIMEOUT_S = 600.0
# how VTK finds a place to draw in
_DISPLAY_VARIABLES = ("DISPLAY", "XAUTHORITY", "XDG_RUNTIME_DIR", "VTK_DEFAULT_OPENGL_WINDOW")


def draw(
    pictures: Mapping[str, Path], data: FieldData | MeshData | HybridData, progress: Progress = silent
) -> None:
    """Draws PNG files: name, one of FIELD_PICTURES, MESH_PICTURES or HYBRID_PICTURES as the data are, -> path.

    Raises StageError where nothing can be drawn on this machine, TimedOut after ten minutes.
    """
    with tempfile.TemporaryDirectory(prefix="neurframe-") as folder:
        stored = Path(folder) / "data.npz"
        data.save(stored)
        targets = [f"{name}={path.absolute()}" for name, path in pictures.items()]
        try:
            run_child(
                [sys.executable, "-m", "neurframe_cli.picture", stored, *targets],
                name="the picture renderer",
                timeout_s=TIMEOUT_S,
                memory_mib=usable_mib(),
                env={name: os.environ[name] for name in _DISPLAY_VARIABLES if name in os.environ},
                cwd=Path(neurframe_cli.__file__).parents[1],
                on_progress=progress,
            )
        except ChildCrashed as error:
            raise StageError(
                f"no picture could be drawn, VTK found no OpenGL to draw with ({error})",
                hint="install Mesa's EGL or OSMesa (Debian: libegl1, libosmesa6), or run under xvfb-run; "
                "the other results do not need pictures",
            ) from error

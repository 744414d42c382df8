"""What is installed, and does each part of the pipeline work here."""

from __future__ import annotations

import platform
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from neurframe_cli import __version__
from neurframe_cli.errors import StageError
from neurframe_cli.mesh.arrays import Features, Surface, TetMesh, silent
from neurframe_cli.pipeline.executables import PROGRAMS, find_executable
from neurframe_cli.process import run_child

_PACKAGES = (
    "torch",
    "pytetwild",
    "libigl",
    "trimesh",
    "meshio",
    "pyvista",
    "numpy",
    "scipy",
    "safetensors",
)


@dataclass(frozen=True)
class Finding:
    """One line of the examination; required: neurframe does not work without it."""

    name: str
    ok: bool
    detail: str
    required: bool = True


def examine(threads: int) -> list[Finding]:
    """Versions, device, executables, and a self-test of tetize, training and drawing on a cube."""
    return [
        Finding(
            "neurframe", True, f"{__version__}, Python {platform.python_version()}, {platform.platform()}"
        ),
        *(_package(name) for name in _PACKAGES),
        _examined("device", lambda: _device(threads)),
        *(_examined(f"neurframe-{program}", partial(_executable, program)) for program in PROGRAMS),
        _examined("gmsh (STEP files)", _gmsh, required=False),
        _examined("tetrahedral meshing", _tetize_cube),
        _examined("training", lambda: _train_cube(threads)),
        _examined("pictures", _draw_cube, required=False),
    ]


def _package(name: str) -> Finding:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return Finding(name, True, version(name))
    except PackageNotFoundError:
        return Finding(name, False, "not installed")


def _examined(name: str, examination: Callable[[], str], *, required: bool = True) -> Finding:
    started = time.perf_counter()
    try:
        detail = examination()
    except Exception as error:  # whatever is broken here is what the doctor was asked for
        return Finding(name, False, str(error) or type(error).__name__, required)
    return Finding(name, True, f"{detail} ({time.perf_counter() - started:.1f} s)", required)


def _device(threads: int) -> str:
    from neurframe_cli.field.device import choose_device

    return f"{choose_device('auto', 'auto').label}, {threads} threads"


def _executable(program: str) -> str:
    path = find_executable(program)
    said = (
        run_child([path, "--version"], name=path.name, timeout_s=10).stdout.decode("utf-8", "replace").strip()
    )
    return said or str(path)


def _gmsh() -> str:
    from neurframe_cli.mesh.read_step import find_gmsh

    found = find_gmsh()
    if found is None:
        raise StageError("not installed; pip install 'neurframe[step]' for STEP files")
    return found


def cube() -> Surface:
    """The unit cube as twelve triangles."""
    V = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], np.float64)
    quads = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
    return Surface(V, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]).astype(np.int64))


def _tetize_cube() -> str:
    from neurframe_cli.stages.tetize import TetizeOptions, tetize

    with tempfile.TemporaryDirectory() as scratch:
        made = tetize(cube(), TetizeOptions(edge_length=0.3, timeout_s=60), silent, Path(scratch))
    return f"{len(made.tets.T)} tets in a cube, {'seeded' if made.seeded else 'not seeded'}"


def _train_cube(threads: int) -> str:
    from neurframe_cli.stages.train import TrainOptions, train

    surface = cube()
    # five tets: one in the middle, four at the corners 1, 2, 4, 7
    T = np.array([[0, 3, 5, 6], [0, 3, 1, 5], [0, 3, 6, 2], [0, 5, 4, 6], [3, 5, 6, 7]], np.int64)
    edges = surface.V[T[:, 1:]] - surface.V[T[:, :1]]
    T[np.linalg.det(edges) < 0] = T[np.linalg.det(edges) < 0][:, [0, 2, 1, 3]]
    result = train(
        TetMesh(surface.V, T), Features(), TrainOptions(iterations=20, time_budget_s=5, threads=threads)
    )
    return f"loss {result.report['losses']['total']:.4f} on {result.report['device']}"


def _draw_cube() -> str:
    from neurframe_cli.picture.draw import draw
    from neurframe_cli.picture.field_data import FieldData

    surface = cube()
    data = FieldData(surface, TetMesh(surface.V, np.array([[0, 4, 2, 1]], np.int64)))
    with tempfile.TemporaryDirectory() as scratch:
        picture = Path(scratch) / "cube.png"
        draw({"singular": picture}, data)
        return f"a PNG of {picture.stat().st_size} bytes"

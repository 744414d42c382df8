"""The artifacts of a workspace as arrays, for those who have arrays and want none of the files."""

from __future__ import annotations

import contextlib
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from neurframe_cli.field.fra import read_frames, write_fra
from neurframe_cli.mesh.arrays import Features, Floats, Surface, TetMesh
from neurframe_cli.mesh.features import read_features, write_features
from neurframe_cli.mesh.read_surface import read_surface
from neurframe_cli.mesh.read_tets import read_medit
from neurframe_cli.mesh.write_mesh import write_surface, write_tets
from neurframe_cli.pipeline.atomic import atomic_path, write_error
from neurframe_cli.pipeline.discretize_step import CROSSES, FRAMES_FRA
from neurframe_cli.pipeline.quad_source import read_crosses
from neurframe_cli.pipeline.tetize_step import FEATURES, SURFACE, TETS
from neurframe_cli.pipeline.workspace import Workspace

MODEL_SURFACE, MODEL_TETS, MODEL_FEATURES = "input.ply", "input.mesh", "input-features.obj"


def store_model(workspace: Workspace, model: Surface | TetMesh) -> Path:
    """Write the model as the file that tetize begins with; returns its path."""
    path = workspace / (MODEL_SURFACE if isinstance(model, Surface) else MODEL_TETS)
    with atomic_path(path) as temporary:
        if isinstance(model, Surface):
            write_surface(temporary, model)
        else:
            write_tets(temporary, model)
    return path


def store_segments(workspace: Workspace, segments: Floats) -> Path:
    """Write feature segments (k,2,3) as lines of an OBJ file; returns its path."""
    points = [f"v {x!r} {y!r} {z!r}\n" for x, y, z in segments.reshape(-1, 3).tolist()]
    lines = [f"l {2 * i + 1} {2 * i + 2}\n" for i in range(len(segments))]
    path = workspace / MODEL_FEATURES
    with atomic_path(path) as temporary:
        temporary.write_text("".join(points + lines))
    return path


def store_tets(workspace: Workspace, surface: Surface, tets: TetMesh, features: Features) -> None:
    """Write what tetize leaves."""
    with atomic_path(workspace / SURFACE) as path:
        write_surface(path, surface)
    with atomic_path(workspace / TETS) as path:
        write_tets(path, tets, features)
    with atomic_path(workspace / FEATURES) as path:
        write_features(path, features)


def load_tets(workspace: Workspace) -> tuple[Surface, TetMesh, Features]:
    """What tetize has left."""
    tets, _ = read_medit(workspace / TETS)
    return read_surface(workspace / SURFACE), tets, read_features(workspace / FEATURES, len(tets.V))


def store_frames(workspace: Workspace, frames: Floats, carrier: Surface, crosses: Floats) -> None:
    """Write what the meshes need of discretize: frames (m,3,3) of the tets, crosses (k,2,3) of the carrier's
    triangles."""
    with atomic_path(workspace / FRAMES_FRA) as path:
        write_fra(path, frames)
    with atomic_path(workspace / CROSSES) as path:
        np.savez(path, V=carrier.V, F=carrier.F, crosses=crosses)


def load_frames(workspace: Workspace) -> tuple[Floats, Surface, Floats]:
    """What discretize has left: frames, carrier, crosses."""
    carrier = read_crosses(workspace / CROSSES)
    return read_frames(workspace / FRAMES_FRA), carrier.surface, carrier.crosses


@contextlib.contextmanager
def kept_or_temporary(chosen: str | Path | None) -> Iterator[Workspace]:
    """The workspace in the folder that was chosen, made if missing, else in one that is gone at the end."""
    if chosen is None:
        with tempfile.TemporaryDirectory(prefix="neurframe-") as folder:
            yield Workspace(Path(folder))
        return
    try:
        Path(chosen).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise write_error(Path(chosen), error) from error
    yield Workspace(Path(chosen))

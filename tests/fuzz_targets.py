"""Everything that reads a file, each with a good file: what the fuzz tests damage."""

from __future__ import annotations

import resource
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from damage import PROGRAM_CPU_LIMIT_S

from neurframe_cli.cli.configuration import read_config
from neurframe_cli.errors import NeurframeError
from neurframe_cli.field.checkpoint import TrainingState, checkpoint_from_bytes, state_to_bytes
from neurframe_cli.field.energy_terms import Normalization
from neurframe_cli.field.field_file import NeuralField, field_to_bytes, read_field
from neurframe_cli.field.fra import read_frames, write_fra
from neurframe_cli.field.network import Architecture, FieldNetwork
from neurframe_cli.mesh.arrays import Surface, TetMesh, as_surface
from neurframe_cli.mesh.check_tets import checked_tets
from neurframe_cli.mesh.features import features_by_angle, read_features, write_features
from neurframe_cli.mesh.read_cells import CellMesh, read_cells
from neurframe_cli.mesh.read_points import read_points
from neurframe_cli.mesh.tet_adjacency import tet_adjacency
from neurframe_cli.mesh.write_cells import write_cells
from neurframe_cli.mesh.write_mesh import write_surface, write_tets
from neurframe_cli.pipeline.executables import find_executable
from neurframe_cli.pipeline.manifest import Manifest, StageRecord, read_manifest, write_manifest
from neurframe_cli.pipeline.quad_source import read_crosses

MEMORY_LIMIT = 4 << 30
CUBE_V = np.array([[x, y, z] for z in (0.0, 1.0) for y in (0.0, 1.0) for x in (0.0, 1.0)])
CUBE_T = np.array([[0, 1, 2, 4], [1, 3, 2, 7], [1, 4, 5, 7], [2, 6, 4, 7], [1, 2, 4, 7]])


@dataclass(frozen=True)
class Target:
    """prepare(folder) writes good files there; `damage` is the one to damage; read(folder) reads it as we do."""

    name: str
    damage: str
    prepare: Callable[[Path], None]
    read: Callable[[Path], object]


def _cube() -> tuple[TetMesh, Surface]:
    tets, _ = checked_tets(CUBE_V, CUBE_T)
    return tets, as_surface(tets.V, tet_adjacency(tets.T).boundary_faces)


def _write_frames(folder: Path) -> None:
    write_fra(folder / "tets.fra", np.tile(np.eye(3), (5, 1, 1)))


def _write_tets(folder: Path) -> None:
    tets, surface = _cube()
    features = features_by_angle(tets.V, surface.F, 45.0)
    write_tets(folder / "tets.mesh", tets, features)
    write_features(folder / "features.json", features)
    _write_frames(folder)


def _write_crosses(folder: Path) -> None:
    _, surface = _cube()
    corners = surface.V[surface.F]
    first = corners[:, 1] - corners[:, 0]
    normals = np.cross(first, corners[:, 2] - corners[:, 0])
    second = np.cross(normals, first)
    crosses = np.stack([v / np.linalg.norm(v, axis=1, keepdims=True) for v in (first, second)], axis=1)
    write_surface(folder / "surface.obj", surface)
    np.savetxt(folder / "crosses.txt", crosses.reshape(-1, 6))
    np.savetxt(folder / "sizing.txt", np.ones(len(surface.V)))
    np.savez(folder / "cross.npz", V=surface.V, F=surface.F, crosses=crosses)


def _write_quad_map(folder: Path) -> None:
    """A square of two triangles, three cells wide."""
    uv = "vt 0 0\nvt 3 0\nvt 3 3\nvt 0 3\n"
    positions = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
    (folder / "map.obj").write_text(positions + uv + "f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n")


def _write_hex_map(folder: Path) -> None:
    """The cube of five tets, two cells wide."""
    tets, _ = _cube()
    lines = [str(len(tets.V)), *(" ".join(map(str, p)) for p in tets.V.tolist()), str(len(tets.T))]
    lines += [" ".join(map(str, [*tet.tolist(), *(2 * tets.V[tet]).ravel().tolist()])) for tet in tets.T]
    (folder / "map.hexex").write_text("\n".join(lines) + "\n")


def _write_field(folder: Path) -> None:
    network = FieldNetwork(Architecture(width=8), torch.Generator().manual_seed(0))
    normalization = Normalization(np.zeros(3), 1.0)
    (folder / "field.safetensors").write_bytes(field_to_bytes(NeuralField(network, normalization)))


def _write_checkpoint(folder: Path) -> None:
    network = FieldNetwork(Architecture(width=8), torch.Generator().manual_seed(0))
    (folder / "train.checkpoint").write_bytes(state_to_bytes(TrainingState(network), "key"))


def _resume(path: Path) -> None:
    network = FieldNetwork(Architecture(width=8), torch.Generator().manual_seed(1))
    checkpoint_from_bytes(path.read_bytes()).restore_into(TrainingState(network))


def _write_manifest(folder: Path) -> None:
    record = StageRecord("done", "0" * 64, options={"seed": 0}, outputs={"tets.mesh": "1" * 64})
    write_manifest(folder, Manifest({"tetize": record}))


def _write_cells(kind: str) -> Callable[[Path], None]:
    def write(folder: Path) -> None:
        cells = [[0, 1, 3, 2, 4, 5, 7, 6]] if kind == "hex" else [[0, 1, 3, 2], [4, 5, 7, 6]]
        for extension in ("vtk", "vtu", "mesh") if kind == "hex" else ("obj", "ply", "vtk"):
            write_cells(folder / f"{kind}.{extension}", CellMesh(kind, CUBE_V, np.array(cells)))

    return write


def _program(name: str, *arguments: str) -> Callable[[Path], object]:
    """Runs an executable under limits of CPU time and memory; a failure must be one line and a documented code."""
    executable = find_executable(name)

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_CPU, (PROGRAM_CPU_LIMIT_S, PROGRAM_CPU_LIMIT_S))
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY_LIMIT, MEMORY_LIMIT))

    def run(folder: Path) -> None:
        ended = subprocess.run(
            [executable, *arguments], cwd=folder, capture_output=True, preexec_fn=limit, check=False
        )
        words = [line for line in ended.stderr.splitlines() if not line.startswith(b"progress ")]
        assert ended.returncode in (0, 2, 3, 4), (ended.returncode, words)
        assert b"internal error" not in ended.stderr, words
        if ended.returncode in (2, 3):
            assert len(words) == 1, words
            raise NeurframeError(words[0].decode(errors="replace"))

    return run


def _reader(name: str, read: Callable[[Path], object]) -> Callable[[Path], object]:
    return lambda folder: read(folder / name)


_HEXEX = _program("hexex", "map.hexex", "-o", "out.mesh")
_QEX = _program("qex", "map.obj", "-o", "out.obj")
_MIQ = ("surface.obj", "crosses.txt", "-o", "out.obj", "--scale", "6", "--sizing", "sizing.txt")
_COVER = ("tets.mesh", "tets.fra", "-o", "out.hexex", "--scale", "4", "--features", "features.json")
TARGETS = (
    Target("frames", "tets.fra", _write_frames, _reader("tets.fra", read_frames)),
    Target("features", "features.json", _write_tets, _reader("features.json", read_features)),
    Target("field", "field.safetensors", _write_field, _reader("field.safetensors", read_field)),
    Target(
        "checkpoint",
        "train.checkpoint",
        _write_checkpoint,
        _reader("train.checkpoint", _resume),
    ),
    Target("manifest", "manifest.json", _write_manifest, read_manifest),
    Target(
        "config",
        "neurframe.toml",
        lambda folder: (
            (folder / "neurframe.toml").write_text("[train]\nseed = 3\npreset = 'fast'\n") and None
        ),
        _reader("neurframe.toml", read_config),
    ),
    Target(
        "points",
        "points.txt",
        lambda folder: (folder / "points.txt").write_text("0.5, 0.5 0.5\n# a comment\n1 2 3\n") and None,
        _reader("points.txt", read_points),
    ),
    Target("crosses", "cross.npz", _write_crosses, _reader("cross.npz", read_crosses)),
    *(
        Target(
            f"{kind} {extension}",
            f"{kind}.{extension}",
            _write_cells(kind),
            _reader(f"{kind}.{extension}", read_cells),
        )
        for kind, extensions in {"hex": ("vtk", "vtu", "mesh"), "quad": ("obj", "ply", "vtk")}.items()
        for extension in extensions
    ),
    Target("hexex map", "map.hexex", _write_hex_map, _HEXEX),
    Target("qex map", "map.obj", _write_quad_map, _QEX),
    *(
        Target(f"miq {name}", name, _write_crosses, _program("miq", *_MIQ))
        for name in ("surface.obj", "crosses.txt", "sizing.txt")
    ),
    *(
        Target(f"cubecover {name}", name, _write_tets, _program("cubecover", *_COVER))
        for name in ("tets.mesh", "tets.fra", "features.json")
    ),
)

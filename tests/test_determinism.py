"""The same input, options and versions give the same bytes for every number of threads; a training, the same loss."""

from __future__ import annotations

import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from neurframe_cli.cli.main import run_command_line
from neurframe_cli.field.fra import write_fra
from neurframe_cli.mesh.arrays import Features, Floats, Ints, as_surface
from neurframe_cli.mesh.check_tets import checked_tets
from neurframe_cli.mesh.write_mesh import write_surface, write_tets
from neurframe_cli.pipeline.executables import find_executable
from neurframe_cli.pipeline.manifest import StageRecord, read_manifest

SAMPLES = Path(__file__).parent.parent / "samples"
FROM_FIELD = ("discretize", "quad", "hex")
THREADS = (2, 4)


def outputs(program: str, inputs: list[Path], folder: Path, name: str, threads: int, *options: str) -> bytes:
    """What the executable writes to `name`, which must be complete."""
    target = folder / f"{threads}-{name}"
    words = [find_executable(program), *inputs, "-o", target, "--threads", str(threads), *options]
    subprocess.run(words, check=True, capture_output=True)
    return target.read_bytes()


def torus(n: int) -> tuple[Floats, Ints, Floats]:
    """Vertices, 2 n^2 triangles and crosses along the circles of a torus."""
    a, b = (angle.ravel() for angle in np.meshgrid(*2 * [np.arange(n) * 2 * np.pi / n], indexing="ij"))
    V = np.column_stack([(2 + np.cos(b)) * np.cos(a), (2 + np.cos(b)) * np.sin(a), np.sin(b)])
    i, j = (index.ravel() for index in np.meshgrid(*2 * [np.arange(n)], indexing="ij"))
    p, q = i * n + j, (i + 1) % n * n + j
    r, s = (i + 1) % n * n + (j + 1) % n, i * n + (j + 1) % n
    F = np.concatenate([np.column_stack([p, q, r]), np.column_stack([p, r, s])])
    along = np.column_stack([-np.sin(a), np.cos(a), 0 * a])
    across = np.column_stack([-np.sin(b) * np.cos(a), -np.sin(b) * np.sin(a), np.cos(b)])
    return V, F, np.stack([along, across], axis=1)[np.tile(p, 2)]


def twisted_bar(n: int) -> tuple[Floats, Ints, Floats]:
    """Vertices, 6 n^3 tets and frames of a cube that is twisted about z by half a radian."""
    grid = np.stack(np.meshgrid(*3 * [np.arange(n + 1)], indexing="ij"), axis=-1).reshape(-1, 3)
    corner = np.stack(np.meshgrid(*3 * [np.arange(n)], indexing="ij"), axis=-1).reshape(-1, 3)
    tets = []
    for order in ((0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0)):
        path = np.cumsum([[0, 0, 0], *np.eye(3, dtype=int)[list(order)]], axis=0)
        tets.append((corner[:, None] + path) @ [(n + 1) ** 2, n + 1, 1])
    T = np.concatenate(tets)
    x, y, z = grid.T / n - [[0.5], [0.5], [0.0]]
    V = np.column_stack([x * np.cos(z / 2) - y * np.sin(z / 2), x * np.sin(z / 2) + y * np.cos(z / 2), z])
    angle = z[T].mean(axis=1) / 2
    frames = np.tile(np.eye(3), (len(T), 1, 1))
    frames[:, 0, :2] = np.column_stack([np.cos(angle), -np.sin(angle)])
    frames[:, 1, :2] = np.column_stack([np.sin(angle), np.cos(angle)])
    return V, T, frames


@pytest.fixture(scope="module")
def programs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The inputs of the executables, with more elements than one thread takes at a time (2048)."""
    folder = tmp_path_factory.mktemp("programs")
    V, F, crosses = torus(48)
    write_surface(folder / "surface.obj", as_surface(V, F))
    np.savetxt(folder / "crosses.txt", crosses.reshape(-1, 6))
    V, T, frames = twisted_bar(9)
    write_tets(folder / "tets.mesh", checked_tets(V, T)[0], Features())
    write_fra(folder / "tets.fra", frames)
    return folder


@dataclass(frozen=True)
class Chain:
    """The executable that makes a map of its inputs, and the one that extracts the mesh from it."""

    solver: str
    inputs: tuple[str, str]
    scale: str
    map: str
    extractor: str
    mesh: str


CHAINS = {
    "quads": Chain("miq", ("surface.obj", "crosses.txt"), "25", "map.obj", "qex", "quad.obj"),
    "hexes": Chain("cubecover", ("tets.mesh", "tets.fra"), "12", "map.hexex", "hexex", "hex.mesh"),
}


@pytest.mark.parametrize("chain", CHAINS.values(), ids=CHAINS.keys())
def test_executables(chain: Chain, programs: Path) -> None:
    inputs = [programs / name for name in chain.inputs]
    first_map = programs / f"1-{chain.map}"
    one = outputs(chain.solver, inputs, programs, chain.map, 1, "--scale", chain.scale)
    cells = outputs(chain.extractor, [first_map], programs, chain.mesh, 1)
    for threads in THREADS:
        assert outputs(chain.solver, inputs, programs, chain.map, threads, "--scale", chain.scale) == one
        assert outputs(chain.extractor, [first_map], programs, chain.mesh, threads) == cells


def command(*words: str, threads: int) -> None:
    assert run_command_line([words[0], "--threads", str(threads), "-q", *words[1:]]) == 0, words


def trained(workspace: Path, threads: int) -> Path:
    model = str(SAMPLES / "cube.stl")
    command("tetize", model, "-w", str(workspace), "--edge-length", "0.25", threads=threads)
    command("train", "-w", str(workspace), "--iterations", "30", threads=threads)
    return workspace


def meshed(workspace: Path, threads: int) -> Path:
    command("discretize", "-w", str(workspace), "--no-pictures", "--force", threads=threads)
    command("quad", "-w", str(workspace), "--scale", "8", "--force", threads=threads)
    command("hex", "-w", str(workspace), "--scale", "6", "--force", threads=threads)
    return workspace


def stage_of(workspace: Path, stage: str) -> StageRecord:
    return read_manifest(workspace).stages[stage]


@pytest.fixture(scope="module")
def one(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Everything on one thread."""
    return meshed(trained(tmp_path_factory.mktemp("one") / "cube.neurframe", 1), 1)


@pytest.mark.slow
def test_stages_after_the_field(one: Path, tmp_path: Path) -> None:
    workspace = tmp_path / "copy.neurframe"
    shutil.copytree(one, workspace)
    meshed(workspace, 4)
    for stage in FROM_FIELD:
        assert stage_of(workspace, stage).outputs == stage_of(one, stage).outputs
        assert len(stage_of(one, stage).outputs) > 1


@pytest.mark.slow
def test_tets_and_field(one: Path, tmp_path: Path) -> None:
    """PyTorch splits sums of products among its threads: the same bytes here or not, but the same loss."""
    other = trained(tmp_path / "cube.neurframe", 4)
    assert stage_of(other, "tetize").outputs == stage_of(one, "tetize").outputs
    losses = [stage_of(workspace, "train").report["losses"]["total"] for workspace in (one, other)]
    # measured 4e-8 apart, where a field that has learned nothing has a loss of about one
    assert losses[1] == pytest.approx(losses[0], abs=1e-6)

"""CPU seconds of neurframe-cubecover by step, on tet meshes of growing size: two Markdown tables.

    python benchmarks/parametrization.py [--sizes N ...] [--cells K] [--threads T] [--program PATH]

`cube`: a turned cube of 6 N^3 tets, the frame of every tet in a chart of its own, no singular line.  `cylinder`: the
same tets bent to a round bar whose frames all point the same way: the four singular lines are found by the program.
About K hexes each.  The reference is SciPy's conjugate gradients (Jacobi's preconditioner, to 1e-8) for three Poisson
problems on the vertices of the same tets, timed in the same run; `times` is the whole program, files included, over
that.  The run fails where a map is not valid.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from extraction import grid_rotations, kuhn_grid
from scipy.sparse import coo_matrix, diags
from scipy.sparse.linalg import cg
from scipy.spatial.transform import Rotation

from neurframe_cli.field.fra import write_fra
from neurframe_cli.mesh.arrays import Floats, TetMesh
from neurframe_cli.mesh.medit import write_medit
from neurframe_cli.pipeline.executables import find_executable

SIZES = (6, 12, 24)
TURN = Rotation.from_rotvec([0.3, -0.5, 0.7]).as_matrix()
TOLERANCE = 1e-8
SINGULAR_ARCS = {"cube": 0, "cylinder": 4}


@dataclass(frozen=True)
class Run:
    """One run: statistics of the program, CPU seconds of the whole of it, and its peak MiB."""

    statistics: dict[str, object]
    seconds: float
    peak_mib: float


def cube(n: int) -> tuple[TetMesh, Floats]:
    """A turned cube and its frames (m,3,3), each in a random one of the 24 charts."""
    V, T = kuhn_grid(3, n)
    rotations = grid_rotations(3)
    chosen = np.random.default_rng(1).integers(0, len(rotations), len(T))
    return TetMesh(V @ TURN.T, T), TURN @ rotations[chosen]


def cylinder(n: int) -> tuple[TetMesh, Floats]:
    """A round bar as long as it is wide, and frames (m,3,3) along the axes everywhere.

    A square goes to a disc by (x, y) -> (x sqrt(1 - y^2 / 2), y sqrt(1 - x^2 / 2)).
    """
    V, T = kuhn_grid(3, n)
    x, y, z = (2.0 * V - 1.0).T
    round_bar = np.stack([x * np.sqrt(1.0 - y**2 / 2.0), y * np.sqrt(1.0 - x**2 / 2.0), z], axis=1)
    return TetMesh(round_bar, T), np.tile(np.eye(3), (len(T), 1, 1))


def parametrize(program: Path, mesh: TetMesh, frames: Floats, cells: int, threads: int) -> Run:
    """Run the program; raises RuntimeError with its message where it writes no valid map."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_medit(folder / "tets.mesh", mesh)
        write_fra(folder / "frames.fra", frames)
        command = [program, folder / "tets.mesh", folder / "frames.fra", "-o", folder / "map.hexex"]
        command += ["--target-cells", str(cells), "--threads", str(threads), "--polycube", "never"]
        told = folder / "told"
        with (folder / "said").open("w") as out, told.open("w") as errors:
            child = subprocess.Popen(command, stdout=out, stderr=errors)
            _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        if child.returncode != 0:
            raise RuntimeError(told.read_text().strip().splitlines()[-1])
        statistics = json.loads((folder / "said").read_text())
    return Run(statistics, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024)


def laplacian(mesh: TetMesh) -> coo_matrix:
    """The stiffness matrix (n,n) of linear elements."""
    corners = mesh.V[mesh.T]
    edges = np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2)
    inner = np.linalg.inv(edges)
    gradients = np.concatenate([-inner.sum(axis=1, keepdims=True), inner], axis=1)
    volumes = np.linalg.det(edges) / 6.0
    values = np.einsum("m,mik,mjk->mij", volumes, gradients, gradients)
    rows = np.repeat(mesh.T, 4, axis=1)
    columns = np.tile(mesh.T, (1, 4))
    return coo_matrix((values.ravel(), (rows.ravel(), columns.ravel())), shape=(len(mesh.V),) * 2)


def reference_seconds(mesh: TetMesh) -> float:
    """Three Poisson problems with zeros at the first vertex, whose solutions are random."""
    matrix = laplacian(mesh).tocsr()[1:, 1:]
    solutions: Floats = np.random.default_rng(2).standard_normal((3, matrix.shape[0]))
    start = time.thread_time()  # without threads of a BLAS that wait
    preconditioner = diags(1.0 / matrix.diagonal())
    for solution in solutions:
        found, failed = cg(matrix, matrix @ solution, rtol=TOLERANCE, M=preconditioner)
        if failed or not np.isfinite(found).all():
            raise RuntimeError("the reference does not converge")
    return time.thread_time() - start


def show(kind: str, sizes: list[int], program: Path, cells: int, threads: int) -> bool:
    """Print the table of one kind; False where a map has other singular arcs than it must have."""
    right, head = True, ""
    for n in sizes:
        mesh, frames = cube(n) if kind == "cube" else cylinder(n)
        done = parametrize(program, mesh, frames, cells, threads)
        steps = done.statistics["cpu_seconds"]
        if not head:
            head = f"| {kind}: tets | split | {' | '.join(steps)} | all | us per tet | MiB | times |"
            print(head, "|" + "---|" * head.count(" | ") + "---|", sep="\n")
        times = done.seconds / reference_seconds(mesh)
        print(
            f"| {len(mesh.T):,} | {done.statistics['tets']:,} |",
            " | ".join(f"{seconds:.2f}" for seconds in steps.values()),
            f"| {done.seconds:.2f} | {1e6 * done.seconds / len(mesh.T):.0f} | {done.peak_mib:.0f} | {times:.1f} |",
            flush=True,
        )
        right = right and len(done.statistics["singular_arcs"]) == SINGULAR_ARCS[kind]
    print()
    return right


def main() -> int:
    """Print the tables; exit status 1 where a map has other singular arcs than it must have."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--sizes", nargs="+", type=int, default=list(SIZES))
    parser.add_argument("--cells", type=int, default=8000)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--program", type=Path)
    parser.add_argument("--kinds", nargs="+", choices=list(SINGULAR_ARCS), default=list(SINGULAR_ARCS))
    options = parser.parse_args()
    program = options.program or find_executable("cubecover")
    right = [show(kind, options.sizes, program, options.cells, options.threads) for kind in options.kinds]
    return 0 if all(right) else 1


if __name__ == "__main__":
    sys.exit(main())

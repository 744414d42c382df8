#!/usr/bin/env python3
"""Times neurframe-hexex and neurframe-qex on maps whose hex or quad mesh is known.

    extraction.py --hexex PATH --qex PATH [--threads N] [--large] [--maps FOLDER]

The maps are made here: Kuhn tets of a cube (a square in triangles), inner vertices jittered, u = K x, and every
tet (triangle) in a chart of its own, so that every interior face has a non-trivial transition.  K^3 hexes and
(K+1)^3 vertices (K^2 and (K+1)^2) must come out, or the run fails.  --maps FOLDER adds the .hexex files of a folder.
Seconds are CPU seconds of the whole program, reading and writing included; for hexes those without files follow, and
beside them what HexHex and HexEx took for maps of the same kind on another day (they were timed without files, too).
`fit` at the end is the least-squares cost per tet and per hex (per triangle and per quad) over the rows above it.
"""

import argparse
import itertools
import json
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

CUBES = [(6, 10), (6, 22), (12, 22), (24, 22), (6, 46), (12, 46), (24, 46), (6, 100), (24, 100)]
LARGE = [(48, 46), (48, 100)]
SQUARES = [(30, 100), (100, 100), (100, 316), (300, 316), (100, 1000), (300, 1000)]


# CPU seconds and peak MB of HexHex and HexEx by divisions and cells of the cube, every tet in a chart of its own; None:
# not run.  One thread of a loaded machine with two cores, to be taken as +-30 %.
PEERS = {
    (6, 10): (0.024, 10, 0.298, 18),
    (6, 22): (0.055, 17, 3.23, 134),
    (12, 22): (0.126, 30, 3.24, 144),
    (24, 22): (0.416, 144, 4.24, 221),
    (12, 46): (0.377, 91, 27.9, 1157),
    (24, 46): (0.870, 182, 26.8, 1233),
    (6, 100): (2.00, 686, None, None),
    (24, 100): (3.75, 797, None, None),
    (48, 46): (3.42, 980, None, None),
    (48, 100): (7.98, 1509, None, None),
}


@dataclass(frozen=True)
class Row:
    """One run: sizes, CPU seconds with files and without, peak MiB, and whether the counts were those expected."""

    name: str
    simplices: int
    cells: int
    vertices: int
    seconds: float
    bare_seconds: float
    peak_mib: float
    complete: bool


def grid_rotations(dimension: int) -> Floats:
    """The rotations of the integer grid, (4,2,2) or (24,3,3)."""
    found = []
    for axes in itertools.permutations(range(dimension)):
        for signs in itertools.product((1.0, -1.0), repeat=dimension):
            matrix = np.zeros((dimension, dimension))
            matrix[range(dimension), axes] = signs
            if np.linalg.det(matrix) > 0:
                found.append(matrix)
    return np.array(found)


def kuhn_grid(dimension: int, n: int) -> tuple[Floats, Ints]:
    """The unit square (cube) in 2 n^2 triangles (6 n^3 tets), positively oriented: V (m,d), S (k,d+1)."""
    shape = (n + 1,) * dimension
    index = np.arange((n + 1) ** dimension).reshape(shape)
    simplices = []
    for axes in itertools.permutations(range(dimension)):
        corner = np.zeros(dimension, int)
        path = []
        for axis in (None, *axes):
            if axis is not None:
                corner[axis] += 1
            window = tuple(slice(o, n + o) for o in corner)
            path.append(index[window].ravel())
        odd = np.linalg.det(np.eye(dimension)[list(axes)]) < 0
        simplices.append(np.stack(path, 1)[:, [1, 0, *range(2, dimension + 1)] if odd else slice(None)])
    V = np.stack(np.meshgrid(*[np.arange(n + 1) / n] * dimension, indexing="ij"), -1).reshape(-1, dimension)
    return V, np.concatenate(simplices)


def turned_map(dimension: int, n: int, cells: int, rng: np.random.Generator) -> tuple[Floats, Ints, Floats]:
    """A jittered grid and its parameters (k,d+1,d), every simplex in a random chart."""
    V, S = kuhn_grid(dimension, n)
    inner = np.all((V > 0) & (V < 1), 1)
    V[inner] += (rng.random((int(inner.sum()), dimension)) - 0.5) * 0.2 / n
    V = np.where((V > 0) & (V < 1), np.round(V * 2**20) / 2**20, V)
    rotations = grid_rotations(dimension)
    R = rotations[rng.integers(0, len(rotations), len(S))]
    shift = rng.integers(-8, 9, (len(S), 1, dimension))
    return V, S, np.einsum("nij,nkj->nki", R, (V * cells)[S]) + shift


def write_hexex(path: Path, V: Floats, T: Ints, U: Floats) -> None:
    """Writes the text format of HexEx."""
    with path.open("w") as out:
        out.write(f"{len(V)}\n")
        np.savetxt(out, V, fmt="%.17g")
        out.write(f"{len(T)}\n")
        np.savetxt(out, np.hstack([T, U.reshape(len(T), 12)]), fmt=["%d"] * 4 + ["%.17g"] * 12)


def write_obj(path: Path, V: Floats, F: Ints, U: Floats) -> None:
    """Writes an OBJ with one vt per corner."""
    with path.open("w") as out:
        np.savetxt(out, np.hstack([V, np.zeros((len(V), 1))]), fmt="v %.17g %.17g %.17g")
        np.savetxt(out, U.reshape(-1, 2), fmt="vt %.17g %.17g")
        corner = np.arange(3 * len(F)).reshape(-1, 3) + 1
        np.savetxt(out, np.stack([F + 1, corner], -1).reshape(-1, 6), fmt="f %d/%d %d/%d %d/%d")


def run(program: Path, map_file: Path, output: Path, threads: int, cell: str, simplex: str) -> Row:
    """Runs one extraction; raises RuntimeError with its message when it writes nothing."""
    command = [str(program), str(map_file), "-o", str(output), "--threads", str(threads)]
    said, told = output.with_suffix(".out"), output.with_suffix(".err")
    with said.open("w") as out, told.open("w") as err:
        child = subprocess.Popen(command, stdout=out, stderr=err)
        _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode not in (0, 4):
        raise RuntimeError(told.read_text().strip().splitlines()[-1])
    stats = json.loads(said.read_text())
    steps = stats["cpu_seconds"]
    return Row(
        map_file.stem,
        stats[simplex],
        stats[cell],
        stats["vertices"],
        usage.ru_utime + usage.ru_stime,
        steps["exact_map"] + steps["extract"],
        usage.ru_maxrss / 1024,
        stats["complete"],
    )


def show(rows: list[Row], simplex: str, cell: str) -> None:
    """Prints the table and the fitted cost per simplex and per cell."""
    print(
        f"| map | {simplex} | {cell} | vertices | CPU s | us per cell | complete |\n|---|---|---|---|---|---|---|"
    )
    for row in rows:
        each = 1e6 * row.seconds / max(row.cells, 1)
        size = f"{row.simplices:,} | {row.cells:,} | {row.vertices:,}"
        print(f"| {row.name} | {size} | {row.seconds:.3f} | {each:.2f} | {'yes' if row.complete else 'NO'} |")
    if len(rows) > 2:
        sizes = np.array([[row.simplices, row.cells] for row in rows], float)
        seconds = np.array([row.seconds for row in rows])
        weight = 1.0 / np.maximum(seconds, 0.01)
        cost = np.linalg.lstsq(sizes * weight[:, None], seconds * weight, rcond=None)[0] * 1e6
        print(f"fit: {cost[0]:.2f} us per {simplex[:-1]} + {cost[1]:.2f} us per cell\n")


def show_beside_peers(rows: list[Row]) -> None:
    """Prints seconds without files and peak memory next to those of HexHex and HexEx."""
    print("| tets | hexes | ours s | MiB | HexHex s | MB | HexEx s | MB |\n|---|---|---|---|---|---|---|---|")
    for (n, cells), row in zip(CUBES + LARGE, rows, strict=False):
        peers = PEERS.get((n, cells), (None,) * 4)
        shown = " | ".join("" if number is None else f"{number:g}" for number in peers)
        size = f"{row.simplices:,} | {row.cells:,}"
        print(f"| {size} | {row.bare_seconds:.3f} | {row.peak_mib:.0f} | {shown} |")
    print()


def made_rows(
    program: Path, dimension: int, sizes: list[tuple[int, int]], threads: int, folder: Path
) -> tuple[list[Row], bool]:
    """Makes and runs the maps of one dimension; False when a count is wrong."""
    names = ("quads", "triangles") if dimension == 2 else ("hexes", "tets")
    rng = np.random.default_rng(1)
    rows, right = [], True
    for n, cells in sizes:
        V, S, U = turned_map(dimension, n, cells, rng)
        path = folder / (f"n{n}_k{cells}" + (".obj" if dimension == 2 else ".hexex"))
        (write_obj if dimension == 2 else write_hexex)(path, V, S, U)
        output = folder / ("out.obj" if dimension == 2 else "out.mesh")
        row = run(program, path, output, threads, *names)
        right = right and (row.cells, row.vertices) == (cells**dimension, (cells + 1) ** dimension)
        rows.append(row)
        path.unlink()
    return rows, right


def main() -> int:
    """Prints the tables; exit status 1 when a count is not the expected one."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--hexex", type=Path)
    parser.add_argument("--qex", type=Path)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--large", action="store_true", help="adds cubes of 663,552 tets")
    parser.add_argument("--maps", type=Path, help="folder with .hexex files to run as well")
    options = parser.parse_args()
    right = True
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if options.hexex:
            cubes = CUBES + (LARGE if options.large else [])
            rows, right = made_rows(options.hexex, 3, cubes, options.threads, folder)
            show(rows, "tets", "hexes")
            show_beside_peers(rows)
            real = []
            for path in sorted(options.maps.glob("*.hexex")) if options.maps else []:
                try:
                    real.append(
                        run(options.hexex, path, folder / "out.mesh", options.threads, "hexes", "tets")
                    )
                except RuntimeError as error:
                    print(f"{path.name}: {error}")
            if real:
                show(real, "tets", "hexes")
        if options.qex:
            rows, right_quads = made_rows(options.qex, 2, SQUARES, options.threads, folder)
            show(rows, "triangles", "quads")
            right = right and right_quads
    return 0 if right else 1


if __name__ == "__main__":
    sys.exit(main())

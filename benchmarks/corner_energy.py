"""The corner energy and its gradient, by the loops of native/smooth and by whole arrays of NumPy: a Markdown table.

    python benchmarks/corner_energy.py [--threads N ...]

The reference is the formula of mesh/optimize/corner_energy.py, each of its operations over all corners at once.  Hexes
of a cube, each vertex moved at random; wall milliseconds, the least of ten; ratio: reference over loops; difference: of
the gradients, in parts of the largest.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.sparse import coo_matrix

from neurframe_cli.mesh.arrays import Floats, Ints
from neurframe_cli.mesh.optimize.cell_kind import HEXES, target_lengths
from neurframe_cli.mesh.optimize.corner_energy import CornerEnergy, EnergyWeights
from neurframe_cli.process.threads import VARIABLE

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from smooth_shapes import cube_hexes, jitter

WEIGHTS = EnergyWeights(0.1, 2.0, 1e-3)
REPEATS = 10
HEADER = "| hexes | threads | arrays ms | loops ms | ratio | difference |\n|---|---|---|---|---|---|"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    cores = len(os.sched_getaffinity(0))
    parser.add_argument("--threads", nargs="+", type=int, default=sorted({1, cores}))
    arguments = parser.parse_args()
    print(HEADER)
    for n in (10, 20, 40):
        compare(n, arguments.threads)


def compare(n: int, thread_counts: list[int]) -> None:
    """Print the rows of n x n x n hexes."""
    shape = cube_hexes(n)
    X = jitter(shape.V, 0.2 / n, 0)
    corners = shape.cells[:, HEXES.corners].reshape(-1, 4)
    lengths = target_lengths(X, shape.cells, HEXES, 0.5, rounds=5).reshape(len(corners), 3)
    energy = CornerEnergy(len(X), corners[:, 0], corners[:, 1:], lengths)
    by_arrays = arrays(len(X), corners, lengths)
    reference, expected = timed(lambda: by_arrays(X))
    for threads in thread_counts:
        os.environ[VARIABLE] = str(threads)
        seconds, found = timed(lambda: energy.evaluate(X, None, WEIGHTS))
        difference = np.abs(found[1] - expected[1]).max() / np.abs(expected[1]).max()
        print(
            f"| {n**3:,} | {threads} | {1e3 * reference:.2f} | {1e3 * seconds:.2f} "
            f"| {reference / seconds:.1f} | {difference:.0e} |",
            flush=True,
        )


def timed(work: Callable[[], tuple[float, Floats]]) -> tuple[float, tuple[float, Floats]]:
    """The least wall seconds of some calls, and what they return."""
    least = np.inf
    for _ in range(REPEATS):
        start = time.perf_counter()
        result = work()
        least = min(least, time.perf_counter() - start)
    return least, result


def arrays(n: int, corners: Ints, lengths: Floats) -> Callable[[Floats], tuple[float, Floats]]:
    """Energy of corners (m,4) with target lengths (m,3) and its gradient (n,3), as a function of positions (n,3)."""
    edges = np.arange(lengths.size)
    ends = coo_matrix((1.0 / lengths.ravel(), (corners[:, 1:].ravel(), edges)), (n, len(edges)))
    origins = coo_matrix((1.0 / lengths.ravel(), (np.repeat(corners[:, 0], 3), edges)), (n, len(edges)))
    scatter = (ends - origins).tocsr()

    def evaluate(x: Floats) -> tuple[float, Floats]:
        S = (x[corners[:, 1:]] - x[corners[:, :1]]) / lengths[..., None]
        cofactors = np.stack([np.cross(S[:, (k + 1) % 3], S[:, (k + 2) % 3]) for k in range(3)], axis=1)
        D = np.einsum("md,md->m", S[:, 0], cofactors[:, 0])
        root = np.sqrt(D**2 + WEIGHTS.epsilon**2)
        chi = (D + root) / 2
        by_trace = (1.0 - WEIGHTS.size) / (3.0 * chi ** (2 / 3))
        shape = by_trace * np.einsum("mkd,mkd->m", S, S)
        size = WEIGHTS.size * (1.0 + D**2) / (2.0 * chi)
        by_D = WEIGHTS.size * D / chi - (2 / 3 * shape + size) / root
        phi = shape + size
        outer = phi ** (WEIGHTS.power - 1.0)
        by_S = outer[:, None, None] * (2.0 * by_trace[:, None, None] * S + by_D[:, None, None] * cofactors)
        return float((outer * phi).sum()) / WEIGHTS.power, np.asarray(scatter @ by_S.reshape(-1, 3))

    return evaluate


if __name__ == "__main__":
    main()

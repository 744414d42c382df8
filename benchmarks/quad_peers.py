"""Our quads beside QuadriFlow's and Instant Meshes', on the same surfaces in the same run.

    python benchmarks/quad_peers.py --target-faces 6000 WORKSPACE...

A WORKSPACE has been through `neurframe discretize`; all tools get the triangles of its cross.npz and are measured
against its surface.ply.  The peers are the packages pyquadriflow and pynanoinstantmeshes, in a Python of their own that
--peers or NEURFRAME_PEERS_PYTHON names; a peer that is not installed there is said and left out:

    python -m venv peers && peers/bin/pip install numpy pyquadriflow pynanoinstantmeshes

Columns: CPU seconds of one thread (ours: map + extraction, then smoothing; `surface` includes its cross field, the
training of the neural one is not counted), quads, other polygons, open or non-manifold edges, vertices inside of
valence 3 / 5 / other, inverted quads, worst and mean scaled Jacobian, Hausdorff distance in percent of the diagonal
from the surface to the quads and back, share of the sharp edges (over 45 degrees) that edges follow within 0.1 edge
lengths.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

COLUMNS = (
    "model | tool | CPU s | smoothing s | quads | other | bad edges | 3 / 5 / other | inverted | SJ worst | SJ mean",
    "to quads % | back % | recall",
)
HEADER = f"| {' | '.join(COLUMNS)} |\n{'|---' * 14}|"
PEERS = ("QuadriFlow", "QuadriFlow sharp", "Instant Meshes", "Instant Meshes crease")
SAMPLES = 50_000


@dataclass(frozen=True)
class Result:
    """V (n,3), Q (m,4); other: polygons that are no quads; seconds; smoothing seconds, ours only."""

    V: Any
    Q: Any
    other: int
    seconds: float
    smoothing: float | None = None


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("workspaces", nargs="+", type=Path)
    parser.add_argument("--target-faces", type=int, default=6000)
    parser.add_argument("--peers", default=os.environ.get("NEURFRAME_PEERS_PYTHON", sys.executable))
    arguments = parser.parse_args()
    print(HEADER, flush=True)
    for workspace in arguments.workspaces:
        for line in rows(workspace, arguments.target_faces, arguments.peers):
            print(line, flush=True)


def rows(workspace: Path, target: int, peers: str) -> list[str]:
    from neurframe_cli.pipeline.quad_source import read_crosses

    carrier = read_crosses(workspace / "cross.npz")
    lines = [
        shown(workspace, f"neurframe, {field} field", ours(workspace, carrier, field, target))
        for field in ("neural", "surface")
    ]
    for tool in PEERS:
        result = peer(peers, tool, carrier.surface, target)
        name = workspace.name.removesuffix(".neurframe")
        lines.append(
            f"| {name} | {tool} | {result} |" if isinstance(result, str) else shown(workspace, tool, result)
        )
    return lines


def ours(workspace: Path, carrier: Any, field: str, target: int) -> Result | str:
    """Map, extraction and smoothing, as `neurframe quad` does them."""
    from neurframe_cli.field.surface_cross_field import surface_cross_field
    from neurframe_cli.mesh.features import features_by_angle
    from neurframe_cli.mesh.read_cells import read_cells
    from neurframe_cli.mesh.read_surface import read_surface
    from neurframe_cli.mesh.write_mesh import write_surface
    from neurframe_cli.pipeline.executables import find_executable
    from neurframe_cli.stages.smooth_quads import QUAD_OPTIONS, smooth_quads

    started, V, F = time.process_time(), carrier.surface.V, carrier.surface.F
    crosses = carrier.crosses
    if field == "surface":
        crosses = surface_cross_field(V, F, features_by_angle(V, F, 45.0).edges)
    seconds = time.process_time() - started
    with tempfile.TemporaryDirectory() as folder:
        files = [str(Path(folder) / name) for name in ("surface.obj", "crosses.txt", "map.obj", "quads.obj")]
        write_surface(Path(files[0]), carrier.surface)
        np.savetxt(files[1], crosses.reshape(-1, 6), fmt="%.17g")
        size = ["--target-faces", str(target), "--threads", "1"]
        before = children_seconds()
        subprocess.run(
            [find_executable("miq"), files[0], files[1], "-o", files[2], *size],
            capture_output=True,
            check=False,
        )
        subprocess.run(
            [find_executable("qex"), files[2], "-o", files[3], "--threads", "1"],
            capture_output=True,
            check=False,
        )
        seconds += children_seconds() - before
        raw = read_cells(Path(files[3]))
    model = read_surface(workspace / "surface.ply")
    features = features_by_angle(model.V, model.F, 45.0)
    started = time.process_time()
    smoothed = smooth_quads(raw.V, raw.cells, model, features, QUAD_OPTIONS)
    return Result(smoothed.V, raw.cells, 0, seconds, time.process_time() - started)


def children_seconds() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def peer(python: str, tool: str, surface: Any, target: int) -> Result | str:
    """The tool's quads, or why there are none."""
    with tempfile.TemporaryDirectory() as folder:
        given, made = Path(folder) / "given.npz", Path(folder) / "made.npz"
        np.savez(given, V=surface.V, F=surface.F)
        command = [python, __file__, "--child", tool, str(target), str(given), str(made)]
        ended = subprocess.run(command, capture_output=True, text=True, check=False, timeout=3600)
        if not made.exists():
            last = (ended.stderr or ended.stdout).strip().splitlines()
            return f"failed with {ended.returncode}: {last[-1] if last else 'silent'}"
        with np.load(made) as stored:
            Q = stored["Q"].astype(np.int64)
            proper = (np.diff(np.sort(Q, axis=1), axis=1) != 0).all(axis=1)
            V = stored["V"].astype(np.float64)
            return Result(V, Q[proper], int((~proper).sum()), float(stored["seconds"]))


def child(tool: str, target: int, given: str, made: str) -> None:
    """Runs in the Python of the peers, where nothing of ours is installed."""
    with np.load(given) as stored:
        V, F = stored["V"], stored["F"]
    # both work in float32: centred, so that no digits are lost to the place
    centre = V.mean(axis=0)
    points, started = (V - centre).astype(np.float32), time.process_time()
    if tool.startswith("QuadriFlow"):
        from pyQuadriFlow.pyQuadriFlow import pyquadriflow

        sharp = tool.endswith("sharp")
        found = pyquadriflow(target, 0, points.tolist(), F.tolist(), sharp, False, False, False, False)
        vertices, quads = np.array(found["vertices"]), np.array(found["faces"])
    else:
        from pynanoinstantmeshes import remesh

        # it makes four quads for every vertex that is asked for
        crease = 40.0 if tool.endswith("crease") else 0.0
        vertices, quads = remesh(
            points, F.astype(np.uint32), target // 4, creaseAngle=crease, deterministic=True
        )
    seconds = time.process_time() - started
    np.savez(made, V=np.asarray(vertices, np.float64) + centre, Q=quads, seconds=seconds)


def shown(workspace: Path, tool: str, result: Result | str) -> str:
    from neurframe_cli.mesh.arrays import Surface
    from neurframe_cli.mesh.features import features_by_angle
    from neurframe_cli.mesh.optimize.simplex_tree import SimplexTree
    from neurframe_cli.mesh.quality.distance import sample_surface
    from neurframe_cli.mesh.quality.feature_recall import feature_recall
    from neurframe_cli.mesh.quality.polygons import triangulated, unique_edges, valences
    from neurframe_cli.mesh.quality.scaled_jacobian import quad_scaled_jacobians
    from neurframe_cli.mesh.read_surface import read_surface

    name = workspace.name.removesuffix(".neurframe")
    if isinstance(result, str):
        return f"| {name} | {tool} | {result} |"
    model, rng = read_surface(workspace / "surface.ply"), np.random.default_rng(0)
    diagonal = float(np.linalg.norm(np.ptp(model.V, axis=0)))
    edges, use = unique_edges(result.Q)
    inside = np.setdiff1d(np.unique(edges), edges[use != 2])
    found = valences(edges, len(result.V))[inside]
    three, five = int((found == 3).sum()), int((found == 5).sum())
    other = int((found != 4).sum()) - three - five
    quads = Surface(result.V, triangulated(result.Q))
    to_quads = SimplexTree(quads.V, quads.F).distances(sample_surface(model, SAMPLES, rng)).max() / diagonal
    back = SimplexTree(model.V, model.F).distances(sample_surface(quads, SAMPLES, rng)).max() / diagonal
    jacobians = quad_scaled_jacobians(result.V, result.Q).min(axis=1)
    length = float(np.median(np.linalg.norm(result.V[edges[:, 0]] - result.V[edges[:, 1]], axis=1)))
    features = features_by_angle(model.V, model.F, 45.0).edges
    recall = feature_recall(model.V, features, result.V, edges, 0.1 * length)
    smoothing = "-" if result.smoothing is None else f"{result.smoothing:.1f}"
    return (
        f"| {name} | {tool} | {result.seconds:.1f} | {smoothing} | {len(result.Q)} | {result.other} "
        f"| {int((use != 2).sum())} | {three} / {five} / {other} | {int((jacobians <= 0).sum())} "
        f"| {jacobians.min():.3f} | {jacobians.mean():.3f} | {100 * to_quads:.2f} | {100 * back:.2f} "
        f"| {'-' if recall is None else f'{recall:.3f}'} |"
    )


if __name__ == "__main__":
    if sys.argv[1:2] == ["--child"]:
        child(sys.argv[2], int(sys.argv[3]), sys.argv[4], sys.argv[5])
    else:
        main()

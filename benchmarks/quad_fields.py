"""Quads from three cross fields of the same tets: the `fast` and the `paper` preset, and the surface alone.

    python benchmarks/quad_fields.py --target-faces 6000 --iterations 10000 WORKSPACE...

Each WORKSPACE (made by `neurframe tetize`) is copied; nothing in it is changed.  --iterations are those of the paper
preset, whose own number is 10,000.  The crosses lie on the same triangles for all three.  Columns: CPU seconds of
training, irregular vertices, inverted quads, worst and mean scaled Jacobian, Hausdorff distance in percent of the
bounding-box diagonal, share of the sharp edges that edges follow.
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from neurframe_cli.pipeline.manifest import read_manifest

HEADER = """| model | field | train CPU s | quads | irregular | inverted | SJ worst | SJ mean | Hausdorff % | recall |
|---|---|---|---|---|---|---|---|---|---|"""
TETS = ("surface.ply", "tets.mesh", "features.json")


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("workspaces", nargs="+", type=Path)
    parser.add_argument("--target-faces", type=int, default=6000)
    parser.add_argument("--iterations", type=int, default=10_000)
    arguments = parser.parse_args()
    print(HEADER, flush=True)
    for source in arguments.workspaces:
        for name, training in fields(arguments.iterations).items():
            with tempfile.TemporaryDirectory() as folder:
                print(row(source, Path(folder), name, training, arguments.target_faces), flush=True)


def fields(iterations: int) -> dict[str, list[str] | None]:
    """The options of `neurframe train` by name of the field; None for the one that needs no training."""
    return {
        "fast": ["--preset", "fast"],
        f"paper, {iterations} iterations": ["--preset", "paper", "--iterations", str(iterations)],
        "surface": None,
    }


def row(source: Path, workspace: Path, field: str, training: list[str] | None, target: int) -> str:
    """The table row of one field, or what went wrong with it."""
    name = source.name.removesuffix(".neurframe")
    for file in TETS:
        shutil.copyfile(source / file, workspace / file)
    quad = ["quad", "--target-faces", str(target), "--no-pictures"]
    stages = [[*quad, "--field", "surface"]]
    if training is not None:
        stages = [["train", *training], ["discretize", "--no-pictures"], quad]
    for stage in stages:
        command = [sys.executable, "-m", "neurframe_cli", *stage, "-w", workspace, "-q", "--threads", "1"]
        ended = subprocess.run(command, stderr=subprocess.PIPE, text=True, check=False)
        if ended.returncode not in (0, 4):
            return f"| {name} | {field} | {stage[0]}: {ended.stderr.strip()} |"
    return shown(name, field, workspace)


def shown(name: str, field: str, workspace: Path) -> str:
    done = read_manifest(workspace).stages
    if "mesh" not in done["quad"].report:
        return f"| {name} | {field} | no quads: {done['quad'].error} |"
    mesh = done["quad"].report["mesh"]
    seconds = f"{done['train'].cpu_seconds:.0f}" if "train" in done else "-"
    recall = mesh["feature_recall"]
    return (
        f"| {name} | {field} | {seconds} | {mesh['cells']} | {mesh['irregular_vertices']} | {mesh['inverted']} "
        f"| {mesh['min_scaled_jacobian']:.3f} | {mesh['mean_scaled_jacobian']:.3f} | {100 * mesh['hausdorff']:.2f} "
        f"| {'-' if recall is None else f'{recall:.3f}'} |"
    )


if __name__ == "__main__":
    main()

"""Train on many models and print one table row each.

    python benchmarks/train_table.py --edge-length 0.025 --into /tmp/fields MODEL...
    python benchmarks/train_table.py --preset paper --into /tmp/fields MODEL...

Each model gets a workspace in the folder --into; what is there already is not done again.  Columns: tets, loss of the
discrete floor and of the network, the gap, singular edges and their length in bounding-box diagonals, compound edges,
mean deviation of normals in degrees, CPU seconds of training.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path
from typing import Any

from neurframe_cli.pipeline.manifest import read_manifest

COLUMNS = (
    "| model | preset | tets | floor | loss | gap | singular edges | length | compound | normals | CPU s |"
)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("models", nargs="+", type=Path)
    parser.add_argument("--into", type=Path, required=True)
    parser.add_argument("--edge-length", default="0.025")
    parser.add_argument("--preset", default="fast")
    parser.add_argument("--threads", default="1")
    arguments = parser.parse_args()
    print(COLUMNS, "|---" * COLUMNS.count("| ") + "|", sep="\n", flush=True)
    for model in arguments.models:
        print(row(model, arguments), flush=True)


def row(model: Path, arguments: argparse.Namespace) -> str:
    """The table row of one model, or what went wrong with it."""
    tets = arguments.into / f"{model.stem}-{arguments.edge_length}"
    workspace = arguments.into / f"{model.stem}-{arguments.edge_length}-{arguments.preset}"
    common = ["-q", "--threads", arguments.threads]
    failed = neurframe("tetize", model, "-w", tets, "--edge-length", arguments.edge_length, *common)
    if failed:
        return f"| {model.stem} | tetize: {failed} |"
    workspace.mkdir(exist_ok=True)
    for name in ("surface.ply", "tets.mesh", "features.json"):
        if not (workspace / name).exists():
            (workspace / name).hardlink_to(tets / name)
    failed = neurframe("train", "-w", workspace, "--preset", arguments.preset, *common)
    if failed:
        return f"| {model.stem} | train: {failed} |"
    return shown(model.stem, arguments.preset, read_manifest(workspace).stages["train"].report)


def neurframe(*words: object) -> str:
    """Run a command; its error line, empty where it succeeded."""
    command = [sys.executable, "-m", "neurframe_cli", *map(str, words)]
    ended = subprocess.run(command, stderr=subprocess.PIPE, text=True, check=False)
    return "" if ended.returncode == 0 else f"exit {ended.returncode}: {ended.stderr.strip()}"


def shown(name: str, preset: str, report: dict[str, Any]) -> str:
    floor, gap = report["discrete_floor"], report["above_floor"]
    return (
        f"| {name} | {preset} | {report['tets']} | {'-' if floor is None else f'{floor:.5f}'} "
        f"| {report['losses']['total']:.5f} | {'-' if gap is None else f'{gap:+.2%}'} | {report['singular_edges']} "
        f"| {report['singular_length']:.3f} | {report['compound_edges']} | {report['normal_deg_mean']:.2f} "
        f"| {report['cpu_seconds']:.1f} |"
    )


if __name__ == "__main__":
    main()

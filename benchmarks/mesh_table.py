"""From tet meshes to quad or hex meshes on many models: what came of each, judged by another program as well.

    python benchmarks/tetize_table.py FOLDER... --output tets --keep WORKSPACES
    python benchmarks/mesh_table.py quad WORKSPACES --output quads --checker "python check_mesh.py"

Every workspace is trained and discretized (skipped where that is done) and meshed; one JSON line each goes to
OUTPUT.jsonl, the table to OUTPUT.md.  What is in the lines already is not done again.  CHECKER is called as
`CHECKER MESH --input SURFACE --json`; it must exit with 0 exactly where the mesh is valid.
"""

from __future__ import annotations

import argparse
import json
import shlex
import sys
from collections import Counter
from pathlib import Path
from typing import Any

from neurframe_cli.errors import NeurframeError
from neurframe_cli.pipeline.manifest import read_manifest
from neurframe_cli.process import run_child

RESULT = {"quad": "quad.obj", "hex": "hex.vtk"}
COLUMNS = (
    "model",
    "outcome",
    "checker",
    "cells",
    "irregular",
    "worst_sj",
    "mean_sj",
    "hausdorff",
    "recall",
    "train_cpu_s",
    "mesh_cpu_s",
    "words",
)


def main() -> int:
    options = _arguments()
    lines = options.output.with_suffix(".jsonl")
    known = {row["model"] for row in _rows(lines)}
    with lines.open("a", encoding="utf-8") as out:
        for workspace in sorted(options.workspaces.glob("*.neurframe")):
            if workspace.stem not in known and (workspace / "tets.mesh").is_file():
                row = _row(workspace, options)
                out.write(json.dumps(row) + "\n")
                out.flush()
                print(" | ".join(str(row.get(column, "")) for column in COLUMNS), flush=True)
    options.output.with_suffix(".md").write_text(_markdown(_rows(lines)), encoding="utf-8")
    return 0


def _row(workspace: Path, options: argparse.Namespace) -> dict[str, Any]:
    """Runs the stages that are missing; `outcome` is ok, or the stage that failed and its exit code."""
    row: dict[str, Any] = {"model": workspace.stem, "outcome": "ok", "words": ""}
    limits = ["--threads", str(options.threads), "-q", "-w", workspace]
    for stage, extra in (
        ("train", []),
        ("discretize", ["--no-pictures"]),
        (options.kind, _mesh_options(options)),
    ):
        if stage != options.kind and _is_done(workspace, stage):
            continue
        command = [sys.executable, "-m", "neurframe_cli", stage, *limits, *extra]
        try:
            ended = run_child(command, name=stage, timeout_s=options.timeout, accept=range(256))
        except NeurframeError as error:
            return row | {"outcome": f"{stage}: no end", "words": str(error)}
        if ended.returncode != 0:
            row |= {"outcome": f"{stage}: {ended.returncode}", "words": " ".join(ended.last_lines)[-300:]}
            break
    return row | _numbers(workspace, options.kind) | _checked(workspace, options)


def _is_done(workspace: Path, stage: str) -> bool:
    stages = read_manifest(workspace).stages
    return stage in stages and stages[stage].status == "done"


def _mesh_options(options: argparse.Namespace) -> list[str]:
    return ["--no-pictures", *(["--scale", str(options.scale)] if options.scale else [])]


def _numbers(workspace: Path, kind: str) -> dict[str, Any]:
    """What the manifest says of the mesh, also of one that is not valid."""
    stages = read_manifest(workspace).stages
    row: dict[str, Any] = {"train_cpu_s": round(stages["train"].cpu_seconds, 1)} if "train" in stages else {}
    if kind not in stages or "mesh" not in stages[kind].report:
        return row
    mesh = stages[kind].report["mesh"]
    return row | {
        "cells": mesh["cells"],
        "irregular": mesh.get("irregular_vertices", ""),
        "worst_sj": round(mesh["min_scaled_jacobian"], 3),
        "mean_sj": round(mesh["mean_scaled_jacobian"], 4),
        "hausdorff": f"{100 * mesh['hausdorff']:.2f} %",
        "recall": "" if mesh["feature_recall"] is None else round(mesh["feature_recall"], 3),
        "mesh_cpu_s": round(stages[kind].cpu_seconds, 1),
        "report": stages[kind].report,
    }


def _checked(workspace: Path, options: argparse.Namespace) -> dict[str, Any]:
    mesh = workspace / RESULT[options.kind]
    if options.checker is None or not mesh.is_file():
        return {"checker": "no mesh" if options.checker else ""}
    command = [*shlex.split(options.checker), mesh, "--input", workspace / "surface.ply", "--json"]
    ended = run_child(command, name="the checker", timeout_s=options.timeout, accept=range(256))
    return {"checker": "valid" if ended.returncode == 0 else "not valid", "checked": ended.stdout.decode()}


def _markdown(rows: list[dict[str, Any]]) -> str:
    """The table, and a line that counts the outcomes."""
    lines = ["| " + " | ".join(COLUMNS) + " |", "|" + "---|" * len(COLUMNS)]
    for row in sorted(rows, key=lambda row: str(row["model"])):
        cells = [str(row.get(column, "")).replace("|", "\\|")[-160:] for column in COLUMNS]
        lines.append("| " + " | ".join(cells) + " |")
    counts = Counter((row["outcome"], row.get("checker", "")) for row in rows)
    total = ", ".join(f"{count} {' / '.join(filter(None, what))}" for what, count in counts.most_common())
    return "\n".join([f"{len(rows)} models: {total}", "", *lines]) + "\n"


def _rows(lines: Path) -> list[dict[str, Any]]:
    if not lines.exists():
        return []
    return [json.loads(line) for line in lines.read_text(encoding="utf-8").splitlines() if line.strip()]


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("kind", choices=sorted(RESULT))
    parser.add_argument("workspaces", type=Path)
    parser.add_argument("--output", type=Path, default=Path("mesh_table"))
    parser.add_argument("--scale", type=float)
    parser.add_argument("--timeout", type=float, default=600.0, help="wall seconds of each stage")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--checker", help="command of an independent checker")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())

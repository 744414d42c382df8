"""Quads from three cross fields of the same tets: the `fast` and the `paper` preset, and the surface alone.

    python benchmarks/quad_fields.py --target-faces 6000 --output FIELDS.jsonl --keep FOLDER WORKSPACE...

Each WORKSPACE (made by `neurframe tetize`) is copied; nothing in it is changed.  --iterations are those of the paper
preset, whose own number is 10,000.  --keep keeps the copies, and a field that was trained there is used again.  The
crosses lie on the same triangles for all three.  A line is added to --output
as soon as a mesh is there, and what has a line is not made again; then the table of all lines is printed.  Columns:
tets, CPU seconds of training, irregular vertices, inverted quads, worst and mean scaled Jacobian, Hausdorff distance
in percent of the bounding-box diagonal, share of the sharp edges that edges follow.
"""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from neurframe_cli.mesh.read_tets import read_medit
from neurframe_cli.pipeline.manifest import read_manifest

COLUMNS = (
    "model | tets | field | train CPU s | quads | irregular | inverted | SJ worst | SJ mean | Hausdorff %",
    "recall",
)
HEADER = f"| {' | '.join(COLUMNS)} |\n{'|---' * 11}|"
TETS = ("surface.ply", "tets.mesh", "features.json")


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("workspaces", nargs="+", type=Path)
    parser.add_argument("--target-faces", type=int, default=6000)
    parser.add_argument("--iterations", type=int)
    parser.add_argument("--output", type=Path, default=Path("quad_fields.jsonl"))
    parser.add_argument("--keep", type=Path)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        for source in arguments.workspaces:
            measure(source, arguments.keep or Path(temporary), arguments)
    print("\n".join([HEADER, *(shown(row) for row in rows(arguments.output))]))


def measure(source: Path, folder: Path, arguments: argparse.Namespace) -> None:
    """Adds the lines of one model that the output does not have."""
    name = source.name.removesuffix(".neurframe")
    known = {row["field"] for row in rows(arguments.output) if row["model"] == name}
    for field, training in fields(arguments.iterations).items():
        if field not in known:
            workspace = folder / f"{name}-{field.split(',')[0]}.neurframe"
            workspace.mkdir(parents=True, exist_ok=True)
            made = meshed(source, workspace, training, arguments.target_faces)
            with arguments.output.open("a", encoding="utf-8") as out:
                out.write(json.dumps({"model": name, "field": field} | made) + "\n")


def rows(lines: Path) -> list[dict[str, Any]]:
    if not lines.exists():
        return []
    return [json.loads(line) for line in lines.read_text(encoding="utf-8").splitlines()]


def fields(iterations: int | None) -> dict[str, list[str] | None]:
    """The options of `neurframe train` by name of the field; None for the one that needs no training."""
    some = ["--iterations", str(iterations)] if iterations else []
    return {
        "fast": ["--preset", "fast"],
        "surface": None,
        f"paper, {iterations} iterations" if some else "paper": ["--preset", "paper", *some],
    }


def meshed(source: Path, workspace: Path, training: list[str] | None, target: int) -> dict[str, Any]:
    """The numbers of the quads of one field, or what went wrong with it."""
    for file in TETS:
        shutil.copyfile(source / file, workspace / file)
    quad = ["quad", "--target-faces", str(target), "--no-pictures"]
    stages = [[*quad, "--field", "surface"]]
    if training is not None:
        stages = [["train", *training], ["discretize", "--no-pictures"], quad]
    for stage in stages:
        command = [
            sys.executable,
            "-m",
            "neurframe_cli",
            *stage,
            "-w",
            str(workspace),
            "-q",
            "--threads",
            "1",
        ]
        ended = subprocess.run(command, stderr=subprocess.PIPE, text=True, check=False)
        if ended.returncode not in (0, 4):
            return {"failed": f"{stage[0]}: {ended.stderr.strip()}"}
    done = read_manifest(workspace).stages
    if "mesh" not in done["quad"].report:
        return {"failed": f"no quads: {done['quad'].error}"}
    return {
        "tets": len(read_medit(workspace / "tets.mesh")[0].T),
        "train_cpu_s": done["train"].cpu_seconds if "train" in done else None,
        "mesh": done["quad"].report["mesh"],
    }


def shown(row: dict[str, Any]) -> str:
    if "failed" in row:
        return f"| {row['model']} | | {row['field']} | {row['failed']} |"
    mesh, recall, seconds = row["mesh"], row["mesh"]["feature_recall"], row["train_cpu_s"]
    return (
        f"| {row['model']} | {row['tets']:,} | {row['field']} | {'-' if seconds is None else f'{seconds:.0f}'} "
        f"| {mesh['cells']} | {mesh['irregular_vertices']} | {mesh['inverted']} "
        f"| {mesh['min_scaled_jacobian']:.3f} | {mesh['mean_scaled_jacobian']:.3f} | {100 * mesh['hausdorff']:.2f} "
        f"| {'-' if recall is None else f'{recall:.3f}'} |"
    )


if __name__ == "__main__":
    main()

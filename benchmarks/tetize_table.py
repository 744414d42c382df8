"""What `neurframe tetize` makes of every file of a folder tree: outcome, exit code, tets, seconds.

    python benchmarks/tetize_table.py FOLDER... --output table --edge-length 0.025 --timeout 600 --jobs 1

Appends one JSON line per file to OUTPUT.jsonl and writes OUTPUT.md at the end; files that are already in the JSON
lines are skipped, so a killed run goes on where it was.  Each file is a process of its own and is judged by what it
leaves behind: the exit code, and the tet mesh read back and checked here.  Large files first, so that no long job
is left over for the end.  --keep FOLDER keeps the workspaces; mesh_table.py goes on from them.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from typing import Any

from neurframe_cli.errors import NeurframeError
from neurframe_cli.process import run_child

OUTCOMES = {0: "tets", 2: "refused", 3: "failed", 4: "not valid", 124: "timed out", 130: "interrupted"}
PATIENCE_S = 60.0  # on top of --timeout: reading, checking, writing


def main() -> int:
    options = _arguments()
    lines = options.output.with_suffix(".jsonl")
    known = {row["file"] for row in _rows(lines)}
    files = sorted(
        {f for folder in options.folders for f in folder.rglob("*") if f.is_file()}, key=_size, reverse=True
    )
    todo = [file for file in files if str(file) not in known]
    print(f"{len(files)} files, {len(files) - len(todo)} known, {len(todo)} to do", flush=True)
    with ThreadPoolExecutor(options.jobs) as pool, lines.open("a", encoding="utf-8") as out:
        for done in as_completed([pool.submit(_one, file, options) for file in todo]):
            row = done.result()
            out.write(json.dumps(row) + "\n")
            out.flush()
            print(
                f"{row['outcome']:>9} {row['code']:>4} {row['tets']:>8} {row['seconds']:>7} {row['file']}",
                flush=True,
            )
    rows = _rows(lines)
    options.output.with_suffix(".md").write_text(_markdown(rows), encoding="utf-8")
    return 1 if any(row["defect"] for row in rows) else 0


def _one(file: Path, options: argparse.Namespace) -> dict[str, Any]:
    """Runs the command on one file and looks at what is left."""
    started = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="tetize-table-") as folder:
        workspace = (options.keep or Path(folder)) / f"{file.parent.name}-{file.name}.neurframe"
        workspace.parent.mkdir(parents=True, exist_ok=True)
        command = [sys.executable, "-m", "neurframe_cli", "tetize", file, "-w", workspace, "-q"]
        command += ["--edge-length", str(options.edge_length), "--timeout", str(options.timeout)]
        row: dict[str, Any] = {"file": str(file), "code": -1, "tets": 0, "defect": "", "words": ""}
        try:
            result = run_child(
                command, name="neurframe tetize", timeout_s=options.timeout + PATIENCE_S, accept=range(256)
            )
        except NeurframeError as error:
            return row | {
                "outcome": "no end",
                "defect": str(error),
                "seconds": round(time.monotonic() - started, 1),
            }
        row |= {"code": result.returncode, "outcome": OUTCOMES.get(result.returncode, "unknown")}
        row |= {"seconds": round(result.seconds, 1), "peak_mib": round(result.peak_mib)}
        row["cpu_seconds"] = round(result.cpu_seconds, 1)
        row["words"] = " ".join(line.strip() for line in result.last_lines)[-400:]
        row |= _judge(result.returncode, row["words"], workspace)
    return row


def _judge(code: int, words: str, workspace: Path) -> dict[str, Any]:
    """Number of tets, what the manifest says, and `defect`: anything that a command must never do."""
    if "Traceback" in words or "internal error" in words:
        return {"defect": "an exception that nobody caught"}
    if code not in OUTCOMES:
        return {"defect": f"exit code {code}"}
    if code != 0:
        return {"defect": "" if words else "no message"}
    return _judge_mesh(workspace / "tets.mesh") | _from_manifest(workspace / "manifest.json")


def _judge_mesh(path: Path) -> dict[str, Any]:
    import numpy as np

    from neurframe_cli.mesh.manifold_boundary import make_boundary_manifold
    from neurframe_cli.mesh.read_tets import read_medit
    from neurframe_cli.mesh.tet_adjacency import tet_adjacency
    from neurframe_cli.mesh.tet_quality import mean_ratio

    try:
        mesh, _ = read_medit(path)
    except NeurframeError as error:
        return {"defect": f"exit code 0, but {error}"}
    manifold = make_boundary_manifold(mesh)[1]
    boundary_faces = int((tet_adjacency(mesh.T).neighbors < 0).sum(axis=1).max())
    defects = {
        "non-manifold boundary": not manifold.unchanged,
        "tets with two boundary faces": boundary_faces > 1,
    }
    quality = mean_ratio(mesh.V, mesh.T)
    return {
        "tets": len(mesh.T),
        "quality_min": round(float(quality.min()), 4),
        "quality_1st_percent": round(float(np.percentile(quality, 1)), 3),
        "defect": ", ".join(what for what, is_so in defects.items() if is_so),
    }


def _from_manifest(path: Path) -> dict[str, Any]:
    stage = json.loads(path.read_text(encoding="utf-8"))["stages"]["tetize"]
    return {"warnings": stage.get("warnings", []), "stage": stage.get("report", {})}


def _markdown(rows: list[dict[str, Any]]) -> str:
    """The table, and a line that counts the outcomes."""
    columns = ("file", "outcome", "code", "tets", "seconds", "cpu_seconds", "quality_min", "words", "defect")
    lines = ["| " + " | ".join(columns) + " |", "|" + "---|" * len(columns)]
    for row in sorted(rows, key=lambda row: str(row["file"])):
        cells = [str(row.get(column, "")).replace("|", "\\|")[-160:] for column in columns]
        lines.append("| " + " | ".join(cells) + " |")
    counts = Counter(row["outcome"] for row in rows)
    total = ", ".join(f"{count} {outcome}" for outcome, count in counts.most_common())
    return "\n".join([f"{len(rows)} files: {total}", "", *lines]) + "\n"


def _rows(lines: Path) -> list[dict[str, Any]]:
    if not lines.exists():
        return []
    return [json.loads(line) for line in lines.read_text(encoding="utf-8").splitlines() if line.strip()]


def _size(file: Path) -> tuple[int, str]:
    return file.stat().st_size, str(file)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--output", type=Path, default=Path("tetize_table"))
    parser.add_argument("--edge-length", type=float, default=0.025)
    parser.add_argument("--timeout", type=float, default=600.0)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--keep", type=Path, help="folder in which the workspaces stay")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())

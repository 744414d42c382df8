"""What the hex rows of mesh_table.py say of field, map and mesh, model by model: the table of docs/hex.md.

    python benchmarks/tetize_table.py FOLDER... --output tets --edge-length 0.05 --keep WORKSPACES
    python benchmarks/mesh_table.py hex WORKSPACES --output hexes --scale 30 --checker "python check_mesh.py"
    python benchmarks/hex_table.py hexes.jsonl --output hexes-map.md

Singular arcs (edges) of the field that carries the map, or that it is a polycube; tets that are folded after the
Poisson solve, in the seamless map, after rounding and in the end; what is wrong with the map; hexes, their worst and
mean scaled Jacobian, Hausdorff distance and recall of sharp edges; the share of the volume in hexes that are not
inverted; CPU seconds of training, of the map and of all of `hex`; outcome.
"""

from __future__ import annotations

import argparse
import json
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

FLIPS = ("poisson", "seamless", "rounded", "exact")
WRONG = {
    "folded_tets": "folded",
    "wrongly_wound_edges": "wound",
    "open_seams": "open",
    "unaligned_faces": "unaligned",
}


def main() -> None:
    options = _arguments()
    lines = options.lines.read_text(encoding="utf-8").splitlines()
    rows = sorted((json.loads(line) for line in lines if line.strip()), key=lambda row: str(row["model"]))
    options.output.write_text(_markdown([_cells(row) for row in rows]), encoding="utf-8")


def _cells(row: Mapping[str, Any]) -> dict[str, str]:
    """One line of the table; a model without a map says only how far it came."""
    report = row.get("report", {})
    cells = {"model": str(row["model"])}
    if report:
        cells |= _of_map(report["parametrization"]) | _of_mesh(report["mesh"])
        mapping = sum(report["parametrization"]["cpu_seconds"].values())
        cells["CPU s: training, map, all"] = (
            f"{row.get('train_cpu_s', '')}, {mapping:.1f}, {row['mesh_cpu_s']}"
        )
    return cells | {"outcome": _outcome(row)}


def _outcome(row: Mapping[str, Any]) -> str:
    """Valid, and what it took; or why not."""
    if row["outcome"] != "ok":
        return str(row["outcome"])
    report = row["report"]
    if report["problems"] or row.get("checker", "valid") == "not valid":
        return f"refused: {', '.join(report['problems']) or 'by the checker'}"
    if tried := report.get("grid"):
        grid = next(attempt for attempt in tried if attempt.get("kept"))
        size = "" if grid["finer"] == 1.0 else f" x {grid['finer']:g}"
        return f"valid, grid{size}{', finer in places' if grid['split'] else ''}"
    times = next((t["times"] for t in report.get("splitting", []) if t["kept"]), 1)
    padded = report.get("padding", {}).get("kept", False)
    return ", ".join(["valid", *([f"x {times}"] if times > 1 else []), *(["padded"] if padded else [])])


def _of_map(made: Mapping[str, Any]) -> dict[str, str]:
    counts = {name: entry["count"] for name, entry in made["map"].items() if isinstance(entry, dict)}
    wrong = [f"{count} {WRONG[name]}" for name, count in counts.items() if count]
    return {
        "tets, split": f"{made['input_tets']:,}, {made['tets']:,}",
        "arcs": "polycube"
        if made["polycube"]
        else f"{len(made['singular_arcs'])} ({made['singular_edges']})",
        "folded": " / ".join(str(made["flips"][name]) for name in FLIPS),
        "map": ", ".join(wrong) or "valid",
    }


def _of_mesh(mesh: Mapping[str, Any]) -> dict[str, str]:
    recall = "" if mesh["feature_recall"] is None else f", {mesh['feature_recall']:.2f}"
    quality = f"{mesh['min_scaled_jacobian']:.2f}, {mesh['mean_scaled_jacobian']:.2f}"
    return {
        "hexes, SJ worst, mean, Hausdorff, recall": f"{mesh['cells']:,}, {quality}, "
        f"{100 * mesh['hausdorff']:.2f} %{recall}",
        "in hexes": f"{100 * mesh['valid_volume_share']:.0f} %",
    }


def _markdown(rows: list[dict[str, str]]) -> str:
    columns = list(dict.fromkeys(name for row in sorted(rows, key=len, reverse=True) for name in row))
    lines = ["| " + " | ".join(columns) + " |", "|" + "---|" * len(columns)]
    lines += ["| " + " | ".join(row.get(name, "") for name in columns) + " |" for row in rows]
    outcomes = Counter(row["outcome"].split(",")[0].split(":")[0] for row in rows)
    total = ", ".join(f"{count} {outcome}" for outcome, count in outcomes.most_common())
    return "\n".join([f"{len(rows)} models: {total}", "", *lines]) + "\n"


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("lines", type=Path, help="the JSON lines of mesh_table.py")
    parser.add_argument("--output", type=Path, default=Path("hex_table.md"))
    return parser.parse_args()


if __name__ == "__main__":
    main()

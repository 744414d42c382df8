"""What the hex rows of mesh_table.py say of field, map and mesh, model by model.

    python benchmarks/tetize_table.py FOLDER... --output tets --edge-length 0.05 --keep WORKSPACES
    python benchmarks/mesh_table.py hex WORKSPACES --output hexes --scale 30 --checker "python check_mesh.py"
    python benchmarks/hex_table.py hexes.jsonl --output hexes-map.md

Singular arcs (edges) and defects of the field; tets that are folded after the Poisson solve, in the seamless map,
after rounding and in the end; edges that the map winds wrongly; hexes and the share of the volume that they fill;
worst and mean scaled Jacobian; CPU seconds of training, of each stage of the map and of all of it; outcome.
"""

from __future__ import annotations

import argparse
import json
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

FLIPS = ("poisson", "seamless", "rounded", "exact")


def main() -> None:
    options = _arguments()
    lines = options.lines.read_text(encoding="utf-8").splitlines()
    rows = sorted((json.loads(line) for line in lines if line.strip()), key=lambda row: str(row["model"]))
    options.output.write_text(_markdown([_cells(row) for row in rows]), encoding="utf-8")


def _cells(row: Mapping[str, Any]) -> dict[str, str]:
    """One line of the table; a model without a map says only how far it came."""
    report = row.get("report", {})
    cells = {"model": str(row["model"]), "outcome": _outcome(row)}
    if report:
        cells |= _of_map(report["parametrization"]) | _of_mesh(report["mesh"])
    cells["train s"] = str(row.get("train_cpu_s", ""))
    cells["hex s"] = str(row.get("mesh_cpu_s", ""))
    return cells


def _outcome(row: Mapping[str, Any]) -> str:
    if row["outcome"] != "ok":
        return str(row["outcome"])
    return "valid" if row.get("checker", "") in ("", "valid") else "refused by the checker"


def _of_map(made: Mapping[str, Any]) -> dict[str, str]:
    defects = {name: entry["count"] for name, entry in (made["defects"] or {}).items()}
    return {
        "tets": f"{made['input_tets']}, {made['tets']}",
        "arcs": f"{len(made['singular_arcs'])} ({made['singular_edges']})",
        "defects": ", ".join(f"{count} {name}" for name, count in defects.items()),
        "folded": " / ".join(str(made["flips"][name]) for name in FLIPS),
        "wound": str(made["map"]["wrongly_wound_edges"]["count"]),
        "seconds": ", ".join(f"{name} {seconds:.1f}" for name, seconds in made["cpu_seconds"].items()),
    }


def _of_mesh(mesh: Mapping[str, Any]) -> dict[str, str]:
    return {
        "hexes": str(mesh["cells"]),
        "volume": f"{mesh['volume_ratio']:.3f}",
        "SJ worst, mean": f"{mesh['min_scaled_jacobian']:.2f}, {mesh['mean_scaled_jacobian']:.2f}",
        "Hausdorff": f"{100 * mesh['hausdorff']:.2f} %",
        "recall": "" if mesh["feature_recall"] is None else f"{mesh['feature_recall']:.2f}",
    }


def _markdown(rows: list[dict[str, str]]) -> str:
    columns = list(dict.fromkeys(name for row in sorted(rows, key=len, reverse=True) for name in row))
    lines = ["| " + " | ".join(columns) + " |", "|" + "---|" * len(columns)]
    lines += ["| " + " | ".join(row.get(name, "") for name in columns) + " |" for row in rows]
    outcomes = Counter(row["outcome"] for row in rows)
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

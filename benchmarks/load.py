"""Peak memory and time of every stage against the size of the problem, on made tet meshes and on real models.

    python benchmarks/load.py --divisions 6 12 24 --stages tetize train discretize quad hex
    python benchmarks/load.py --divisions 56 --stages tetize discretize hexex --field-from 12
    python benchmarks/load.py --shape cylinder --divisions 12 19 31 --stages tetize train discretize hex --field-from 6
    python benchmarks/load.py --models part.stl --edge-length 0.01

A cube of n divisions has 6 n^3 tets (n = 56: 1,053,696), a cylinder 36 n^3 (n = 31: 1,072,476).  For each size the
stages run one after the other, on one thread, as `neurframe STAGE`; a line of JSON for each: tets, elements, CPU
seconds, peak MiB, and what was expected; of `hex` also the CPU seconds of each step of its map.  A stage whose CPU
seconds, carried on from the size before in proportion to the tets, would go over --budget is left out, and the line
says so.  `hexex` extracts from an exact map of the cube, made here.  --field-from N takes the trained field of the
shape at N divisions (a field can be asked anywhere).  At the end: MiB per 1000 tets of each stage.
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import tempfile
from itertools import pairwise
from pathlib import Path

from load_models import cube_tets, cylinder_tets, write_exact_map

from neurframe_cli.errors import NeurframeError
from neurframe_cli.mesh.write_mesh import write_tets
from neurframe_cli.pipeline.executables import find_executable
from neurframe_cli.pipeline.manifest import read_manifest
from neurframe_cli.process import run_child

SHAPES = {"cube": cube_tets, "cylinder": cylinder_tets}
OPTIONS = {"discretize": ["--no-pictures"], "quad": ["--no-pictures"], "hex": ["--no-pictures"]}


def main() -> None:
    arguments = parse_arguments()
    with tempfile.TemporaryDirectory() as scratch:
        rows = [row for row in measure(arguments, Path(scratch)) if "peak_mib" in row]
    for stage in arguments.stages:
        points = sorted((row["tets"], row["peak_mib"]) for row in rows if row["stage"] == stage)
        for (few, low), (many, high) in pairwise(points):
            if many > few:
                print(f"{stage}: {1000 * (high - low) / (many - few):.2f} MiB per 1000 tets, {few} to {many}")


def parse_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    stages = ["tetize", "train", "discretize", "quad", "hex", "hexex"]
    parser.add_argument("--shape", choices=SHAPES, default="cube")
    parser.add_argument("--divisions", type=int, nargs="*", default=[])
    parser.add_argument("--models", type=Path, nargs="*", default=[])
    parser.add_argument("--edge-length", default="0.025")
    parser.add_argument("--stages", nargs="+", choices=stages, default=stages)
    parser.add_argument("--field-from", type=int, help="divisions of the mesh whose field is taken")
    parser.add_argument("--iterations", help="of the distillation; the memory does not depend on it")
    parser.add_argument("--scale", default=None, help="of quads and hexes")
    parser.add_argument(
        "--hexex-side", type=int, default=30, help="hexes along an edge of the cube for `hexex`"
    )
    parser.add_argument("--budget", type=float, default=900.0, help="CPU seconds of a stage")
    return parser.parse_args()


def measure(arguments: argparse.Namespace, scratch: Path) -> list[dict[str, object]]:
    """All rows, printed as they come."""
    rows: list[dict[str, object]] = []
    if arguments.field_from is not None:
        prepare_field(arguments, scratch)
    for divisions in arguments.divisions:
        model = scratch / f"{arguments.shape}-{divisions}.mesh"
        write_tets(model, SHAPES[arguments.shape](divisions))
        rows += measure_model(model, divisions, arguments, scratch, rows)
    for model in arguments.models:
        rows += measure_model(model, None, arguments, scratch, [])
    return rows


def prepare_field(arguments: argparse.Namespace, scratch: Path) -> None:
    model, workspace = scratch / "field.mesh", scratch / "field.neurframe"
    write_tets(model, SHAPES[arguments.shape](arguments.field_from))
    for stage in ("tetize", "train"):
        run_stage(stage, model, workspace, arguments)


def measure_model(
    model: Path,
    divisions: int | None,
    arguments: argparse.Namespace,
    scratch: Path,
    earlier: list[dict[str, object]],
) -> list[dict[str, object]]:
    workspace = scratch / f"{model.stem}.neurframe"
    rows: list[dict[str, object]] = []
    for stage in arguments.stages:
        row: dict[str, object] = {"model": model.name, "divisions": divisions, "stage": stage}
        predicted = predicted_seconds(stage, divisions, earlier)
        if stage == "hexex":
            row |= extract(divisions, arguments.hexex_side, scratch) if divisions is not None else {}
        elif predicted > arguments.budget:
            row |= {"left_out": f"would take about {predicted:.0f} CPU seconds"}
        elif stage == "train" and arguments.field_from is not None:
            shutil.copyfile(
                scratch / "field.neurframe" / "field.safetensors", workspace / "field.safetensors"
            )
            row |= {"left_out": "the field is taken from another mesh"}
        else:
            row |= run_stage(stage, model, workspace, arguments)
        print(json.dumps(row), flush=True)
        rows.append(row)
    shutil.rmtree(workspace, ignore_errors=True)
    return rows


def predicted_seconds(stage: str, divisions: int | None, earlier: list[dict[str, object]]) -> float:
    """From the largest mesh so far, in proportion to the tets; 0 where there is none."""
    done = [row for row in earlier if row["stage"] == stage and "cpu_seconds" in row]
    if not done or divisions is None:
        return 0.0
    return float(str(done[-1]["cpu_seconds"])) * (divisions / int(str(done[-1]["divisions"]))) ** 3


def run_stage(stage: str, model: Path, workspace: Path, arguments: argparse.Namespace) -> dict[str, object]:
    """`neurframe STAGE`; what its manifest says."""
    options = ["-w", str(workspace), "-q", "--threads", "1", *OPTIONS.get(stage, [])]
    if stage == "tetize":
        options += [str(model), "--edge-length", arguments.edge_length]
    elif stage == "train" and arguments.iterations:
        options += ["--iterations", arguments.iterations]
    elif stage in ("quad", "hex") and arguments.scale:
        options += ["--scale", arguments.scale]
    try:
        ended = run_child(
            [sys.executable, "-m", "neurframe_cli", stage, *options], name=stage, accept=range(256)
        )
    except NeurframeError as error:
        return {"error": str(error)}
    stages = read_manifest(workspace).stages
    if stage not in stages:
        return {"exit": ended.returncode, "error": ended.last_lines[-1:]}
    record = stages[stage]
    return {
        "exit": ended.returncode,
        "tets": stages["tetize"].report["tets"],
        "elements": record.report.get("mesh", {}).get("cells") or record.report.get("triangles"),
        "cpu_seconds": record.cpu_seconds,
        "peak_mib": record.peak_mib,
        "expected_mib": record.expected_mib,
        "error": record.error,
        "steps": record.report.get("parametrization", {}).get("cpu_seconds"),
    }


def extract(divisions: int, hexes_per_side: int, scratch: Path) -> dict[str, object]:
    """neurframe-hexex alone on an exact map."""
    mesh = cube_tets(divisions)
    source, target = scratch / "cube.hexex", scratch / "cube.vtk"
    write_exact_map(source, mesh, hexes_per_side)
    ended = run_child(
        [find_executable("hexex"), source, "-o", target, "--threads", "1"], name="hexex", accept=range(256)
    )
    return {
        "exit": ended.returncode,
        "tets": len(mesh.T),
        "elements": hexes_per_side**3,
        "cpu_seconds": round(ended.cpu_seconds, 2),
        "peak_mib": round(ended.peak_mib, 1),
        "map_mib": round(source.stat().st_size / 2**20, 1),
    }


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""What --fill makes of the maps of workspaces, valid or not.

    hex_fill.py WORKSPACE... --hexex PATH [--map map.hexex] [--keep FOLDER]

Of each map: the hexes that neurframe-hexex extracts, how many of them are inverted after smoothing, and the mesh in
which pyramids and tets take the place of the bad and the missing ones: share of its volume in hexes, cells by kind,
worst quality of each, volume and Hausdorff distance against the surface of the tets (of the diagonal), attempts after
which hexes were given up because something was in the way, CPU seconds of filling with Netgen's.  Exit status 1 where
a filled mesh does not pass the check.
"""

from __future__ import annotations

import argparse
import resource
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from neurframe_cli.errors import NeurframeError
from neurframe_cli.mesh.arrays import Surface, TetMesh
from neurframe_cli.mesh.features import features_by_angle, read_features
from neurframe_cli.mesh.filling.hybrid_files import write_hybrid
from neurframe_cli.mesh.optimize.smooth import SmoothOptions
from neurframe_cli.mesh.quality.check import CheckOptions, Verdict
from neurframe_cli.mesh.quality.check_hybrid import check_hybrid
from neurframe_cli.mesh.read_cells import CellMesh, read_cells
from neurframe_cli.mesh.read_surface import read_surface
from neurframe_cli.mesh.read_tets import read_medit
from neurframe_cli.mesh.tet_adjacency import tet_adjacency
from neurframe_cli.stages.fill_voids import FilledMesh, fill_voids
from neurframe_cli.stages.run_netgen import run_netgen
from neurframe_cli.stages.smooth_hexes import smooth_hexes

TIMEOUT_S = 1800.0


@dataclass(frozen=True)
class Row:
    """hexes extracted, inverted after smoothing; the filled mesh and its check; CPU seconds."""

    name: str
    hexes: int
    inverted: int
    filled: FilledMesh
    verdict: Verdict
    seconds: float

    def cells(self) -> list[str]:
        n = self.verdict.numbers
        return [
            self.name,
            f"{self.hexes:,}",
            str(self.inverted),
            f"{100 * n['hex_volume_share']:.1f} %",
            f"{n['hexes']:,} + {n['pyramids']} + {n['tets']:,}",
            f"{n['worst_hex']:.2f}, {n['worst_pyramid']:.2f}, {n['worst_tet']:.3f}",
            f"{n['volume_ratio']:.4f}",
            f"{100 * n['hausdorff']:.1f} %",
            "yes" if self.verdict.valid else "; ".join(self.verdict.problems),
            str(len(self.filled.obstacles)),
            f"{self.seconds:.1f}",
        ]


HEAD = [
    "model",
    "hexes",
    "inverted",
    "in hexes",
    "hexes + pyramids + tets",
    "worst SJ hex, pyramid, tet",
    "volume",
    "Hausdorff",
    "valid",
    "further attempts",
    "CPU s",
]


def row(workspace: Path, map_name: str, hexex: Path, keep: Path | None) -> Row:
    """One model; raises NeurframeError where nothing can be made of it."""
    with tempfile.TemporaryDirectory() as folder:
        raw = _extracted(workspace / map_name, hexex, Path(folder) / "hexes.mesh")
        model = read_surface(workspace / "surface.ply")
        smoothed = smooth_hexes(
            raw.V, raw.cells, model, features_by_angle(model.V, model.F, 45.0), SmoothOptions()
        )
        tets = read_medit(workspace / "tets.mesh")[0]
        surface = Surface(tets.V, tet_adjacency(tets.T).boundary_faces)

        def tetrahedralize(void: Surface, edge_length: float) -> TetMesh:
            return run_netgen(
                void, edge_length, timeout_s=TIMEOUT_S, memory_mib=None, scratch_dir=Path(folder)
            )

        before = _cpu_seconds()
        sharp = read_features(workspace / "features.json").edges
        filled = fill_voids(smoothed.V, raw.cells, surface, sharp, tetrahedralize)
        seconds = _cpu_seconds() - before
    if keep is not None:
        write_hybrid(keep / f"{workspace.stem}.vtu", filled.mesh)
    verdict = check_hybrid(filled.mesh, surface, CheckOptions())
    inverted = smoothed.report.after.inverted
    return Row(workspace.stem, len(raw.cells), inverted, filled, verdict, seconds)


def _extracted(map_file: Path, hexex: Path, output: Path) -> CellMesh:
    done = subprocess.run(
        [hexex, map_file, "-o", output, "--threads", "1"], capture_output=True, text=True, check=False
    )
    if done.returncode not in (0, 4):
        raise NeurframeError(done.stderr.strip().splitlines()[-1])
    return read_cells(output)


def _cpu_seconds() -> float:
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(usage.ru_utime + usage.ru_stime for usage in used)


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("workspaces", type=Path, nargs="+", metavar="WORKSPACE")
    parser.add_argument("--hexex", type=Path, required=True)
    parser.add_argument("--map", default="map.hexex")
    parser.add_argument("--keep", type=Path, help="folder for the filled meshes")
    options = parser.parse_args()
    print("| " + " | ".join(HEAD) + " |\n|" + "---|" * len(HEAD))
    right = True
    for workspace in options.workspaces:
        try:
            made = row(workspace, options.map, options.hexex, options.keep)
        except NeurframeError as error:
            print(f"| {workspace.stem} | {error} |", flush=True)
            right = False
            continue
        right = right and made.verdict.valid
        print("| " + " | ".join(made.cells()) + " |", flush=True)
        for obstacle in made.filled.obstacles:
            print(f"{workspace.stem}: {obstacle}", file=sys.stderr)
    return 0 if right else 1


if __name__ == "__main__":
    sys.exit(main())

"""Smoothing of disturbed closed-form meshes and of hex meshes extracted from integer-grid maps: a Markdown table.

    python benchmarks/smoothing.py [MAP.hexex ...]

Without maps: cube, cylinder, sphere and torus at about 6,000 quads or 10,000 hexes, each vertex moved at random.  A map
is extracted by neurframe-hexex (or what NEURFRAME_HEXEX names) and smoothed against the boundary of its tets, as hexes,
and its boundary as quads.  Seconds are CPU seconds of this process, imports done before; scaled Jacobians are before
-> after; distance is Hausdorff in percent of the bounding-box diagonal; curves are those found of all.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import meshio
import numpy as np

from neurframe_cli.mesh.arrays import Features, Floats, Ints, Surface
from neurframe_cli.mesh.features import features_by_angle
from neurframe_cli.mesh.optimize.smooth import MeshNumbers, SmoothOptions
from neurframe_cli.mesh.tet_adjacency import tet_adjacency
from neurframe_cli.pipeline.executables import find_executable
from neurframe_cli.stages.smooth_hexes import boundary_quads, smooth_hexes
from neurframe_cli.stages.smooth_quads import smooth_quads

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
from smooth_shapes import (
    Shape,
    compact,
    cube_hexes,
    cube_quads,
    cylinder_hexes,
    jitter,
    sphere_quads,
    torus_quads,
)

HEADER = """| mesh | cells | CPU s | rounds | inverted | SJ min | SJ mean | distance % | curves |
|---|---|---|---|---|---|---|---|---|"""


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("maps", nargs="*", type=Path)
    arguments = parser.parse_args()
    smooth_quads(*_arguments(cube_quads(2)))  # imports
    print(HEADER)
    shapes = (pair for path in arguments.maps for pair in from_map(path)) if arguments.maps else disturbed()
    for name, shape in shapes:
        print(row(name, shape), flush=True)


def disturbed() -> Iterator[tuple[str, Shape]]:
    """Shapes with every vertex moved by up to a third of an edge in each direction."""
    shapes = {
        "cube, quads": (cube_quads(32, 20), 1 / 32),
        "sphere, quads": (sphere_quads(32, 50), 1 / 20),
        "torus, quads": (torus_quads(120, 50), 1 / 20),
        "cube, hexes": (cube_hexes(22, 20), 1 / 22),
        "cylinder, hexes": (cylinder_hexes(12, 8, 19, 96), 1 / 20),
    }
    for name, (shape, edge) in shapes.items():
        yield name, replace(shape, V=jitter(shape.V, edge / 3, seed=0))


def from_map(path: Path) -> Iterator[tuple[str, Shape]]:
    """The hexes of a map, and their boundary as quads."""
    with tempfile.TemporaryDirectory() as scratch:
        mesh_file = Path(scratch) / "hexes.mesh"
        subprocess.run([find_executable("hexex"), path, "-o", mesh_file], check=True, capture_output=True)
        mesh = meshio.read(mesh_file)
    surface, features = _boundary_of_map(path)
    V, H = np.asarray(mesh.points, np.float64), mesh.cells_dict["hexahedron"].astype(np.int64)
    yield f"{path.stem}, hexes", Shape(V, H, surface, features)
    yield f"{path.stem}, quads", Shape(*compact(V, boundary_quads(H)), surface, features)


def _boundary_of_map(path: Path) -> tuple[Surface, Features]:
    """Boundary of the tets of a map in the text format of HexEx with decimals."""
    words = path.read_text().split()
    count = int(words[0])
    V = np.array(words[1 : 1 + 3 * count], np.float64).reshape(-1, 3)
    first, cells = 2 + 3 * count, int(words[1 + 3 * count])  # features may follow the cells
    tets = np.array(words[first : first + 16 * cells]).reshape(cells, 16)[:, :4].astype(np.int64)
    mirrored = np.linalg.det(V[tets[:, 1:]] - V[tets[:, :1]]) < 0
    tets[mirrored] = tets[mirrored][:, [0, 2, 1, 3]]
    points, faces = compact(V, tet_adjacency(tets).boundary_faces)
    surface = Surface(np.ascontiguousarray(points), faces)
    return surface, features_by_angle(surface.V, surface.F, 45.0)


def _arguments(shape: Shape) -> tuple[Floats, Ints, Surface, Features, SmoothOptions]:
    return shape.V, shape.cells, shape.surface, shape.features, SmoothOptions()


def row(name: str, shape: Shape) -> str:
    started = time.process_time()
    smooth = smooth_hexes if shape.cells.shape[1] == 8 else smooth_quads
    report = smooth(*_arguments(shape)).report
    seconds = time.process_time() - started
    found = report.classification
    before, after = _cells(report.before), _cells(report.after)
    numbers = " | ".join(f"{b} -> {a}" for b, a in zip(before, after, strict=True))
    curves = f"{found.matched_curves}/{found.curves}"
    return f"| {name} | {len(shape.cells)} | {seconds:.2f} | {report.rounds} | {numbers} | {curves} |"


def _cells(numbers: MeshNumbers) -> list[str]:
    return [
        str(numbers.inverted),
        f"{numbers.min_scaled_jacobian:.3f}",
        f"{numbers.mean_scaled_jacobian:.3f}",
        f"{100 * numbers.hausdorff:.3f}",
    ]


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""How near the points of `neurframe singularities` are to the singular edges of the same field on ever finer tets.

    singularities.py WORKSPACE... [--samples N] [--finest 0.01]

WORKSPACE is one in which `neurframe train` has been run.  The tets near the singular lines are divided into eight, the
field is asked at the new centroids, and its singular edges there are found, until the mean edge is at most `--finest`
bounding-box diagonals.  The table says how far the points are from those edges, and the edges from the points, in
per cent of the diagonal.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from neurframe_cli.field.field_file import read_field
from neurframe_cli.field.singular_edges import singular_edges
from neurframe_cli.mesh.arrays import Floats, Ints, TetMesh
from neurframe_cli.mesh.optimize.simplex_tree import SimplexTree
from neurframe_cli.mesh.quality.feature_recall import sample_segments
from neurframe_cli.mesh.read_tets import read_medit
from neurframe_cli.stages.discretize import sample_frames
from neurframe_cli.stages.singularities import SingularitiesOptions, find_singularities

Query = Callable[[Floats], Floats]
# a tet (0-3) with the midpoints 4-9 of its edges 01 02 03 12 13 23, in eight (Bey 1995)
EIGHT = np.array(
    [
        [0, 4, 5, 6],
        [4, 1, 7, 8],
        [5, 7, 2, 9],
        [6, 8, 9, 3],
        [4, 5, 6, 8],
        [4, 5, 8, 7],
        [5, 6, 8, 9],
        [5, 7, 9, 8],
    ]
)
EDGES = np.array([[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]])
NEAR = 1.5  # mean edges round a singular edge or point that are divided


@dataclass(frozen=True)
class Level:
    """A mesh: tets asked, mean edge in diagonals; ends (k,2,3) of its singular edges."""

    tets: int
    edge: float
    segments: Floats


def divided(mesh: TetMesh) -> TetMesh:
    """Every tet in eight."""
    ends = np.sort(mesh.T[:, EDGES].reshape(-1, 2), axis=1)
    edges, which = np.unique(ends, axis=0, return_inverse=True)
    corners = np.concatenate([mesh.T, len(mesh.V) + which.reshape(-1, 6)], axis=1)
    V = np.concatenate([mesh.V, mesh.V[edges].mean(axis=1)])
    T = corners[:, EIGHT].reshape(-1, 4)
    turned = np.linalg.det(V[T][:, 1:] - V[T][:, :1]) < 0
    T[turned] = T[turned][:, [1, 0, 2, 3]]
    return TetMesh(V, T)


def part_near(mesh: TetMesh, places: Floats, radius: float) -> TetMesh:
    """The tets whose centre is within `radius` of one of the places (k,3)."""
    distance = cKDTree(places).query(mesh.V[mesh.T].mean(axis=1))[0]
    used, T = np.unique(mesh.T[distance < radius], return_inverse=True)
    return TetMesh(mesh.V[used], T.reshape(-1, 4))


def mean_edge(mesh: TetMesh) -> float:
    ends = mesh.V[mesh.T[:, EDGES]]
    return float(np.linalg.norm(ends[:, :, 1] - ends[:, :, 0], axis=2).mean())


def level_of(query: Query, mesh: TetMesh, diagonal: float) -> Level:
    """The singular edges inside the mesh, or inside the part of one."""
    frames = sample_frames(query, mesh.V[mesh.T].mean(axis=1)).frames
    found = singular_edges(mesh.V, mesh.T, frames)
    return Level(len(mesh.T), mean_edge(mesh) / diagonal, mesh.V[found.edges])


def levels(query: Query, mesh: TetMesh, points: Floats, finest: float) -> list[Level]:
    """The whole mesh, then finer and finer ones round its singular edges and the points (k,3)."""
    diagonal = float(np.linalg.norm(np.ptp(mesh.V, axis=0)))
    found = [level_of(query, mesh, diagonal)]
    while found[-1].edge > finest:
        places = np.concatenate([points, _samples(found[-1].segments, 0.5 * mean_edge(mesh))])
        mesh = divided(part_near(mesh, places, NEAR * mean_edge(mesh)))
        found.append(level_of(query, mesh, diagonal))
    return found


def _samples(segments: Floats, step: float) -> Floats:
    return sample_segments(segments[:, 0], segments[:, 1], step)[0] if len(segments) else np.zeros((0, 3))


def distances(points: Floats, segments: Floats, diagonal: float) -> tuple[Floats, Floats]:
    """Per cent of the diagonal: of the points (k,3) to the segments (m,2,3), and of the segments to the points."""
    ends = np.arange(2 * len(segments)).reshape(-1, 2)
    there = SimplexTree(segments.reshape(-1, 3), ends).distances(points)
    back = cKDTree(points).query(_samples(segments, 0.002 * diagonal))[0]
    return 100 * there / diagonal, 100 * back / diagonal


def rows(workspace: Path, samples: int, finest: float) -> list[str]:
    """One line of the table for each level."""
    mesh, query = read_medit(workspace / "tets.mesh")[0], read_field(workspace / "field.safetensors").query
    diagonal = float(np.linalg.norm(np.ptp(mesh.V, axis=0)))
    points = find_singularities(query, mesh, SingularitiesOptions(samples=samples)).points
    lines = []
    for level in levels(query, mesh, points, finest):
        there, back = distances(points, level.segments, diagonal)
        edges: Ints = np.arange(len(level.segments))
        lines.append(
            f"| {workspace.stem} | {level.tets:,} | {100 * level.edge:.2f} % | {len(edges):,} | {len(points):,} | "
            f"{there.mean():.2f}, {np.percentile(there, 99):.2f}, {there.max():.2f} | "
            f"{back.mean():.2f}, {back.max():.2f} |"
        )
    return lines


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("workspaces", type=Path, nargs="+", metavar="WORKSPACE")
    parser.add_argument("--samples", type=int, default=2000)
    parser.add_argument("--finest", type=float, default=0.01)
    options = parser.parse_args()
    print(
        "| model | tets | mean edge | singular edges | points | points off: mean, 99 %, worst (%) | edges off: |"
    )
    print("|---|---|---|---|---|---|---|")
    for workspace in options.workspaces:
        print("\n".join(rows(workspace, options.samples, options.finest)), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())

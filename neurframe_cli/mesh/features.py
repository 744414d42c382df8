"""Feature edges of a surface: found by angle or given, ordered into chains between corners."""

from __future__ import annotations

import itertools
import json
from pathlib import Path
from typing import Any

import numpy as np

from neurframe_cli.errors import InvalidMesh, TooNewFile, UnreadableFile
from neurframe_cli.mesh.arrays import Bools, Features, Floats, Ints
from neurframe_cli.mesh.open_file import read_bytes
from neurframe_cli.mesh.surface_edges import surface_edges

FORMAT, VERSION = "neurframe-features", 1
# a chain that turns more than this at a vertex has a corner there, as a sharp edge does that meets no other
CORNER_ANGLE_DEG = 60.0


def features_by_angle(V: Floats, F: Ints, angle_deg: float) -> Features:
    """Edges of the surface V (n,3), F (m,3) whose two triangles meet at more than `angle_deg` from flat.

    Edges with one triangle or more than two are features as well: there the surface has no tangent plane.
    """
    edges = surface_edges(V, F)
    return features_from_edges(V, edges.edges[edges.angles_deg > angle_deg])


def features_from_edges(
    V: Floats, edges: Ints, corners: Ints | None = None, *, corner_angle_deg: float = CORNER_ANGLE_DEG
) -> Features:
    """Chains and corners of the graph that `edges` (k,2) form over V (n,3).

    A corner is a vertex where other than two edges meet, where a chain turns by more than `corner_angle_deg`, or
    one that `corners` names.  Edges that appear twice, or that join a vertex to itself, count once, or not at all.
    """
    edges = np.unique(np.sort(edges.reshape(-1, 2), axis=1), axis=0)
    edges = edges[edges[:, 0] != edges[:, 1]]
    is_corner = _turns(V, edges) > corner_angle_deg
    degree = np.bincount(edges.ravel(), minlength=len(V))
    is_corner |= (degree > 0) & (degree != 2)
    if corners is not None:
        is_corner[corners] |= degree[corners] > 0
    return Features(edges, chains_of(edges, is_corner), np.flatnonzero(is_corner))


def chains_of(edges: Ints, is_corner: Bools) -> tuple[Ints, ...]:
    """Vertex sequences that cover each edge once and run from corner to corner or round a loop.

    edges (k,2); is_corner (n,) must hold every vertex whose degree is not 2.  Chains come in the order of their
    lowest corner, then the loops without a corner in the order of their lowest vertex.
    """
    around: dict[int, list[int]] = {}
    for a, b in edges.tolist():
        around.setdefault(a, []).append(b)
        around.setdefault(b, []).append(a)
    walked: set[tuple[int, int]] = set()
    return tuple(
        _walk(start, second, around, is_corner, walked)
        for start in sorted(around, key=lambda vertex: (not is_corner[vertex], vertex))
        for second in around[start]
        if (start, second) not in walked
    )


def _walk(
    start: int, second: int, around: dict[int, list[int]], is_corner: Bools, walked: set[tuple[int, int]]
) -> Ints:
    """From `start` over `second` to the next corner or back to `start`."""
    chain = [start, second]
    while chain[-1] != start and not is_corner[chain[-1]]:
        before, here = chain[-2:]
        first, other = around[here]
        chain.append(other if first == before else first)
    for a, b in itertools.pairwise(chain):
        walked |= {(a, b), (b, a)}
    return np.array(chain, np.int64)


def _turns(V: Floats, edges: Ints) -> Floats:
    """(n,) angle in degrees by which the path turns at each vertex of degree 2, 0 elsewhere."""
    turns = np.zeros(len(V))
    ends = np.concatenate([edges, edges[:, ::-1]])
    ends = ends[np.argsort(ends[:, 0], kind="stable")]
    degree = np.bincount(ends[:, 0], minlength=len(V))
    first = (np.cumsum(degree) - degree)[degree == 2]
    here = np.flatnonzero(degree == 2)
    incoming, outgoing = V[here] - V[ends[first, 1]], V[ends[first + 1, 1]] - V[here]
    sine = np.linalg.norm(np.cross(incoming, outgoing), axis=1)
    turns[here] = np.degrees(np.arctan2(sine, np.einsum("ij,ij->i", incoming, outgoing)))
    return turns


def write_features(path: Path, features: Features) -> None:
    """Writes features.json: edges, chains and corners as vertex numbers."""
    record = {
        "format": FORMAT,
        "version": VERSION,
        "edges": features.edges.tolist(),
        "chains": [chain.tolist() for chain in features.chains],
        "corners": features.corners.tolist(),
    }
    path.write_text(json.dumps(record) + "\n", encoding="ascii")


def read_features(path: Path, vertex_count: int | None = None) -> Features:
    """Reads features.json, of a mesh with so many vertices where that is known.

    Raises UnreadableFile, TooNewFile, and InvalidMesh where the chains do not run over every edge exactly once or a
    vertex is not there.
    """
    record = _record(path)
    edges = _vertex_numbers(path, "edges", record.get("edges")).reshape(-1, 2)
    corners = _vertex_numbers(path, "corners", record.get("corners", []))
    chains = tuple(
        _vertex_numbers(path, f"chains[{i}]", chain) for i, chain in enumerate(record.get("chains", []))
    )
    covered = [np.sort(np.stack([c[:-1], c[1:]], axis=1), axis=1) for c in chains if len(c) > 1]
    covered_edges = np.concatenate(covered) if covered else np.zeros((0, 2), np.int64)
    if not np.array_equal(np.unique(edges, axis=0), covered_edges[np.lexsort(covered_edges.T[::-1])]):
        raise InvalidMesh(f"{path}: the chains do not run over every edge exactly once")
    _refuse_other_mesh(path, [edges, corners, *chains], vertex_count)
    return Features(edges, chains, corners)


def _refuse_other_mesh(path: Path, numbers: list[Ints], vertex_count: int | None) -> None:
    named = np.concatenate([part.ravel() for part in numbers])
    last = np.inf if vertex_count is None else vertex_count - 1
    if len(named) and not (named.min() >= 0 and named.max() <= last):
        wrong = named[(named < 0) | (named > last)][0]
        raise InvalidMesh(
            f"{path}: vertex {wrong} is not in the mesh"
            + (f", which has {vertex_count}" if vertex_count is not None else ""),
            hint="the file belongs to other tets: run `neurframe tetize` again",
        )


def _record(path: Path) -> dict[str, Any]:
    try:
        record = json.loads(read_bytes(path))
    except (ValueError, RecursionError) as error:
        raise UnreadableFile(f"{path}: no JSON: {error}") from error
    if not isinstance(record, dict) or record.get("format") != FORMAT:
        raise UnreadableFile(f'{path}: not a features file, it has no "format": "{FORMAT}"')
    version = record.get("version")
    if not isinstance(version, int) or version < 1:
        raise UnreadableFile(f"{path}: version is {version!r}, a number from 1 is allowed")
    if version > VERSION:
        raise TooNewFile(
            f"{path}: version {version}, this neurframe reads up to {VERSION}", hint="update neurframe"
        )
    return record


def _vertex_numbers(path: Path, name: str, value: Any) -> Ints:
    """A JSON list of vertex numbers, or of pairs of them, as int64."""
    try:
        array = np.array(value)
    except ValueError as error:
        raise UnreadableFile(f"{path}: {name} is ragged") from error
    if array.size == 0:
        return np.zeros(0, np.int64)
    pairs = name == "edges"
    if array.dtype.kind != "i" or array.ndim != (2 if pairs else 1) or (pairs and array.shape[1] != 2):
        raise UnreadableFile(f"{path}: {name} is not a list of vertex {'pairs' if pairs else 'numbers'}")
    if array.min() < 0:
        raise UnreadableFile(f"{path}: {name} has the negative vertex number {int(array.min())}")
    return array.astype(np.int64)

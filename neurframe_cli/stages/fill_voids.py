"""Stage --fill: a flawed hex mesh becomes a conforming one of hexes, pyramids and tets."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from neurframe_cli.errors import ChildCrashed, StageError
from neurframe_cli.mesh.arrays import Bools, Floats, Ints, Progress, Surface, TetMesh, silent
from neurframe_cli.mesh.filling.hybrid_mesh import HybridMesh, HybridNumbers, measure_hybrid
from neurframe_cli.mesh.filling.pyramids import pyramid_apexes, side_triangles
from neurframe_cli.mesh.filling.remesh_patch import remesh_patch
from neurframe_cli.mesh.filling.sound_hexes import HexFaces, SoundOptions, measure_faces, peeled, sound_hexes
from neurframe_cli.mesh.filling.uncovered import CutFailed, uncovered_part
from neurframe_cli.mesh.hex_shell import HexShell, hex_shell
from neurframe_cli.mesh.self_intersections import intersecting_pairs

# tets (V, T) in a closed surface, whose triangles stay, with edges of about the length given
Tetrahedralizer = Callable[[Surface, float], TetMesh]


@dataclass(frozen=True)
class FillOptions:
    """sound: which hexes stay at first; attempts: how often hexes are given up where the void could not be filled."""

    sound: SoundOptions = field(default_factory=SoundOptions)
    attempts: int = 12


@dataclass(frozen=True)
class FilledMesh:
    """The mesh, its numbers, which hexes (n,) of the flawed mesh are in it, and why some were given up on the way."""

    mesh: HybridMesh
    numbers: HybridNumbers
    kept: Bools
    obstacles: tuple[str, ...]


class _Obstacle(Exception):
    """Why a void could not be filled, and the hexes that are in the way."""

    def __init__(self, reason: str, hexes: Ints) -> None:
        super().__init__(reason)
        self.hexes = np.unique(hexes)


def fill_voids(
    V: Floats,
    H: Ints,
    surface: Surface,
    sharp: Ints,
    tetrahedralize: Tetrahedralizer,
    options: FillOptions | None = None,
    progress: Progress = silent,
) -> FilledMesh:
    """Hexes H (n,8) in VTK order over V (v,3), the bad ones replaced and the voids filled.

    surface: closed, what the hexes were made in; sharp (k,2): its feature edges.  Quads of hexes that stay are
    covered by another hex, a pyramid, or nothing where they lie on the surface; the rest of the surface is meshed
    anew.  Raises StageError where nothing helped.
    """
    options = options or FillOptions()
    faces = measure_faces(V, H, surface)
    kept = sound_hexes(V, H, faces, surface, options.sound)
    obstacles: list[str] = []
    for attempt in range(options.attempts):
        progress(attempt / options.attempts, f"{int(kept.sum())} of {len(H)} hexes stay")
        try:
            mesh = _filled(V, H, faces, kept, surface, sharp, tetrahedralize)
        except _Obstacle as obstacle:
            obstacles.append(f"{obstacle} ({len(obstacle.hexes)} hexes given up)")
            kept[obstacle.hexes] = False
            kept = peeled(H, faces, kept)
            continue
        return FilledMesh(mesh, measure_hybrid(mesh), kept, tuple(obstacles))
    raise StageError(
        f"the voids could not be filled: {'; '.join(obstacles)}", hint="the partial hex mesh is kept"
    )


def _filled(
    V: Floats,
    H: Ints,
    faces: HexFaces,
    kept: Bools,
    surface: Surface,
    sharp: Ints,
    tetrahedralize: Tetrahedralizer,
) -> HybridMesh:
    """One attempt; raises _Obstacle."""
    shell = hex_shell(H, kept)
    covers = faces.covers[shell.faces]
    edge_length = float(np.median(faces.size))
    points, patch = _outer_patch(V, shell, covers, faces, surface, sharp, edge_length)
    free = shell.quads[~covers]
    apex, room = pyramid_apexes(points, free, patch)
    if not room.all():
        raise _Obstacle("no room for pyramids", shell.owner[~covers][~room])
    apexes = len(points) + np.arange(len(free))
    points = np.concatenate([points, apex])
    sides = side_triangles(free, apexes)
    void = np.concatenate([patch, sides])
    if not len(void):
        return _compact(HybridMesh(V, H[kept], np.zeros((0, 5), np.int64), np.zeros((0, 4), np.int64)))
    _refuse_intersections(points, void, shell, covers)
    used, local = np.unique(void, return_inverse=True)
    try:
        tets = tetrahedralize(Surface(points[used], local.reshape(-1, 3)), edge_length)
    except ChildCrashed as error:
        raise _Obstacle(str(error), shell.owner[~covers]) from error
    numbers = np.concatenate([used, len(points) + np.arange(len(tets.V) - len(used))])
    points = np.concatenate([points, tets.V[len(used) :]])
    pyramids = np.column_stack([free, apexes])
    return _compact(HybridMesh(points, H[kept], pyramids, numbers[tets.T]))


def _outer_patch(
    V: Floats,
    shell: HexShell,
    covers: Bools,
    faces: HexFaces,
    surface: Surface,
    sharp: Ints,
    edge_length: float,
) -> tuple[Floats, Ints]:
    """V with further points (m,3), and triangles (t,3) over them: the part of the surface that no hex covers."""
    try:
        open_part = uncovered_part(V, shell.quads, covers, faces.size[shell.faces], surface, sharp)
    except CutFailed as failure:
        raise _Obstacle("the surface could not be cut", _hexes_at(shell, failure.vertices)) from failure
    patch, of_patch = open_part.patch, open_part.hex_vertex
    left = remesh_patch(patch, set(of_patch), edge_length)
    if left:
        at = {of_patch[w] for v in left for w in patch.neighbors(v) if w in of_patch}
        raise _Obstacle("the rim could not be straightened", _hexes_at(shell, at))
    P, F, _ = patch.arrays()
    new = np.setdiff1d(np.unique(F), np.array(sorted(of_patch), np.int64))
    number = np.full(len(P), -1)
    number[new] = len(V) + np.arange(len(new))
    for v, hex_vertex in of_patch.items():
        number[v] = hex_vertex
    return np.concatenate([V, P[new]]), number[F]


def _hexes_at(shell: HexShell, vertices: set[int]) -> Ints:
    """Hexes of the shell that have one of the vertices."""
    return np.unique(shell.owner[np.isin(shell.quads, sorted(vertices)).any(axis=1)])


def _refuse_intersections(points: Floats, void: Ints, shell: HexShell, covers: Bools) -> None:
    """Raises _Obstacle with the hexes next to where the surface of the void runs through itself."""
    from scipy.spatial import cKDTree

    pairs = intersecting_pairs(points, void)
    if not len(pairs):
        return
    places = points[void[pairs.ravel()]].reshape(-1, 3)
    free = np.flatnonzero(~covers)
    centres = points[shell.quads[free]].mean(axis=1)
    nearest = cKDTree(centres).query(places)[1] if len(free) else np.zeros(0, np.int64)
    raise _Obstacle(f"{len(pairs)} triangles round the void cross others", shell.owner[free[nearest]])


def _compact(mesh: HybridMesh) -> HybridMesh:
    """The mesh without vertices that no cell has."""
    cells = (mesh.hexes, mesh.pyramids, mesh.tets)
    used = np.unique(np.concatenate([block.ravel() for block in cells]))
    number = np.full(len(mesh.V), -1)
    number[used] = np.arange(len(used))
    return HybridMesh(mesh.V[used], *(number[block] for block in cells))

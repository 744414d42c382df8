"""A mesh of hexes, pyramids and tets, and whether it is one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints
from neurframe_cli.mesh.filling.pyramids import base_jacobians
from neurframe_cli.mesh.hex_shell import HEX_FACES
from neurframe_cli.mesh.quality.scaled_jacobian import hex_scaled_jacobians
from neurframe_cli.mesh.tet_adjacency import TET_FACES

PYRAMID_SIDES = np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]])
PYRAMID_BASE = np.array([[0, 3, 2, 1]])


@dataclass(frozen=True)
class HybridMesh:
    """V (n,3); hexes (h,8), pyramids (p,5: base, seen from the apex counter-clockwise, then apex) and tets (t,4), in
    VTK order."""

    V: Floats
    hexes: Ints
    pyramids: Ints
    tets: Ints


@dataclass(frozen=True)
class HybridNumbers:
    """Cells by kind; share of the volume in hexes; volume; faces in more than two cells, or in two on the same side;
    hexes and pyramids with a corner Jacobian <= 0, tets with a volume <= 0; worst quality of each kind (hexes scaled
    Jacobian, pyramids the same at the base, tets 6 sqrt(2) volume / longest edge cubed)."""

    hexes: int
    pyramids: int
    tets: int
    hex_volume_share: float
    volume: float
    nonconforming_faces: int
    open_edges: int
    inverted: int
    worst_hex: float
    worst_pyramid: float
    worst_tet: float

    @property
    def valid(self) -> bool:
        return self.nonconforming_faces == self.inverted == self.open_edges == 0


def cell_faces(mesh: HybridMesh) -> tuple[Ints, Ints]:
    """Outward quads (q,4) and triangles (f,3) of all cells."""
    quads = [mesh.hexes[:, HEX_FACES].reshape(-1, 4), mesh.pyramids[:, PYRAMID_BASE].reshape(-1, 4)]
    triangles = [mesh.pyramids[:, PYRAMID_SIDES].reshape(-1, 3), mesh.tets[:, TET_FACES].reshape(-1, 3)]
    return np.concatenate(quads), np.concatenate(triangles)


def outer_faces(mesh: HybridMesh) -> tuple[Ints, Ints]:
    """Quads (q,4) and triangles (f,3) of exactly one cell, outward."""
    quads, triangles = cell_faces(mesh)
    return _single(quads), _single(triangles)


def measure_hybrid(mesh: HybridMesh) -> HybridNumbers:
    """What the mesh is; conforming means that faces of two cells are seen from both sides and the rest is closed."""
    quads, triangles = cell_faces(mesh)
    hexes = hex_scaled_jacobians(mesh.V, mesh.hexes).min(axis=1)
    pyramids = base_jacobians(mesh.V, mesh.pyramids[:, :4], mesh.V[mesh.pyramids[:, 4]]).min(axis=1)
    tets = _tet_quality(mesh)
    volumes = [_volume_inside(mesh.V, *faces) for faces in _faces_by_kind(mesh)]
    return HybridNumbers(
        hexes=len(hexes),
        pyramids=len(pyramids),
        tets=len(tets),
        hex_volume_share=volumes[0] / sum(volumes),
        volume=sum(volumes),
        nonconforming_faces=_nonconforming(quads) + _nonconforming(triangles),
        open_edges=_open_edges(_single(quads), _single(triangles)),
        inverted=sum(int((quality <= 0.0).sum()) for quality in (hexes, pyramids, tets)),
        worst_hex=float(hexes.min(initial=1.0)),
        worst_pyramid=float(pyramids.min(initial=1.0)),
        worst_tet=float(tets.min(initial=1.0)),
    )


def _faces_by_kind(mesh: HybridMesh) -> list[tuple[Ints, Ints]]:
    nothing = {8: mesh.hexes[:0], 5: mesh.pyramids[:0], 4: mesh.tets[:0]}
    return [
        cell_faces(HybridMesh(mesh.V, mesh.hexes, nothing[5], nothing[4])),
        cell_faces(HybridMesh(mesh.V, nothing[8], mesh.pyramids, nothing[4])),
        cell_faces(HybridMesh(mesh.V, nothing[8], nothing[5], mesh.tets)),
    ]


def _volume_inside(V: Floats, quads: Ints, triangles: Ints) -> float:
    """By the divergence theorem; a bent quad counts as the mean of its two triangulations, its bilinear patch."""
    halves = [quads[:, rows] for rows in ([0, 1, 2], [0, 2, 3], [0, 1, 3], [1, 2, 3])]
    half = sum(_cone_volume(V, triangle) for triangle in halves) / 2
    return half + _cone_volume(V, triangles)


def _cone_volume(V: Floats, F: Ints) -> float:
    a, b, c = (V[F[:, i]] for i in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


def _tet_quality(mesh: HybridMesh) -> Floats:
    corners = mesh.V[mesh.tets]
    volume = np.linalg.det(corners[:, 1:] - corners[:, :1])
    longest = np.linalg.norm(corners[:, :, None] - corners[:, None], axis=-1).max(axis=(1, 2), initial=0.0)
    return np.asarray(np.sqrt(2.0) * volume / np.maximum(longest, 1e-300) ** 3)


def _single(faces: Ints) -> Ints:
    _, first, use = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    return np.asarray(faces[np.sort(first[use == 1])])


def _nonconforming(faces: Ints) -> int:
    """Faces in more than two cells, and those that two cells have on the same side or with another diagonal."""
    keys = np.sort(faces, axis=1)
    _, which, use = np.unique(keys, axis=0, return_inverse=True, return_counts=True)
    which = which.reshape(-1)
    start = np.argmin(faces, axis=1)
    turned = np.take_along_axis(faces, (start[:, None] + np.arange(faces.shape[1])) % faces.shape[1], axis=1)
    order = np.argsort(which, kind="stable")
    pairs = order[np.isin(which[order], np.flatnonzero(use == 2))].reshape(-1, 2)
    one, other = turned[pairs[:, 0]], turned[pairs[:, 1]]
    opposite = (one[:, 1:] == other[:, :0:-1]).all(axis=1)
    return int((use > 2).sum() + (~opposite).sum())


def _open_edges(quads: Ints, triangles: Ints) -> int:
    """Edges of the outside that are not run along once in each direction."""
    ends = [
        np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2) for faces in (quads, triangles)
    ]
    directed = np.concatenate(ends)
    edges, use = np.unique(directed, axis=0, return_counts=True)
    size = int(directed.max(initial=0)) + 1
    forward, backward = edges @ np.array([size, 1]), edges @ np.array([1, size])
    return int((~np.isin(forward, backward)).sum() + (use > 1).sum())

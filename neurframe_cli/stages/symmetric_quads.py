"""Quads with an exact mirror symmetry: one half is meshed with the cut as an integer line, then mirrored and welded."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from neurframe_cli.errors import InvalidMesh
from neurframe_cli.field.surface_cross_field import relaxed_cross_field
from neurframe_cli.mesh.arrays import Features, Floats, Ints, Surface
from neurframe_cli.mesh.measure import box_diagonal
from neurframe_cli.mesh.optimize.simplex_tree import SimplexTree
from neurframe_cli.mesh.quality.polygons import unique_edges
from neurframe_cli.mesh.surface_edges import face_normals
from neurframe_cli.stages.mirror_plane import HalfSurface, MirrorPlane, cut_off, features_of_half

CARRIER_SNAP, MODEL_SNAP = 0.25, 1e-6  # in mean edges at the vertex
IN_PLANE = 1e-6  # bounding-box diagonals: what the smoothing of a rim in the plane may lose to rounding
MANTISSA_BITS = 52


@dataclass(frozen=True)
class HalfModel:
    """The half of the model to smooth and its features; the half of the carrier with its crosses (m,2,3)."""

    surface: Surface
    features: Features
    carrier: HalfSurface
    crosses: Floats


def half_model(
    plane: MirrorPlane,
    surface: Surface,
    features: Features,
    carrier: Surface,
    crosses: Floats,
    carrier_features: Features,
) -> HalfModel:
    """Everything on the positive side of the plane.

    The crosses are the mean of those there and of the mirror images of those on the other side, turned to the cut
    and smoothed near it.
    """
    model = cut_off(surface, plane, MODEL_SNAP)
    half = cut_off(carrier, plane, CARRIER_SNAP)
    V, F = half.surface.V, half.surface.F
    opposite = SimplexTree(carrier.V, carrier.F).closest(plane.mirror(V[F].mean(axis=1))).simplices
    own, other = crosses[half.parents, 0], plane.reflect(crosses[opposite])
    normals = face_normals(V, F)
    # a cross has four directions and either stands for it; the one that lies flatter survives the projection better
    flatter = np.abs(np.einsum("mkd,md->mk", other, normals)).argmin(axis=1)
    directions = np.stack([own, other[np.arange(len(F)), flatter]])
    followed = features_of_half(half, carrier_features).edges
    relaxed = relaxed_cross_field(V, F, followed, directions)
    return HalfModel(model.surface, features_of_half(model, features), half, relaxed)


def mirrored_quads(V: Floats, Q: Ints, plane: MirrorPlane) -> tuple[Floats, Ints]:
    """The quads Q (q,4) over V (n,3) and their mirror images, sharing the vertices of the rim in the plane.

    Every coordinate is a mirror image to the last bit: heights over the plane and its offset are multiples of a power
    of two, so large that their sums and differences are exact.  Raises InvalidMesh where the rim left the plane.
    """
    height = plane.height(V)
    edges, use = unique_edges(Q)
    rim = np.unique(edges[use == 1])
    close = IN_PLANE * box_diagonal(V)
    welded = np.zeros(len(V), bool)
    welded[rim] = np.abs(height[rim]) <= close
    beyond = np.unique(Q)[~welded[np.unique(Q)]]
    if (height[beyond] <= 0.0).any():
        raise InvalidMesh(
            f"{int((height[beyond] <= 0.0).sum())} vertices of the half mesh lie beyond the mirror plane"
        )
    unit = 2.0 ** (np.ceil(np.log2(abs(plane.offset) + height.max())) - MANTISSA_BITS)
    offset = unit * np.round(plane.offset / unit)
    steps = np.where(welded, 0.0, unit * np.round(height / unit))
    here, there = V.copy(), V[~welded].copy()
    here[:, plane.axis] = offset + steps
    there[:, plane.axis] = offset - steps[~welded]
    image = np.arange(len(V))
    image[~welded] = len(V) + np.arange(len(there))
    return np.concatenate([here, there]), np.concatenate([Q, image[Q][:, ::-1]])

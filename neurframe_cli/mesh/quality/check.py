"""The verdict on a quad or hex mesh: its numbers, and in words what makes it invalid."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from neurframe_cli.mesh.arrays import Features, Floats, Ints, Surface
from neurframe_cli.mesh.hex_shell import HEX_FACES
from neurframe_cli.mesh.measure import box_diagonal, enclosed_volume
from neurframe_cli.mesh.quality.distance import SurfaceDistance, surface_distance
from neurframe_cli.mesh.quality.feature_recall import feature_recall
from neurframe_cli.mesh.quality.hex_singular_graph import hex_singular_graph
from neurframe_cli.mesh.quality.polygons import (
    topology,
    topology_problems,
    triangulated,
    unique_edges,
    valences,
)
from neurframe_cli.mesh.quality.scaled_jacobian import hex_scaled_jacobians, quad_scaled_jacobians


@dataclass(frozen=True)
class CheckOptions:
    """hausdorff_limit in bounding-box diagonals; samples a surface; recall tolerance in median edge lengths."""

    hausdorff_limit: float = 0.01
    samples: int = 50_000
    recall_tolerance: float = 0.1
    seed: int = 0


@dataclass(frozen=True)
class Verdict:
    """numbers: every measure by name (lengths in bounding-box diagonals of the input); problems: empty if valid."""

    numbers: dict[str, Any]
    problems: list[str]

    @property
    def valid(self) -> bool:
        return not self.problems


def check_quads(V: Floats, Q: Ints, against: Surface, features: Features, options: CheckOptions) -> Verdict:
    """Check quads Q (n,4): every edge in at most two quads (in two where the input is closed), then what all share."""
    edges, use = unique_edges(Q)
    jacobians = quad_scaled_jacobians(V, Q).min(axis=1)
    closed = bool((unique_edges(against.F)[1] == 2).all())
    irregular = (valences(edges, len(V)) != 4) & np.isin(np.arange(len(V)), edges[use == 2])
    numbers = {
        "kind": "quad",
        "cells": len(Q),
        **_jacobian_numbers(jacobians),
        "edges_in_over_two": int((use > 2).sum()),
        "boundary_edges": int((use == 1).sum()),
        "irregular_vertices": int((irregular & ~np.isin(np.arange(len(V)), edges[use == 1])).sum()),
    }
    problems = [f"{numbers['edges_in_over_two']} edges in more than two quads"] if (use > 2).any() else []
    if closed and (use == 1).any():
        problems.append(f"{numbers['boundary_edges']} open edges on a closed input")
    return _conclude(V, Q, against, features, options, numbers, problems)


def check_hexes(V: Floats, H: Ints, against: Surface, features: Features, options: CheckOptions) -> Verdict:
    """Check hexes H (n,8, VTK order): conforming, closed boundary, then what all share; volume against the input's."""
    faces = H[:, HEX_FACES].reshape(-1, 4)
    _, first, use = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    shell = faces[first[use == 1]]
    shell_use = unique_edges(shell)[1]
    worst, volume = hex_scaled_jacobians(V, H).min(axis=1), enclosed_volume(against.V, against.F)
    repeated = int((np.diff(np.sort(H, axis=1), axis=1) == 0).any(axis=1).sum())
    numbers = {
        "kind": "hex",
        "cells": len(H),
        **_jacobian_numbers(worst),
        "repeated_corners": repeated,
        "faces_in_over_two": int((use > 2).sum()),
        "open_shell_edges": int((shell_use != 2).sum()),
        **hex_singular_graph(H).summary(),
        "volume_ratio": enclosed_volume(V, triangulated(shell)) / volume,
        "valid_volume_share": float(_hex_volumes(V, H[worst > 0.0]).sum()) / volume,
    }
    problems = [f"{repeated} cells repeat a corner"] if repeated else []
    if (use > 2).any():
        problems.append(f"{numbers['faces_in_over_two']} faces in more than two cells")
    if (shell_use != 2).any():
        problems.append(f"{numbers['open_shell_edges']} boundary edges not in two boundary faces")
    return _conclude(V, shell, against, features, options, numbers, problems)


def _jacobian_numbers(worst: Floats) -> dict[str, Any]:
    return {
        "min_scaled_jacobian": float(worst.min()),
        "p1_scaled_jacobian": float(np.percentile(worst, 1)),
        "mean_scaled_jacobian": float(worst.mean()),
        "inverted": int((worst <= 0).sum()),
        "worst_cells": [int(i) for i in np.argsort(worst, kind="stable")[:10]],
    }


def _hex_volumes(V: Floats, H: Ints) -> Floats:
    """Volume (n,) of hexes (n,8) with two triangles a face."""
    P = V[H]
    quads = P[:, HEX_FACES] - P.mean(axis=1)[:, None, None]
    a, b, c, d = np.moveaxis(quads, 2, 0)
    cones = np.einsum("nfi,nfi->nf", a, np.cross(b, c) + np.cross(c, d))
    return np.asarray(cones.sum(axis=1) / 6)


def _worse_distance(
    V: Floats, Q: Ints, against: Surface, samples: int, rng: np.random.Generator
) -> SurfaceDistance:
    """Distance of the quads to the surface, for the worse of their two triangulations: a bent quad is neither."""
    return max(
        (
            surface_distance(Surface(V, triangulated(np.roll(Q, turn, axis=1))), against, samples, rng)
            for turn in (0, 1)
        ),
        key=lambda distance: distance.hausdorff,
    )


def _conclude(
    V: Floats,
    Q: Ints,
    against: Surface,
    features: Features,
    options: CheckOptions,
    numbers: dict[str, Any],
    problems: list[str],
) -> Verdict:
    """Add what quad meshes and the boundaries of hex meshes share: folds, topology, distance, feature recall."""
    diagonal = box_diagonal(against.V[np.unique(against.F)])
    edges, _ = unique_edges(Q)
    median_edge = float(np.median(np.linalg.norm(V[edges[:, 0]] - V[edges[:, 1]], axis=1)))
    if numbers["inverted"]:
        problems.append(f"{numbers['inverted']} cells with a corner Jacobian <= 0")
    components, euler = topology(Q)
    problems += topology_problems(Q, against.F)
    rng = np.random.default_rng(options.seed)
    distance = _worse_distance(V, Q, against, options.samples, rng)
    if distance.hausdorff > options.hausdorff_limit * diagonal:
        problems.append(f"Hausdorff distance {distance.hausdorff / diagonal:.4f} of the diagonal")
    tolerance = options.recall_tolerance * median_edge
    numbers |= {
        "components": components,
        "euler_characteristic": euler,
        "hausdorff": distance.hausdorff / diagonal,
        "mean_distance": distance.mean / diagonal,
        "median_edge": median_edge / diagonal,
        "feature_recall": feature_recall(against.V, features.edges, V, edges, tolerance),
    }
    return Verdict(numbers, problems)

"""Features that let go of vertices."""

from __future__ import annotations

import numpy as np

from neurframe_cli.mesh.arrays import Ints, Surface
from neurframe_cli.mesh.optimize.constraints import ON_CURVE, ON_SURFACE, PINNED, Constraints, Track
from neurframe_cli.mesh.optimize.simplex_tree import SimplexTree


def let_go(constraints: Constraints, surface: Surface, cells: Ints) -> Constraints:
    """The same, but corners and curves let go of the vertices of `cells` (k,8), which slide on the surface then: where
    an edge of the mesh runs across a feature, or two features are closer than a hex is wide, a hex between them is flat
    wherever its vertices slide."""
    kind = constraints.kind.copy()
    chosen = np.zeros(len(kind), bool)
    chosen[cells] = True
    chosen &= (kind == ON_CURVE) | (kind == PINNED)
    kind[chosen] = ON_SURFACE
    tracks = [Track(track.tree, track.vertices[~chosen[track.vertices]]) for track in constraints.tracks]
    tracks.append(Track(SimplexTree(surface.V, surface.F), np.flatnonzero(chosen)))
    return Constraints(kind, constraints.pins, [track for track in tracks if len(track.vertices)])

"""Tubes around segments."""

from __future__ import annotations

import numpy as np

from neurframe_cli.mesh.arrays import Floats, Ints

SIDES = 6


def tubes(V: Floats, edges: Ints, radius: float) -> tuple[Floats, Ints]:
    """Vertices (2·6·k,3) and quads (6·k,4) of open prisms of `radius` around the segments edges (k,2) of V (n,3)."""
    ends = V[edges]
    along = ends[:, 1] - ends[:, 0]
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-300)
    # any direction across: begin with the coordinate axis that is least along the segment
    across = np.cross(along, np.eye(3)[np.abs(along).argmin(axis=1)])
    across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-300)
    angles = 2 * np.pi * np.arange(SIDES) / SIDES
    ring = np.cos(angles)[:, None, None] * across + np.sin(angles)[:, None, None] * np.cross(along, across)
    points = ends[:, :, None, :] + radius * ring.transpose(1, 0, 2)[:, None]
    side = np.arange(SIDES)
    ahead = (side + 1) % SIDES
    prism = np.stack([side, ahead, SIDES + ahead, SIDES + side], axis=1)
    quads = prism[None] + 2 * SIDES * np.arange(len(edges))[:, None, None]
    return points.reshape(-1, 3), quads.reshape(-1, 4)

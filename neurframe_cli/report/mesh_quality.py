"""How good the cells of a mesh are, cell by cell: histogram and worst cells with their places."""

from __future__ import annotations

from typing import Any

import numpy as np

from neurframe_cli.mesh.arrays import Floats
from neurframe_cli.mesh.quality.scaled_jacobian import hex_scaled_jacobians, quad_scaled_jacobians
from neurframe_cli.mesh.read_cells import CellMesh

BIN_WIDTH = 0.05
WORST = 10


def cell_quality(mesh: CellMesh) -> Floats:
    """(m,) the worst scaled Jacobian of each cell's corners."""
    corners = quad_scaled_jacobians if mesh.kind == "quad" else hex_scaled_jacobians
    return np.asarray(corners(mesh.V, mesh.cells).min(axis=1))


def describe_quality(mesh: CellMesh, quality: Floats) -> dict[str, Any]:
    """JSON: `histogram` with its bin `edges` (k+1,) and `counts` (k,), and the `worst` cells, the worst one first."""
    first = min(np.floor(quality.min() / BIN_WIDTH), 0.0)
    edges = np.arange(first, round(1 / BIN_WIDTH) + 1) * BIN_WIDTH
    # rounding can bring the Jacobian of a perfect corner to 1 + 1e-16
    counts, _ = np.histogram(np.clip(quality, edges[0], 1.0), edges)
    worst = np.argsort(quality, kind="stable")[:WORST]
    centers = mesh.V[mesh.cells[worst]].mean(axis=1)
    return {
        "cells": len(mesh.cells),
        "vertices": len(mesh.V),
        "histogram": {"edges": [round(float(edge), 10) for edge in edges], "counts": counts.tolist()},
        "worst": [
            {"cell": int(cell), "scaled_jacobian": float(quality[cell]), "at": center.tolist()}
            for cell, center in zip(worst, centers, strict=True)
        ],
    }

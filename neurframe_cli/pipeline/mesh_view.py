"""One mesh file as a page: what it is, how good it is, and the 3D view."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup

from neurframe_cli.errors import InvalidMesh, UnreadableFile, UnsupportedFormat
from neurframe_cli.mesh.arrays import Floats, Surface
from neurframe_cli.mesh.load import load_model
from neurframe_cli.mesh.read_cells import CellMesh, read_cells
from neurframe_cli.mesh.tet_adjacency import tet_adjacency
from neurframe_cli.pipeline.checking import used_only
from neurframe_cli.pipeline.report_scene import mesh_layers, surface_layers
from neurframe_cli.report.figures import quality_figure
from neurframe_cli.report.layers import Layer
from neurframe_cli.report.mesh_quality import cell_quality, describe_quality
from neurframe_cli.report.page import render_mesh
from neurframe_cli.report.scene import scene_document


def mesh_page(path: Path) -> str:
    """The HTML of a quad, hex, tet or triangle mesh; raises UnreadableFile, UnsupportedFormat, InvalidMesh."""
    cells = _cells(path)
    if cells is not None:
        return _cells_page(path, cells)
    loaded = load_model(path)
    if isinstance(loaded, Surface):
        facts = {"triangles": len(loaded.F), "vertices": len(loaded.V)}
        return _surface_page(path, loaded, f"triangle mesh, {len(loaded.F):,} triangles", facts)
    tets = loaded[0]
    shell = used_only(tets.V, tet_adjacency(tets.T).boundary_faces)
    facts = {"tets": len(tets.T), "vertices": len(tets.V), "boundary triangles": len(shell.F)}
    return _surface_page(path, shell, f"tet mesh, {len(tets.T):,} tets", facts)


def _cells(path: Path) -> CellMesh | None:
    """The quads or hexes of the file, None where there are none."""
    try:
        return read_cells(path)
    except (InvalidMesh, UnsupportedFormat, UnreadableFile):
        # triangles or tets, perhaps in a format of their own: load_model knows, and says what else is wrong
        return None


def _cells_page(path: Path, mesh: CellMesh) -> str:
    quality = cell_quality(mesh)
    described = describe_quality(mesh, quality)
    facts = {
        f"{'hexes' if mesh.kind == 'hex' else 'quads'}": len(mesh.cells),
        "vertices": len(mesh.V),
        **_extent(mesh.V),
        "worst scaled Jacobian": float(quality.min()),
        "mean scaled Jacobian": float(quality.mean()),
        "cells with a corner Jacobian <= 0": int((quality <= 0).sum()),
    }
    layers, cut = mesh_layers(mesh, shown=True)
    return render_mesh(
        path.name, facts, quality_figure(described["histogram"], mesh.kind), scene_document(layers, cut)
    )


def _surface_page(path: Path, surface: Surface, title: str, facts: dict[str, Any]) -> str:
    mesh = Layer(title, surface.V, surface.F, edges=True)
    sharp = surface_layers(surface, shown=False)[0]
    return render_mesh(path.name, {**facts, **_extent(surface.V)}, Markup(""), scene_document([mesh, sharp]))


def _extent(V: Floats) -> dict[str, Any]:
    low, high = V.min(axis=0), V.max(axis=0)
    return {"bounding box": [*low.tolist(), *high.tolist()], "diagonal": float(np.linalg.norm(high - low))}

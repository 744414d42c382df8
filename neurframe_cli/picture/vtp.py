"""The field as .vtp files, for ParaView and the like."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from neurframe_cli.field.singular_edges import SingularEdges
from neurframe_cli.mesh.arrays import Floats, Surface
from neurframe_cli.picture.scene import polydata


def write_crosses_vtp(path: Path, surface: Surface, crosses: Floats) -> None:
    """The triangles with the two vectors of their crosses (m,2,3) as cell data `u` and `v`."""
    mesh = polydata(surface.V, faces=surface.F)
    mesh.cell_data["u"], mesh.cell_data["v"] = crosses[:, 0], crosses[:, 1]
    mesh.save(path)


def write_singular_edges_vtp(path: Path, V: Floats, singular: SingularEdges) -> None:
    """The singular edges as lines over their own vertices, with `quarters`, `turn` and `axis_angle_deg`."""
    used, lines = np.unique(singular.edges, return_inverse=True)
    mesh = polydata(V[used], lines=lines.reshape(-1, 2))
    mesh.cell_data["quarters"], mesh.cell_data["turn"] = singular.quarters, singular.turn
    mesh.cell_data["axis_angle_deg"] = singular.axis_angle_deg
    mesh.save(path)

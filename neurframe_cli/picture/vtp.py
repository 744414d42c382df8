"""The field as .vtp files, for ParaView and the like."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from neurframe_cli.field.singular_edges import SingularEdges
from neurframe_cli.mesh.arrays import Floats, Ints, Surface
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


def write_singular_points_vtp(path: Path, points: Floats, quarters: Ints, turn: Ints, axis: Floats) -> None:
    """Points (k,3) of the singular graph with `quarters`, `turn` and rotation `axis` as point data."""
    mesh = polydata(points)
    mesh.point_data["quarters"], mesh.point_data["turn"], mesh.point_data["axis"] = quarters, turn, axis
    mesh.save(path)


def write_streamlines_vtp(path: Path, volume: Sequence[Floats], surface: Sequence[Floats]) -> None:
    """Polylines through the volume and on the surface; cell data `on_surface` tells them apart."""
    import pyvista

    lines = [*volume, *surface]
    lengths = np.array([len(line) for line in lines], np.int64)
    starts = np.concatenate([[0], np.cumsum(lengths)])
    cells = [np.concatenate([[n], np.arange(a, a + n)]) for a, n in zip(starts[:-1], lengths, strict=True)]
    points = np.concatenate(lines) if lines else np.zeros((0, 3))
    mesh = pyvista.PolyData(points, lines=np.concatenate(cells) if cells else None)
    mesh.cell_data["on_surface"] = np.repeat([0, 1], [len(volume), len(surface)])
    mesh.save(path)

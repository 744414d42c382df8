"""Reading back the .vtp files of a workspace, without the weight of pyvista."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from neurframe_cli.errors import UnreadableFile
from neurframe_cli.mesh.arrays import Floats, Ints
from neurframe_cli.mesh.open_file import check_file


@dataclass(frozen=True)
class PolyLines:
    """Points (n,3), the segments (k,2) of all polylines, and for each segment the number of its polyline (k,).

    data: the arrays of the file by name, of points and of cells.
    """

    points: Floats
    segments: Ints
    line: Ints
    data: dict[str, Any]


def read_vtp(path: Path) -> PolyLines:
    """Points and lines of a .vtp file; raises UnreadableFile."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOXML import vtkXMLPolyDataReader

    check_file(path)
    name: Any = os.fsencode(path)  # bytes, which VTK takes, whatever its stubs say: a name need be no Unicode
    reader = vtkXMLPolyDataReader()
    reader.SetFileName(name)
    if not reader.CanReadFile(name):
        raise UnreadableFile(f"{path} is no VTK file of polygons and lines")
    if not _updated(reader):
        raise UnreadableFile(f"{path} is damaged")
    mesh = reader.GetOutput()
    points = mesh.GetPoints()
    lines = mesh.GetLines()
    offsets = vtk_to_numpy(lines.GetOffsetsArray()).astype(np.int64)
    corners = vtk_to_numpy(lines.GetConnectivityArray()).astype(np.int64)
    first = np.delete(np.arange(len(corners)), np.maximum(offsets[1:] - 1, 0)) if len(corners) else corners
    tables = (mesh.GetPointData(), mesh.GetCellData())
    return PolyLines(
        np.zeros((0, 3)) if points is None else vtk_to_numpy(points.GetData()).astype(np.float64),
        np.stack([corners[first], corners[first + 1]], axis=1) if len(first) else np.zeros((0, 2), np.int64),
        np.searchsorted(offsets, first, side="right") - 1,
        {
            t.GetArrayName(i): vtk_to_numpy(t.GetArray(i))
            for t in tables
            for i in range(t.GetNumberOfArrays())
        },
    )


def _updated(reader: Any) -> bool:
    """Whether the reader could read its file; what it has to say of one that it cannot goes to nobody's screen."""
    from vtkmodules.vtkCommonCore import vtkObject

    shown = vtkObject.GetGlobalWarningDisplay()
    vtkObject.SetGlobalWarningDisplay(0)
    try:
        return bool(reader.GetExecutive().Update()) and not reader.GetErrorCode()
    finally:
        vtkObject.SetGlobalWarningDisplay(shown)

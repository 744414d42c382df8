"""A model from a file, whatever it is: surface or tet mesh."""

from __future__ import annotations

from pathlib import Path

from neurframe_cli.mesh.arrays import Features, Surface, TetMesh
from neurframe_cli.mesh.file_format import CELL_FORMATS, file_format
from neurframe_cli.mesh.read_surface import read_surface, surface_from_cells
from neurframe_cli.mesh.read_tets import CELL_READERS, tets_from_cells


def load_model(path: Path) -> Surface | tuple[TetMesh, Features]:
    """The tets and features of a file that has tets, else its triangles as they stand there.

    Raises UnreadableFile, UnsupportedFormat, InvalidMesh.
    """
    name = file_format(path)
    if name not in CELL_FORMATS:
        return read_surface(path)
    cells = CELL_READERS[name](path)
    has_tets = len(cells.tets) > 0
    return tets_from_cells(path, cells) if has_tets else surface_from_cells(path, cells)

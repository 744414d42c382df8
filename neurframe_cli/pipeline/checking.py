"""Checking a mesh file against the model that it was made from."""

from __future__ import annotations

from pathlib import Path

from neurframe_cli.mesh.arrays import Features, Floats, Ints, Surface
from neurframe_cli.mesh.filling.hybrid_files import is_hybrid, read_hybrid
from neurframe_cli.mesh.quality.check import CheckOptions, Verdict, check_hexes, check_quads
from neurframe_cli.mesh.quality.check_hybrid import check_hybrid
from neurframe_cli.mesh.read_cells import read_cells
from neurframe_cli.pipeline.atomic import write_error


def check_file_against(mesh: Path, model: Path, feature_angle_deg: float) -> Verdict:
    """Verdict on the mesh in `mesh`, of quads, of hexes, or of hexes with pyramids and tets, made from the surface
    or tets in `model`."""
    from neurframe_cli.mesh.features import features_by_angle

    surface = load_surface(model)
    if is_hybrid(mesh):
        return check_hybrid(read_hybrid(mesh), surface, CheckOptions())
    return check_file(mesh, surface, features_by_angle(surface.V, surface.F, feature_angle_deg))


def check_file(mesh: Path, surface: Surface, features: Features) -> Verdict:
    """Verdict on the file as it is on disk: read back, never taken from memory."""
    cells = read_cells(mesh)
    check = check_hexes if cells.kind == "hex" else check_quads
    return check(cells.V, cells.cells, surface, features, CheckOptions())


def load_surface(model: Path) -> Surface:
    """The surface in `model`, cleaned as tetize cleans it, or the boundary of its tets."""
    from neurframe_cli.mesh.clean_surface import clean_surface
    from neurframe_cli.mesh.load import load_model
    from neurframe_cli.mesh.tet_adjacency import tet_adjacency

    loaded = load_model(model)
    if isinstance(loaded, Surface):
        return clean_surface(loaded, model)[0]
    tets, _ = loaded
    return used_only(tets.V, tet_adjacency(tets.T).boundary_faces)


def used_only(V: Floats, F: Ints) -> Surface:
    """The surface without the vertices that no triangle uses."""
    import numpy as np

    used, local = np.unique(F, return_inverse=True)
    return Surface(V[used], local.reshape(F.shape).astype(np.int64))


def draw_file(mesh: Path, folder: Path) -> list[Path]:
    """Paths of PNG pictures of the mesh in `folder`, which is made.  Raises StageError where nothing can be drawn."""
    from neurframe_cli.picture.draw import draw
    from neurframe_cli.picture.mesh_data import HybridData, MeshData

    if is_hybrid(mesh):
        data: MeshData | HybridData = HybridData(read_hybrid(mesh))
        names = ["filled"]
    else:
        cells = read_cells(mesh)
        names = ["quads"] if cells.kind == "quad" else ["hexes", "hexes_cut", "hexes_singular"]
        data = MeshData(cells.V, cells.cells)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise write_error(folder, error) from error
    pictures = {name: folder / f"{mesh.stem}-{name.replace('_', '-')}.png" for name in names}
    draw(pictures, data)
    return list(pictures.values())

"""Voids filled with pyramids and tets: conforming, positive, with the volume of the model; and what fills them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from smooth_shapes import Shape, cube_hexes, cylinder_hexes, sphere_hexes

from neurframe_cli.errors import InvalidMesh, StageError, UnsupportedFormat
from neurframe_cli.mesh.arrays import Bools, Floats, Surface, TetMesh
from neurframe_cli.mesh.filling.hybrid_files import check_hybrid_output, read_hybrid, write_hybrid
from neurframe_cli.mesh.filling.hybrid_mesh import HybridMesh, measure_hybrid, outer_faces
from neurframe_cli.mesh.filling.pyramids import base_jacobians, pyramid_apexes
from neurframe_cli.mesh.filling.sound_hexes import measure_faces, peeled
from neurframe_cli.mesh.hex_shell import hex_shell
from neurframe_cli.stages.fill_voids import FilledMesh, fill_voids
from neurframe_cli.stages.run_netgen import run_netgen


@pytest.fixture
def fill(tmp_path: Path):
    def tetrahedralize(surface: Surface, edge_length: float) -> TetMesh:
        return run_netgen(surface, edge_length, timeout_s=300, memory_mib=None, scratch_dir=tmp_path)

    def run(shape: Shape, kept: Bools | None = None, V: Floats | None = None) -> FilledMesh:
        cells = shape.cells if kept is None else shape.cells[kept]
        positions = shape.V if V is None else V
        return fill_voids(positions, cells, shape.surface, shape.features.edges, tetrahedralize)

    return run


def all_but(shape: Shape, place: tuple[float, float, float], radius: float) -> Bools:
    """The hexes whose centre is not within `radius` of `place`."""
    centres = shape.V[shape.cells].mean(axis=1)
    return np.linalg.norm(centres - np.array(place), axis=1) > radius


# a void inside, one in a face, one at an edge, one at a corner of the cube
@pytest.mark.parametrize(
    ("place", "radius"),
    [((0.5, 0.5, 0.5), 0.2), ((0.5, 0.5, 1.0), 0.25), ((0.0, 0.5, 1.0), 0.25), ((1.0, 1.0, 1.0), 0.3)],
)
def test_voids_of_a_cube_are_filled_exactly(fill, place, radius) -> None:
    shape = cube_hexes(6)
    kept = all_but(shape, place, radius)
    filled = fill(shape, kept)
    assert filled.numbers.valid
    assert filled.numbers.volume == pytest.approx(1.0, abs=1e-12)
    assert filled.numbers.hexes == kept.sum()
    assert filled.numbers.hex_volume_share == pytest.approx(kept.mean())
    assert filled.numbers.pyramids == (hex_shell(shape.cells, kept).quads.shape[0] - _covering(shape, kept))
    assert not filled.obstacles


def _covering(shape: Shape, kept: Bools) -> int:
    """Quads of the shell on the surface of the unit cube."""
    P = shape.V[hex_shell(shape.cells, kept).quads]
    return int(((P == 0).all(axis=1) | (P == 1).all(axis=1)).any(axis=1).sum())


@pytest.mark.parametrize("shape", [sphere_hexes(6), cylinder_hexes()], ids=["sphere", "cylinder"])
def test_a_hole_in_a_round_side_is_filled(fill, shape: Shape) -> None:
    kept = all_but(shape, (1.0, 0.0, 0.3), 0.45)
    filled = fill(shape, kept)
    assert filled.numbers.valid
    assert filled.numbers.hexes >= 0.9 * kept.sum()
    # chords of the round sides: the whole hex mesh lacks as much
    whole = measure_hybrid(_only_hexes(shape)).volume
    assert filled.numbers.volume == pytest.approx(whole, rel=5e-3)


def _only_hexes(shape: Shape) -> HybridMesh:
    return HybridMesh(shape.V, shape.cells, np.zeros((0, 5), np.int64), np.zeros((0, 4), np.int64))


def test_inverted_hexes_are_replaced(fill) -> None:
    shape = cube_hexes(6)
    V = shape.V.copy()
    inside = np.flatnonzero(np.linalg.norm(V - np.array([0.5, 0.5, 0.5]), axis=1) < 1e-9)
    V[inside] += np.array([0.3, 0.0, 0.0])
    filled = fill(shape, V=V)
    assert filled.numbers.valid
    assert len(inside) == 1
    # the eight at that vertex, and the ones that it was moved into are positive but overlap none of them
    assert 0.8 * len(shape.cells) < filled.numbers.hexes <= len(shape.cells) - 4
    assert filled.numbers.volume == pytest.approx(1.0, abs=1e-9)


def test_without_any_sound_hex_there_are_tets(fill) -> None:
    shape = cube_hexes(3)
    filled = fill(shape, V=shape.V[:, [1, 0, 2]])  # mirrored: all are inverted
    assert (filled.numbers.hexes, filled.numbers.pyramids) == (0, 0)
    assert filled.numbers.valid
    assert filled.numbers.volume == pytest.approx(1.0, abs=1e-9)


def test_what_cannot_be_filled_is_an_error_with_its_reasons() -> None:
    def refuse(surface: Surface, edge_length: float) -> TetMesh:
        from neurframe_cli.errors import ChildCrashed

        raise ChildCrashed("no tets today")

    shape = cube_hexes(4)
    kept = all_but(shape, (0.5, 0.5, 1.0), 0.25)
    with pytest.raises(StageError, match="no tets today"):
        fill_voids(shape.V, shape.cells[kept], shape.surface, shape.features.edges, refuse)


def test_hexes_that_meet_in_an_edge_only_do_not_both_stay() -> None:
    shape = cube_hexes(6)
    centres = shape.V[shape.cells].mean(axis=1)
    low, high = (centres < 0.5).all(axis=1), (centres[:, :2] > 0.5).all(axis=1) & (centres[:, 2] < 0.5)
    kept = peeled(shape.cells, measure_faces(shape.V, shape.cells, shape.surface), low | high)
    quads = hex_shell(shape.cells, kept).quads
    edges = np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()
    assert kept.sum() > 27


def test_pyramids_keep_clear_of_what_faces_them() -> None:
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    V = np.concatenate([square, square + np.array([0, 0, 0.3])])
    quads = np.array([[0, 1, 2, 3], [7, 6, 5, 4]])
    apex, room = pyramid_apexes(V, quads, np.zeros((0, 3), np.int64))
    assert room.all()
    assert apex[0, 2] < apex[1, 2]
    assert (base_jacobians(V, quads, apex) > 0).all()
    crowded = np.concatenate([square, square + np.array([0, 0, 0.02])])
    assert not pyramid_apexes(crowded, quads, np.zeros((0, 3), np.int64))[1].any()


@pytest.fixture
def hybrid(fill) -> HybridMesh:
    shape = cube_hexes(4)
    return fill(shape, all_but(shape, (0.5, 0.5, 1.0), 0.3)).mesh


def test_the_measure_sees_every_defect(hybrid: HybridMesh) -> None:
    assert measure_hybrid(hybrid).valid
    twice = HybridMesh(
        hybrid.V, hybrid.hexes, hybrid.pyramids, np.concatenate([hybrid.tets, hybrid.tets[:1]])
    )
    assert measure_hybrid(twice).nonconforming_faces > 0
    turned = HybridMesh(hybrid.V, hybrid.hexes, hybrid.pyramids, hybrid.tets[:, [1, 0, 2, 3]])
    assert measure_hybrid(turned).inverted == len(hybrid.tets)
    split = HybridMesh(hybrid.V, hybrid.hexes, hybrid.pyramids[:0], hybrid.tets)
    assert len(outer_faces(hybrid)[0]) != len(outer_faces(split)[0])
    other = np.concatenate([hybrid.tets[:, :3] + len(hybrid.V), hybrid.tets[:, 3:]], axis=1)
    torn = HybridMesh(np.concatenate([hybrid.V, hybrid.V]), hybrid.hexes, hybrid.pyramids, other)
    assert measure_hybrid(torn).open_edges > 0


@pytest.mark.parametrize("extension", [".vtu", ".vtk", ".msh"])
def test_files_keep_the_mesh(tmp_path: Path, hybrid: HybridMesh, extension: str) -> None:
    path = tmp_path / f"mesh{extension}"
    write_hybrid(path, hybrid)
    read = read_hybrid(path)
    np.testing.assert_allclose(read.V, hybrid.V, atol=1e-15)
    for name in ("hexes", "pyramids", "tets"):
        np.testing.assert_array_equal(getattr(read, name), getattr(hybrid, name))
    assert measure_hybrid(read).valid


def test_other_formats_and_other_cells_are_refused(tmp_path: Path) -> None:
    import meshio

    with pytest.raises(UnsupportedFormat, match="no mesh of hexes, pyramids and tets"):
        check_hybrid_output(Path("mesh.ovm"))
    meshio.Mesh(np.eye(3), [("triangle", [[0, 1, 2]])]).write(tmp_path / "mesh.vtu")
    with pytest.raises(InvalidMesh, match="triangle"):
        read_hybrid(tmp_path / "mesh.vtu")

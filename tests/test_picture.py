"""Pictures are drawn and show what they should; a machine without OpenGL gets an error, not a crash."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from field_shapes import box_tets, cylinder_tets, four_line_frames
from PIL import Image

from neurframe_cli.errors import StageError
from neurframe_cli.field.cross_field import crosses_of_frames
from neurframe_cli.field.singular_edges import SingularEdges, singular_edges
from neurframe_cli.mesh.arrays import Surface, TetMesh
from neurframe_cli.mesh.features import features_by_angle
from neurframe_cli.mesh.surface_edges import face_normals
from neurframe_cli.mesh.tet_adjacency import tet_adjacency
from neurframe_cli.picture.containing_tets import containing_tets
from neurframe_cli.picture.draw import FIELD_PICTURES, draw
from neurframe_cli.picture.field_data import FieldData
from neurframe_cli.picture.mesh_data import MeshData
from neurframe_cli.picture.scene import SIZE, spread_sample
from neurframe_cli.picture.vtp import (
    write_crosses_vtp,
    write_singular_edges_vtp,
    write_singular_points_vtp,
    write_streamlines_vtp,
)


@pytest.fixture(scope="module")
def cylinder() -> tuple[FieldData, SingularEdges]:
    V, T = cylinder_tets(12, 6)
    adjacency = tet_adjacency(T)
    F = adjacency.boundary_faces
    frames = four_line_frames(V[T].mean(axis=1))
    singular = singular_edges(V, T, frames, adjacency)
    crosses = crosses_of_frames(frames[adjacency.boundary_tets], face_normals(V, F))
    features = features_by_angle(V, F, 60).edges
    data = FieldData(
        Surface(V, F),
        TetMesh(V, T),
        features,
        crosses=crosses,
        frames=frames,
        singular_edges=singular.edges,
        quarters=singular.quarters,
        singular_points=np.stack([np.full(40, 0.5), np.zeros(40), np.linspace(-0.9, 0.9, 40)], axis=1),
        point_quarters=np.repeat([-1, 0], 20),
        streamline_points=np.stack(
            [np.zeros(60), np.tile([-0.3, 0.3], 30), np.linspace(-0.9, 0.9, 60)], axis=1
        ),
        streamline_offsets=np.array([0, 30, 60]),
    )
    return data, singular


def share_of_color(path: Path, low: tuple[int, int, int], high: tuple[int, int, int]) -> float:
    """Share of pixels within a box of colours, the legend's corner left out."""
    pixels = np.asarray(Image.open(path).convert("RGB"))[:, 500:]
    return float(((pixels >= low) & (pixels <= high)).all(axis=2).mean())


@pytest.fixture(scope="module")
def drawn(cylinder, tmp_path_factory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("pictures")
    paths = {name: folder / f"{name}.png" for name in FIELD_PICTURES}
    seen: list[float] = []
    draw(paths, cylinder[0], lambda fraction, _: seen.append(fraction))
    assert seen == sorted(seen)
    assert len(seen) >= len(FIELD_PICTURES)
    return paths


def test_pictures_are_white_pages_with_the_body_in_the_middle(drawn):
    for path in drawn.values():
        pixels = np.asarray(Image.open(path).convert("RGB"))
        assert pixels.shape == (SIZE[1], SIZE[0], 3)
        border = np.concatenate([pixels[:5].reshape(-1, 3), pixels[:, -5:].reshape(-1, 3)])
        assert (border == 255).all()
        rows, columns = np.nonzero((pixels[:, 300:] < 250).any(axis=2))
        assert 0.75 < (np.ptp(rows) + 1) / SIZE[1] < 1
        assert abs(rows.mean() / SIZE[1] - 0.5) < 0.15
        assert abs((columns.mean() + 300) / SIZE[0] - 0.5) < 0.15


def test_each_picture_shows_its_colours(drawn):
    strong_red, strong_blue = ((120, 0, 0), (240, 80, 80)), ((0, 30, 120), (110, 130, 255))
    assert share_of_color(drawn["singular"], *strong_red) > 0.002  # three-hex lines, and none with five
    assert share_of_color(drawn["singular"], *strong_blue) < 1e-4
    assert share_of_color(drawn["crosses"], *strong_blue) > 0.002  # strokes along z
    assert share_of_color(drawn["tets"], (150, 100, 30), (255, 220, 150)) > 0.05  # the cut
    assert (
        share_of_color(drawn["singularities"], *strong_blue) > 0.0005
    )  # the points of five hexes, half of all
    assert share_of_color(drawn["singularities"], *strong_red) < 1e-4
    assert share_of_color(drawn["streamlines"], (0, 60, 20), (120, 170, 130)) > 0.001  # strokes along y
    assert share_of_color(drawn["frames"], (40, 70, 110), (130, 180, 240)) > 0.02  # the boxes


def test_no_singular_edges_and_no_features_make_pictures_too(tmp_path):
    V, T = box_tets((1, 1, 1))
    F = tet_adjacency(T).boundary_faces
    data = FieldData(Surface(V, F), TetMesh(V, T), frames=np.broadcast_to(np.eye(3), (len(T), 3, 3)))
    paths = {
        name: tmp_path / f"{name}.png" for name in ("singular", "frames", "singularities", "streamlines")
    }
    draw(paths, data)
    assert share_of_color(paths["singular"], (120, 0, 0), (240, 80, 80)) == 0
    assert all(path.stat().st_size > 5000 for path in paths.values())


def test_a_machine_without_opengl_gets_a_stage_error(cylinder, tmp_path, monkeypatch):
    monkeypatch.setenv("VTK_DEFAULT_OPENGL_WINDOW", "vtkXOpenGLRenderWindow")
    monkeypatch.setenv("DISPLAY", ":no-such-display")
    with pytest.raises(StageError, match="no picture could be drawn") as error:
        draw({"singular": tmp_path / "singular.png"}, cylinder[0])
    assert "libegl1" in str(error.value.hint)
    assert not (tmp_path / "singular.png").exists()


def test_field_data_survives_its_file(cylinder, tmp_path):
    data, _ = cylinder
    data.save(tmp_path / "field.npz")
    again = FieldData.load(tmp_path / "field.npz")
    for name in ("crosses", "frames", "feature_edges", "singular_edges", "quarters", "streamline_points"):
        assert np.array_equal(getattr(again, name), getattr(data, name))
    assert np.array_equal(again.surface.F, data.surface.F)
    assert np.array_equal(again.tets.T, data.tets.T)


def test_vtp_files_read_back(cylinder, tmp_path):
    import pyvista

    data, singular = cylinder
    write_crosses_vtp(tmp_path / "cross.vtp", data.surface, data.crosses)
    crosses = pyvista.read(tmp_path / "cross.vtp")
    assert crosses.n_cells == len(data.surface.F)
    assert np.array_equal(crosses.cell_data["v"], data.crosses[:, 1])
    write_singular_edges_vtp(tmp_path / "singular.vtp", data.tets.V, singular)
    lines = pyvista.read(tmp_path / "singular.vtp")
    ends = lines.points[lines.lines.reshape(-1, 3)[:, 1:]]
    assert np.array_equal(ends, data.tets.V[singular.edges])
    assert np.array_equal(lines.cell_data["quarters"], singular.quarters)


def test_vtp_files_of_the_continuous_field_read_back(cylinder, tmp_path):
    import pyvista

    points, ones = np.random.default_rng(0).normal(size=(5, 3)), np.ones(5, np.int64)
    write_singular_points_vtp(tmp_path / "p.vtp", points, ones, ones, points)
    again = pyvista.read(tmp_path / "p.vtp")
    assert np.array_equal(again.points, points)
    assert np.array_equal(again.point_data["axis"], points)
    write_streamlines_vtp(tmp_path / "s.vtp", [points], [points[:2], points[2:]])
    lines = pyvista.read(tmp_path / "s.vtp")
    assert lines.cell_data["on_surface"].tolist() == [0, 1, 1]
    assert np.array_equal(lines.get_cell(2).points, points[2:])
    write_streamlines_vtp(tmp_path / "none.vtp", [], [])
    assert pyvista.read(tmp_path / "none.vtp").n_cells == 0


def test_an_empty_singular_graph_is_a_file_too(cylinder, tmp_path):
    import pyvista

    data, singular = cylinder
    none = SingularEdges(
        singular.edges[:0],
        singular.turn[:0],
        singular.quarters[:0],
        singular.length[:0],
        singular.length[:0],
        1.0,
    )
    write_singular_edges_vtp(tmp_path / "singular.vtp", data.tets.V, none)
    assert pyvista.read(tmp_path / "singular.vtp").n_cells == 0


def test_points_find_the_tet_that_holds_them(cylinder):
    tets = cylinder[0].tets
    weights = np.random.default_rng(0).dirichlet(np.ones(4), len(tets.T))
    inner = np.einsum("nk,nki->ni", weights, tets.V[tets.T])
    assert (containing_tets(tets.V, tets.T, inner) == np.arange(len(tets.T))).mean() > 0.999
    assert (containing_tets(tets.V, tets.T, np.array([[2.0, 0, 0], [0, 0, 1.01]])) == -1).all()


def test_a_spread_sample_has_one_point_a_cell_and_covers_all():
    points = np.random.default_rng(1).uniform(size=(20_000, 3)) * [4, 2, 1]
    chosen = points[spread_sample(points, 8)]
    assert len(chosen) == 8 * 4 * 2
    assert len(spread_sample(points[:1], 8)) == 1


def test_pictures_of_meshes_show_what_is_irregular(tmp_path):
    from test_quality import cube_shell, hex_grid

    blue = (20, 60, 140), (110, 170, 255)
    V, Q = cube_shell(4)
    draw({"quads": tmp_path / "quads.png"}, MeshData(V, Q))
    # valence three at the eight corners, of which seven are seen as blue balls; the four sides of one face have none
    assert share_of_color(tmp_path / "quads.png", *blue) > 5e-5
    draw({"quads": tmp_path / "flat.png"}, MeshData(V, Q[(V[Q][:, :, 2] == 1).all(axis=1)]))
    assert share_of_color(tmp_path / "flat.png", *blue) < 5e-5
    V, H = hex_grid(4)
    draw({"hexes": tmp_path / "hexes.png", "hexes_cut": tmp_path / "cut.png"}, MeshData(V, H))
    for name in ("hexes.png", "cut.png"):
        # a regular grid is all of the best colour and nowhere of the worst
        assert share_of_color(tmp_path / name, (100, 110, 130), (215, 225, 245)) > 0.1
        assert share_of_color(tmp_path / name, (150, 0, 20), (200, 60, 70)) == 0

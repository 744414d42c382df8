"""Cleaning against closed forms: volumes, Euler characteristics, counts of what was broken on purpose."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from neurframe_cli.errors import InvalidMesh
from neurframe_cli.mesh.arrays import Floats, Surface, as_surface
from neurframe_cli.mesh.clean_surface import clean_surface
from neurframe_cli.mesh.measure import enclosed_volume
from neurframe_cli.mesh.open_surface import doubtful_share, refuse_large_holes
from neurframe_cli.mesh.read_surface import read_surface
from neurframe_cli.mesh.surface_distance import distances, sample_surface

SAMPLES = Path(__file__).parent.parent / "samples"
POLYGON = 24 * np.sin(2 * np.pi / 48)  # area of the 48-gon in the unit circle


@pytest.fixture
def cube() -> Surface:
    return clean_surface(read_surface(SAMPLES / "cube.stl"))[0]


def soup(surface: Surface) -> Surface:
    return as_surface(surface.V[surface.F].reshape(-1, 3), np.arange(surface.F.size).reshape(-1, 3))


@pytest.mark.parametrize(
    ("name", "volume", "genus"),
    [
        ("cube.stl", 1000.0, 0),
        ("tetrahedron.obj", 10.0**3 / (6 * np.sqrt(2)), 0),
        ("cylinder.stl", 15 * 25 * POLYGON, 0),
        ("torus.obj", None, 1),
        ("bracket.stl", 40 * 40 * 8 + 8 * 40 * 36 - 8 * 81 * POLYGON, 1),
    ],
)
def test_volume_and_genus_of_the_samples(name: str, volume: float | None, genus: int) -> None:
    surface, report = clean_surface(read_surface(SAMPLES / name))
    assert report.closed
    assert report.genus == genus
    assert report.euler == 2 - 2 * genus
    # STL holds seven digits
    assert volume is None or enclosed_volume(surface.V, surface.F) == pytest.approx(volume, rel=1e-6)


def test_what_is_broken_is_counted_and_repaired(cube: Surface) -> None:
    turned = cube.F.copy()
    turned[3] = turned[3, ::-1]
    F = np.concatenate([turned, turned[:2], [[0, 0, 1]]])
    clean, report = clean_surface(soup(as_surface(cube.V, F)))
    assert (report.degenerate, report.duplicate, report.turned) == (1, 2, 1)
    assert report.welded == 3 * len(F) - 8
    assert report.genus == 0
    assert enclosed_volume(clean.V, clean.F) == pytest.approx(1000.0)


def test_corners_that_differ_by_rounding_are_welded(cube: Surface) -> None:
    noisy = soup(cube)
    noise = np.random.default_rng(1).uniform(-1e-6, 1e-6, noisy.V.shape)
    clean, report = clean_surface(as_surface(noisy.V + noise, noisy.F))
    assert report.closed
    assert len(clean.V) == 8


def test_inside_out_shells_are_turned_and_cavities_kept(cube: Surface) -> None:
    """A solid cube, a cavity in it, and a second cube beside it that is inside out."""
    parts = [
        (cube.V, cube.F),
        (cube.V * 0.5 + 2.5, cube.F[:, ::-1]),
        (cube.V + np.array([20, 0, 0]), cube.F[:, ::-1]),
    ]
    V = np.concatenate([part[0] for part in parts])
    F = np.concatenate([part[1] + 8 * i for i, part in enumerate(parts)])
    clean, report = clean_surface(as_surface(V, F))
    assert report.components == 3
    assert report.turned == 12
    assert enclosed_volume(clean.V, clean.F) == pytest.approx(1000 - 125 + 1000)


def lidless(cube: Surface) -> Surface:
    centre = cube.V[cube.F].mean(axis=1)
    return as_surface(cube.V, cube.F[centre[:, 2] < 10 - 1e-9])


def test_a_box_without_lid_has_no_inside(cube: Surface) -> None:
    box = lidless(cube)
    assert 0.1 < doubtful_share(box) < 0.5
    with pytest.raises(InvalidMesh, match="the surface is open"):
        refuse_large_holes(box)
    assert refuse_large_holes(cube) == []


def test_a_missing_triangle_does_no_harm_even_inside_out() -> None:
    torus = read_surface(SAMPLES / "torus.obj")
    clean, report = clean_surface(as_surface(torus.V, torus.F[1:, ::-1]))
    assert report.open_edges == 3
    assert report.turned == len(clean.F)
    assert doubtful_share(clean) < 0.01
    (warning,) = refuse_large_holes(clean)
    assert "3 edges" in warning


def test_a_patch_between_nonmanifold_edges_is_not_turned_on_its_own() -> None:
    """A tube of square section, 1 inside and 3 outside, with lids on its bore: its inner wall is a patch that faces
    the axis, and rightly so (the case of thingi10k 68251, whose walls were turned)."""
    inner, outer = (
        np.array([[1, 1], [2, 1], [2, 2], [1, 2.0]]),
        np.array([[0, 0], [3, 0], [3, 3], [0, 3.0]]),
    )
    V = np.concatenate(
        [np.column_stack([ring, np.full(4, z)]) for z in (0.0, 1.0) for ring in (outer, inner)]
    )
    # the lids; corners 0-3 lie outside below, 4-7 inside below, 8-15 the same above
    quads = [[12, 13, 14, 15], [4, 7, 6, 5]]
    for a in range(4):
        b = (a + 1) % 4
        quads += [[a, b, 8 + b, 8 + a], [4 + b, 4 + a, 12 + a, 12 + b]]  # outer wall, bore
        quads += [[8 + a, 8 + b, 12 + b, 12 + a], [b, a, 4 + a, 4 + b]]  # top, bottom
    Q = np.array(quads)
    clean, report = clean_surface(as_surface(V, np.concatenate([Q[:, [0, 1, 2]], Q[:, [0, 2, 3]]])))
    assert report.nonmanifold_edges == 8
    assert report.turned == 0
    assert len(clean.F) == 2 * len(Q)


def test_a_sheet_is_no_solid() -> None:
    sheet = mesh(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.1]]), [[0, 1, 2], [1, 3, 2]])
    with pytest.raises(InvalidMesh, match="open"):
        refuse_large_holes(clean_surface(sheet)[0])


def mesh(V: Floats, F: list[list[int]]) -> Surface:
    return as_surface(V, np.array(F).reshape(-1, 3))


@pytest.mark.parametrize(
    ("surface", "words"),
    [
        (mesh(np.zeros((3, 3)), []), "no triangles"),
        (mesh(np.zeros((3, 3)), [[0, 1, 2]]), "diagonal 0"),
        (mesh(np.array([[0, 0, 0], [1, 0, 0], [0, np.nan, 0]]), [[0, 1, 2]]), "vertex 2"),
        (mesh(np.array([[0, 0, 0], [1, 0, 0], [0, np.inf, 0]]), [[0, 1, 2]]), "vertex 2"),
        (mesh(np.eye(3), [[0, 1, 3]]), "triangle 0"),
        (mesh(np.eye(3), [[0, 1, -1]]), "triangle 0"),
        (mesh(np.eye(3) * 1e-200, [[0, 1, 2]]), "diagonal"),
        (mesh(np.eye(3) * 1e200, [[0, 1, 2]]), "below 1e\\+90"),
        (mesh(np.eye(3), [[0, 1, 1]]), "all 1 triangles are degenerate"),
    ],
)
def test_what_would_crash_ftetwild_is_refused(surface: Surface, words: str) -> None:
    with pytest.raises(InvalidMesh, match=words):
        clean_surface(surface)


def test_distance_between_two_cubes(cube: Surface) -> None:
    """Shifted by 1 along x: the far side is 1 away, and nothing is further."""
    points = sample_surface(cube.V + np.array([1.0, 0, 0]), cube.F, 0.5)
    assert distances(points, cube.V, cube.F).max() == pytest.approx(1.0)

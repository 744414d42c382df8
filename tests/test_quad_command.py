"""`neurframe quad` as a user runs it, with the surface's own crosses: shapes of every topology, sizes, bad input."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from smooth_shapes import cube_quads, patch_quads, sphere_quads, torus_quads

from neurframe_cli.cli.main import run_command_line
from neurframe_cli.mesh.arrays import Surface
from neurframe_cli.mesh.quality.polygons import count_components, euler_characteristic, unique_edges
from neurframe_cli.mesh.read_cells import CellMesh, read_cells
from neurframe_cli.mesh.split_edges import with_short_edges
from neurframe_cli.mesh.write_mesh import write_surface
from neurframe_cli.pipeline.executables import find_executable
from neurframe_cli.pipeline.manifest import read_manifest

ALONE = ["--field", "surface", "--threads", "1", "--no-pictures", "-q"]


def block_with_two_holes() -> Surface:
    """A block of 5 x 3 x 1 unit cubes without two of them: genus 2, every edge sharp or flat."""
    filled = np.ones((5, 3, 1), bool)
    filled[1, 1, 0] = filled[3, 1, 0] = False
    solid = np.pad(filled, 1)
    corners, quads = [], []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for cell in np.argwhere(solid).tolist():
            for side in (0, 1):
                beyond = list(cell)
                beyond[axis] += 2 * side - 1
                if solid[tuple(beyond)]:
                    continue
                square = [[0, 0], [1, 0], [1, 1], [0, 1]]
                quads.append([])
                for a, b in square if side else square[::-1]:
                    corner = list(cell)
                    corner[axis] += side
                    corner[u] += a
                    corner[v] += b
                    quads[-1].append(len(corners))
                    corners.append(corner)
    V, local = np.unique(np.array(corners, float), axis=0, return_inverse=True)
    Q = local.reshape(-1)[np.array(quads)]
    return with_short_edges(Surface(V, np.concatenate([Q[:, [0, 1, 2]], Q[:, [0, 2, 3]]])), 0.5)


def together(*surfaces: Surface) -> Surface:
    starts = np.cumsum([0, *(len(s.V) for s in surfaces)])
    F = [s.F + start for s, start in zip(surfaces, starts, strict=False)]
    return Surface(np.concatenate([s.V for s in surfaces]), np.concatenate(F))


def quads_of(surface: Surface, folder: Path, *options: str, code: int = 0) -> CellMesh:
    model, workspace = folder / "model.ply", folder / "w.neurframe"
    write_surface(model, surface)
    assert run_command_line(["quad", "--surface", str(model), "-w", str(workspace), *ALONE, *options]) == code
    return read_cells(workspace / "quad.obj")


def topology(mesh: CellMesh) -> tuple[int, int, int]:
    """Components, Euler characteristic, open edges."""
    edges, use = unique_edges(mesh.cells)
    return count_components(edges), euler_characteristic(mesh.cells), int((use == 1).sum())


def test_a_mirror_symmetry_is_exact_and_the_number_of_quads_is_met(tmp_path: Path) -> None:
    surface = torus_quads(48, 20).surface
    moved = Surface(surface.V + np.array([0.1, 0.2, 0.3]), surface.F)
    mesh = quads_of(moved, tmp_path, "--symmetry", "z", "--target-faces", "800")
    assert len(mesh.cells) == pytest.approx(800, rel=0.05)
    assert topology(mesh) == (1, 0, 0)
    centre = mesh.V[np.abs(mesh.V[:, 2] - 0.3).argmin(), 2]
    image = mesh.V * [1, 1, -1] + [0, 0, 2 * centre]
    assert {tuple(p) for p in image.tolist()} == {tuple(p) for p in mesh.V.tolist()}
    report = read_manifest(tmp_path / "w.neurframe").stages["quad"].report
    assert report["mesh"]["min_scaled_jacobian"] > 0.8


def test_an_open_sheet_keeps_its_outline(tmp_path: Path) -> None:
    mesh = quads_of(patch_quads(4, 20).surface, tmp_path, "--edge-length", "0.1")
    components, euler, open_edges = topology(mesh)
    assert (components, euler) == (1, 1)
    assert open_edges == 4 * round(np.sqrt(len(mesh.cells)))
    edges, use = unique_edges(mesh.cells)
    rim = mesh.V[np.unique(edges[use == 1])]
    np.testing.assert_allclose(np.abs(rim[:, :2] - 0.5).max(axis=1), 0.5, atol=1e-9)


def test_every_component_is_meshed(tmp_path: Path) -> None:
    sphere = sphere_quads(2, 12).surface
    far = Surface(sphere.V + np.array([4.0, 0.0, 0.0]), sphere.F)
    mesh = quads_of(together(cube_quads(2, 6).surface, far), tmp_path, "--edge-length", "0.25")
    assert topology(mesh) == (2, 4, 0)


def test_a_genus_of_two_with_sharp_edges(tmp_path: Path) -> None:
    mesh = quads_of(block_with_two_holes(), tmp_path, "--edge-length", "0.25")
    assert topology(mesh) == (1, -2, 0)
    numbers = read_manifest(tmp_path / "w.neurframe").stages["quad"].report["mesh"]
    assert numbers["feature_recall"] == 1.0
    assert numbers["min_scaled_jacobian"] > 0.99


def test_adaptive_quads_are_smaller_on_a_bump(tmp_path: Path) -> None:
    t = np.linspace(-1.0, 1.0, 41)
    x, y = (a.ravel() for a in np.meshgrid(t, t, indexing="ij"))
    flat = patch_quads(4, 40).surface
    bump = Surface(np.stack([x, y, 0.35 * np.exp(-10 * (x**2 + y**2))], axis=1), flat.F)
    ratios = []
    for options in ([], ["--adaptive", "1"]):
        mesh = quads_of(bump, tmp_path, "--target-faces", "400", *options)
        assert len(mesh.cells) == pytest.approx(400, rel=0.05)
        P = mesh.V[mesh.cells]
        size = np.linalg.norm(np.cross(P[:, 2] - P[:, 0], P[:, 3] - P[:, 1]), axis=1) / 2
        away = np.linalg.norm(P.mean(axis=1)[:, :2], axis=1)
        ratios.append(np.median(size[away < 0.3]) / np.median(size[away > 0.8]))
    # a grid without singular vertices can only stretch: 0.80 beside 1.4
    assert ratios[1] < 0.75 * ratios[0]


def test_another_program_in_place_of_ours(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("miq", "qex"):
        script = tmp_path / name
        script.write_text(
            f'#!/bin/sh\necho "$@" > {tmp_path}/{name}.said\nexec {find_executable(name)} "$@"\n'
        )
        script.chmod(0o755)
        monkeypatch.setenv(f"NEURFRAME_{name.upper()}", str(script))
    mesh = quads_of(patch_quads(4, 20).surface, tmp_path, "--edge-length", "0.2", "--adaptive", "0.3")
    assert topology(mesh)[:2] == (1, 1)
    # what third_party/quad-tools.md promises
    words = (tmp_path / "miq.said").read_text().split()
    assert words[2::2] == ["-o", "--edge-length", "--sizing", "--feature-angle", "--threads"]
    assert (tmp_path / "qex.said").read_text().split()[1::2] == ["-o", "--threads"]


def lopsided() -> Surface:
    surface = sphere_quads(2, 8).surface
    return Surface(surface.V * np.where(surface.V[:, :1] > 0, 1.0, 0.5), surface.F)


def fin() -> Surface:
    V = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1]], float)
    return Surface(V, np.array([[0, 1, 2], [1, 0, 3], [0, 1, 4]]))


def flat_triangle() -> Surface:
    shape = cube_quads(2, 2).surface
    V = np.concatenate([shape.V, [(shape.V[shape.F[0, 0]] + shape.V[shape.F[0, 1]]) / 2]])
    a, b, _ = shape.F[0]
    return Surface(V, np.concatenate([shape.F, [[a, b, len(shape.V)]]]))


@pytest.mark.parametrize(
    ("surface", "options", "code", "message"),
    [
        (lopsided(), ["--symmetry", "x"], 2, "not symmetric"),
        (fin(), [], 2, "more than two triangles"),
        (flat_triangle(), [], 2, "have no area"),
        (sphere_quads(2, 8).surface, ["--adaptive", "2"], 2, "range 0<=x<=1"),
        (sphere_quads(2, 8).surface, ["-o", "out.stl"], 2, "no quad mesh is written as .stl"),
        (sphere_quads(2, 8).surface, ["--scale", "3", "--target-faces", "5"], 2, "only one of"),
    ],
)
def test_what_cannot_be_used_is_one_clear_line(
    surface: Surface,
    options: list[str],
    code: int,
    message: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    model = tmp_path / "model.ply"
    write_surface(model, surface)
    arguments = ["quad", "--surface", str(model), "-w", str(tmp_path / "w"), *ALONE, *options]
    assert run_command_line(arguments) == code
    said = capsys.readouterr().err
    assert message in said
    assert "Traceback" not in said
    assert not (tmp_path / "w" / "quad.obj").exists()


def test_quads_so_coarse_that_nothing_fits_end_with_4(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model = tmp_path / "model.ply"
    write_surface(model, torus_quads(24, 10).surface)
    arguments = ["quad", "--surface", str(model), "-w", str(tmp_path / "w"), *ALONE, "--scale", "0.2"]
    assert run_command_line(arguments) == 4
    said = capsys.readouterr().err
    assert "not valid" in said or "no quad mesh could be extracted" in said


def test_a_field_that_was_not_trained_is_asked_for(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model = tmp_path / "model.ply"
    write_surface(model, sphere_quads(2, 8).surface)
    (tmp_path / "w").mkdir()
    assert run_command_line(["quad", "--surface", str(model), "-w", str(tmp_path / "w"), "-q"]) == 2
    assert "field.safetensors is missing" in capsys.readouterr().err

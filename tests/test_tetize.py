"""tetize on real models through the real fTetWild, at coarse edge lengths; its ladder and its checks."""

from __future__ import annotations

import os
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from neurframe_cli.errors import ChildCrashed, ChildOutOfMemory, InvalidMesh, StageError, TimedOut, UsageError
from neurframe_cli.mesh.arrays import Features, Surface, TetMesh, as_surface, as_tets, silent
from neurframe_cli.mesh.check_tets import checked_tets, tet_volumes
from neurframe_cli.mesh.clean_surface import clean_surface
from neurframe_cli.mesh.features import features_by_angle, features_from_edges
from neurframe_cli.mesh.load import load_model
from neurframe_cli.mesh.manifold_boundary import boundary_surface
from neurframe_cli.mesh.read_surface import read_surface
from neurframe_cli.mesh.surface_distance import distances
from neurframe_cli.mesh.tet_adjacency import tet_adjacency
from neurframe_cli.stages import tetize_attempts
from neurframe_cli.stages.run_tetwild import TetwildSettings, seed_library
from neurframe_cli.stages.tetize import TetizeOptions, tetize
from neurframe_cli.stages.tetize_attempts import EmptyResultError, settings_after
from neurframe_cli.stages.tetize_check import fit, refuse_misfit

SAMPLES = Path(__file__).parent.parent / "samples"
COARSE = TetizeOptions(edge_length=0.12, timeout_s=120)


def sample(name: str) -> Surface:
    return read_surface(SAMPLES / name)


def assert_sound(tets: TetMesh) -> None:
    """Positive, conforming, manifold boundary, no tet with two boundary faces."""
    checked_tets(tets.V, tets.T)
    assert (tet_volumes(tets.V, tets.T) > 0).all()
    assert (tet_adjacency(tets.T).neighbors < 0).sum(axis=1).max() == 1
    _, F = boundary_surface(tets)
    edges = np.sort(F[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()


@pytest.mark.slow
def test_bracket(tmp_path: Path) -> None:
    """Far from the origin and in millimetres, it comes back in place, with its features and its hole."""
    model = sample("bracket.stl")
    shift = np.array([1000.0, -2000.0, 30.0])
    moved = as_surface(model.V + shift, model.F)
    seen: list[float] = []
    result = tetize(moved, COARSE, lambda fraction, _: seen.append(fraction), tmp_path)
    assert_sound(result.tets)
    assert result.surface.V.min(axis=0) == pytest.approx(shift - np.array([8, 0, 0]), abs=1e-3)
    assert result.fit is not None
    assert result.fit.volume_ratio == pytest.approx(1, abs=0.01)
    assert result.fit.boundary_to_input < 2 * COARSE.epsilon
    V, F = boundary_surface(result.tets)
    assert len(V) - len(F) // 2 == 0  # Euler characteristic of a torus: one hole
    assert len(result.features.corners) == 12
    assert len(result.features.chains) == 20
    truth = features_by_angle(result.surface.V, result.surface.F, 45.0)
    away = distances(result.tets.V[np.unique(result.features.edges)], result.surface.V, truth.edges)
    assert away.max() < 2 * COARSE.epsilon * np.linalg.norm(np.ptp(V, axis=0))
    assert seen[0] == 0.0
    assert seen[-1] == 1.0


@pytest.mark.slow
@pytest.mark.skipif(
    not sys.platform.startswith("linux"), reason="the seed library is preloaded on Linux only"
)
def test_the_same_seed_gives_the_same_bytes(tmp_path: Path) -> None:
    runs = [
        tetize(sample("tetrahedron.obj"), replace(COARSE, seed=seed, edge_length=0.1), silent, tmp_path)
        for seed in (7, 7, 8)
    ]
    assert all(run.seeded for run in runs)
    assert runs[0].tets.V.tobytes() == runs[1].tets.V.tobytes()
    assert runs[0].tets.T.tobytes() == runs[1].tets.T.tobytes()
    assert runs[0].tets.V.tobytes() != runs[2].tets.V.tobytes()


def test_a_seed_library_that_is_not_there_is_not_used(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NEURFRAME_SEED_LIBRARY", str(tmp_path / "none.so"))
    assert seed_library() is None


def test_given_segments_count_instead_of_the_angle(tmp_path: Path) -> None:
    """Of the cube's twelve edges only the four round the lid are asked for."""
    corners = np.array([[0, 0, 10], [10, 0, 10], [10, 10, 10], [0, 10, 10.0]])
    segments = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
    options = replace(COARSE, feature_segments=segments, edge_length=0.1)
    result = tetize(sample("cube.stl"), options, silent, tmp_path)
    points = result.tets.V[np.unique(result.features.edges)]
    assert np.abs(points[:, 2] - 10).max() < 0.05
    assert len(result.features.chains) == len(result.features.corners) == 4
    lengths = result.tets.V[result.features.edges]
    assert np.linalg.norm(lengths[:, 0] - lengths[:, 1], axis=1).sum() == pytest.approx(40, rel=0.01)


def test_tets_pass_through(tmp_path: Path) -> None:
    """One negative tet and its edges as features: turned round, divided, edges kept."""
    V = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    model = (as_tets(V, [[0, 2, 1, 3]]), features_from_edges(V, np.array([[0, 1], [2, 3]])))
    result = tetize(model, COARSE, silent, tmp_path)
    assert_sound(result.tets)
    assert result.divided == 1
    assert result.features.edges.tolist() == [[0, 1], [2, 3]]
    assert len(result.surface.F) == 4
    kept = tetize(model, replace(COARSE, divide_boundary_tets=False), silent, tmp_path)
    assert len(kept.tets.T) == 1


def test_tets_without_features_get_them_by_angle(tmp_path: Path) -> None:
    V = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    result = tetize((as_tets(V, [[0, 1, 2, 3]]), Features()), COARSE, silent, tmp_path)
    assert len(result.features.edges) == 6


def test_an_open_box_is_refused_by_name(tmp_path: Path) -> None:
    cube, _ = clean_surface(sample("cube.stl"))
    lid = cube.V[cube.F].mean(axis=1)[:, 2] > 9.99
    with pytest.raises(InvalidMesh, match=r"box\.stl: the surface is open"):
        tetize(as_surface(cube.V, cube.F[~lid]), COARSE, silent, tmp_path, name="box.stl")


def test_a_doubled_sheet_ends_in_a_classed_error(tmp_path: Path) -> None:
    """Closed, but it encloses nothing: fTetWild succeeds with zero tets."""
    V = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [0.4, 0.4, 1e-9]])
    F = np.array([[0, 2, 1], [2, 3, 1], [0, 1, 4], [1, 3, 4], [3, 2, 4], [2, 0, 4]])
    with pytest.raises(InvalidMesh, match="encloses nothing"):
        tetize(as_surface(V, F), replace(COARSE, edge_length=0.3), silent, tmp_path)


def test_no_time(tmp_path: Path) -> None:
    with pytest.raises(TimedOut):
        tetize(sample("bracket.stl"), replace(COARSE, timeout_s=0.2, edge_length=0.01), silent, tmp_path)


def test_no_memory(tmp_path: Path) -> None:
    with pytest.raises(ChildOutOfMemory, match="fTetWild"):
        tetize(sample("cube.stl"), replace(COARSE, memory_mib=10), silent, tmp_path)


def test_a_crash_of_ftetwild_stays_in_its_process(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A preloaded library that cannot be what it should be: std::abort in place of the seed."""
    import subprocess

    source = tmp_path / "abort.cpp"
    source.write_text(
        "#include <cstdlib>\n__attribute__((constructor)) static void now() { std::abort(); }\n"
    )
    library = tmp_path / "libabort.so"
    if os.system("command -v g++ > /dev/null") != 0:
        pytest.skip("no compiler")
    subprocess.run(["g++", "-shared", "-fPIC", source, "-o", library], check=True)
    monkeypatch.setenv("NEURFRAME_SEED_LIBRARY", str(library))
    with pytest.raises(ChildCrashed, match=r"SIGABRT.*attempts"):
        tetize(sample("cube.stl"), COARSE, silent, tmp_path)


def test_ladder_of_settings() -> None:
    first = TetwildSettings(0.025, 1e-3)
    crash = ChildCrashed("")
    steps = [first]
    while (following := settings_after(first, steps[-1], crash, manifold=True)) is not None:
        steps.append(following)
    assert len(steps) == len(set(steps)) == 5
    assert settings_after(first, steps[1], EmptyResultError(""), manifold=True) is None
    assert steps[1] == replace(first, simplify=False)


def test_ladder_of_what_is_too_slow() -> None:
    first, slow = TetwildSettings(0.025, 1e-3), TimedOut("")
    assert settings_after(first, first, slow, manifold=False) == replace(first, edge_length_fac=0.05)
    assert settings_after(first, replace(first, edge_length_fac=0.1), slow, manifold=False) is None
    assert (
        settings_after(TetwildSettings(0.2, 1e-3), TetwildSettings(0.2, 1e-3), slow, manifold=False) is None
    )
    fewer = settings_after(first, first, slow, manifold=True)
    assert fewer == replace(first, decimate=True)
    assert settings_after(first, fewer, slow, manifold=True) == replace(fewer, edge_length_fac=0.05)


def test_a_simplification_that_never_ends_is_ended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """fTetWild silent for longer than allowed: decimated, and no longer waited for by its silence."""
    monkeypatch.setattr(tetize_attempts, "SILENT_SHARE", 0.0)
    monkeypatch.setattr(tetize_attempts, "LEAST_SILENCE_S", 0.01)  # shorter than the child takes to start
    found = tetize(sample("bracket.stl"), COARSE, silent, tmp_path)
    assert "said nothing" in found.attempts[0].outcome
    assert found.attempts[1].settings.decimate


def test_a_missing_part_is_noticed() -> None:
    """Tets of one of two cubes against a surface of both."""
    cube, _ = clean_surface(sample("cube.stl"))
    V = np.concatenate([cube.V, cube.V + np.array([20, 0, 0])])
    both, report = clean_surface(as_surface(V, np.concatenate([cube.F, cube.F + 8])))
    # a cone from the centre over each boundary triangle
    cone = np.column_stack([np.full(len(cube.F), 8), cube.F])
    tets, _ = checked_tets(np.concatenate([cube.V, [[5.0, 5, 5]]]), cone)
    found = fit(tets, both, report)
    assert found.volume_ratio == pytest.approx(0.5)
    assert found.boundary_to_input < 1e-12
    with pytest.raises(StageError, match="parts of the surface"):
        refuse_misfit(found, 1e-3, report)


@pytest.mark.parametrize(
    "wrong", [{"edge_length": 0.0}, {"epsilon": float("nan")}, {"seed": -1}, {"timeout_s": -1.0}]
)
def test_options_out_of_range(wrong: dict[str, float]) -> None:
    with pytest.raises(UsageError):
        TetizeOptions(**wrong)  # type: ignore[arg-type]  # values of any type, to be refused


def test_load_and_tetize_reject_the_same_broken_file(tmp_path: Path) -> None:
    path = tmp_path / "nan.obj"
    path.write_text("v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    with pytest.raises(InvalidMesh, match=r"nan\.obj"):
        load_model(path)

"""Damaged files: every reader returns a mesh or raises a NeurframeError, whatever the bytes."""

from __future__ import annotations

import random
from pathlib import Path

import numpy as np
import pytest
from damage import CASES, FIRST_SEED, StillReading, damaged, reading_limits
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from test_mesh_readers import CUBE_T, CUBE_V, OVM

from neurframe_cli.errors import NeurframeError
from neurframe_cli.mesh.arrays import Features, Surface, TetMesh, as_surface
from neurframe_cli.mesh.check_tets import checked_tets, tet_volumes
from neurframe_cli.mesh.clean_surface import clean_surface
from neurframe_cli.mesh.features import features_by_angle
from neurframe_cli.mesh.load import load_model
from neurframe_cli.mesh.tet_adjacency import tet_adjacency
from neurframe_cli.mesh.write_mesh import write_surface, write_tets

NAMES = (
    "a.stl",
    "a.obj",
    "a.off",
    "a.ply",
    "a.3mf",
    "a.mesh",
    "a.vtk",
    "a.vtu",
    "a.msh",
    "a.ovm",
    "text.stl",
)


def undamaged(name: str, folder: Path) -> bytes:
    """A cube of five tets, or its surface, in the format of the name."""
    tets, _ = checked_tets(CUBE_V, CUBE_T)
    faces = tet_adjacency(tets.T).boundary_faces
    path = folder / name
    if name == "a.ovm":
        return OVM.encode()
    if name in ("a.3mf", "text.stl"):
        import trimesh

        options = {"file_type": "stl_ascii"} if name == "text.stl" else {}
        trimesh.Trimesh(tets.V, faces, process=False).export(path, **options)
    elif path.suffix in (".mesh", ".vtk", ".vtu", ".msh"):
        write_tets(path, tets, features_by_angle(tets.V, faces, 45.0))
    else:
        write_surface(path, as_surface(tets.V, faces))
    return path.read_bytes()


@pytest.mark.parametrize("name", NAMES)
def test_damaged_files(name: str, tmp_path: Path) -> None:
    content = undamaged(name, tmp_path)
    path = tmp_path / f"damaged{Path(name).suffix}"
    path.write_bytes(content)
    look_at(load_model(path), path)  # loads the libraries, whose seconds are not those of a reader
    for seed in range(FIRST_SEED, FIRST_SEED + CASES):
        path.write_bytes(damaged(content, random.Random(seed)))
        try:
            with reading_limits():
                look_at(load_model(path), path)
        except NeurframeError as error:
            if path.name not in str(error):
                raise AssertionError(f"seed {seed}: the message does not name the file: {error}") from error
        except (Exception, StillReading) as error:
            raise AssertionError(f"seed {seed}: {type(error).__name__}: {error}") from error


def look_at(model: Surface | tuple[TetMesh, Features], path: Path) -> None:
    """What was read can be worked on."""
    if isinstance(model, Surface):
        surface, _ = clean_surface(model, path)
        assert np.isfinite(surface.V).all()
        assert surface.F.min() >= 0
        assert surface.F.max() < len(surface.V)
    else:
        mesh, features = model
        assert (tet_volumes(mesh.V, mesh.T) > 0).all()
        assert features.edges.max(initial=-1) < len(mesh.V)


@given(st.binary(min_size=1, max_size=300))
@settings(max_examples=100, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
def test_noise(tmp_path_factory: pytest.TempPathFactory, noise: bytes) -> None:
    path = tmp_path_factory.getbasetemp() / "noise.stl"
    path.write_bytes(noise)
    with pytest.raises(NeurframeError):
        load_model(path)

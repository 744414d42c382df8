"""Damaged files: every reader returns a mesh or raises a NeurframeError, whatever the bytes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from test_mesh_readers import CUBE_T, CUBE_V, OVM

from neurframe_cli.errors import NeurframeError
from neurframe_cli.mesh.arrays import Surface, as_surface
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


def damage(draw: Callable[[st.SearchStrategy[int]], int], content: bytes) -> bytes:
    """Some bytes overwritten, cut out, doubled, or the end torn off."""
    broken = bytearray(content)
    for _ in range(draw(st.integers(1, 6))):
        at = draw(st.integers(0, max(len(broken) - 1, 0)))
        length = draw(st.integers(1, 12))
        what = draw(st.integers(0, 4))
        if what == 0:
            broken[at : at + length] = bytes(draw(st.integers(0, 255)) for _ in range(length))
        elif what == 1:
            del broken[at : at + length]
        elif what == 2:
            broken[at:at] = broken[at : at + length]
        elif what == 3:
            broken[at : at + 1] = str(draw(st.sampled_from([-1, 0, 7, 8, 99, 2**31, 2**63, 10**30]))).encode()
        else:
            del broken[at:]
    return bytes(broken)


@pytest.mark.parametrize("name", NAMES)
def test_damaged_files(name: str, tmp_path: Path) -> None:
    content = undamaged(name, tmp_path)
    path = tmp_path / f"damaged{Path(name).suffix}"

    @settings(max_examples=60, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
    @given(st.data())
    def check(data: st.DataObject) -> None:
        path.write_bytes(damage(data.draw, content))
        try:
            model = load_model(path)
            if isinstance(model, Surface):
                surface, _ = clean_surface(model, path)
                assert np.isfinite(surface.V).all()
                assert surface.F.min() >= 0
                assert surface.F.max() < len(surface.V)
            else:
                mesh, features = model
                assert (tet_volumes(mesh.V, mesh.T) > 0).all()
                assert features.edges.max(initial=-1) < len(mesh.V)
        except NeurframeError as error:
            assert path.name in str(error)  # noqa: PT017 - both ways out are right

    check()


@given(st.binary(min_size=1, max_size=300))
@settings(max_examples=100, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
def test_noise(tmp_path_factory: pytest.TempPathFactory, noise: bytes) -> None:
    path = tmp_path_factory.getbasetemp() / "noise.stl"
    path.write_bytes(noise)
    with pytest.raises(NeurframeError):
        load_model(path)

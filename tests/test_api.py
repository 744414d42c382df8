"""The Python interface: its documentation runs, its arrays are those of the command line, its errors are named."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import neurframe_cli as nf
from neurframe_cli.errors import InvalidMesh, UsageError
from neurframe_cli.mesh.tet_adjacency import tet_adjacency
from neurframe_cli.pipeline.doctor import cube
from neurframe_cli.pipeline.manifest import read_manifest

DOCS = Path(__file__).parent.parent / "docs" / "api.md"


@pytest.fixture(scope="module")
def documented() -> dict[str, Any]:
    """The names that the code of docs/api.md leaves, and `printed`, what it prints."""
    blocks = re.findall(r"```python\n(.*?)```", DOCS.read_text(), re.DOTALL)
    assert len(blocks) == 2
    lines: list[str] = []
    names: dict[str, Any] = {"print": lambda *values: lines.append(" ".join(map(str, values)))}
    for block in blocks:
        exec(compile(block, str(DOCS), "exec"), names)
    return {**names, "printed": lines}


def test_documentation_prints_what_it_says(documented: dict[str, Any]) -> None:
    (said,) = re.findall(r"```\n\n    (.*)\n", DOCS.read_text())
    assert documented["printed"] == [said]


def test_results_have_the_shapes_that_they_promise(documented: dict[str, Any]) -> None:
    tets, frames = documented["tets"], documented["frames"]
    assert frames.frames.shape == (len(tets.T), 3, 3)
    assert np.allclose(frames.frames @ frames.frames.transpose(0, 2, 1), np.eye(3), atol=1e-9)
    assert frames.crosses.shape == (len(frames.carrier.F), 2, 3)
    assert documented["field"].field.query(tets.V).shape == (len(tets.V), 9)
    quads, hexes = documented["quads"], documented["hexes"]
    assert quads.cells.shape[1] == 4
    # a cube of side 1 into edges of sqrt(3)/10 and of 1/4: six and four to a side
    assert (len(quads.cells), len(hexes.cells)) == (6 * 6**2, 4**3)
    assert quads.valid
    assert hexes.valid
    assert hexes.problems == []


def test_stages_one_by_one_are_what_run_does(documented: dict[str, Any]) -> None:
    whole, tets, frames = documented["result"], documented["tets"], documented["frames"]
    assert np.array_equal(whole.tets.T, tets.T)
    assert np.array_equal(whole.tets.V, tets.V)
    assert np.allclose(whole.frames.frames, frames.frames)
    assert whole.quad is None


def test_workspace_is_kept_where_asked_and_goes_on(documented: dict[str, Any], tmp_path: Path) -> None:
    tets = documented["tets"]
    options = {
        "train_options": nf.TrainOptions(method="discrete", threads=1),
        "workspace": tmp_path / "part.neurframe",
    }
    seen: list[float] = []
    first = nf.run(tets.V, tets.T, quad=True, scale=6, progress=lambda x, text: seen.append(x), **options)
    assert first.quad is not None
    assert first.quad.valid
    assert seen == sorted(seen)
    started = read_manifest(tmp_path / "part.neurframe").stages["train"].started
    again = nf.run(tets.V, tets.T, quad=True, scale=6, **options)
    assert again.quad is not None
    assert np.array_equal(again.quad.V, first.quad.V)
    assert read_manifest(tmp_path / "part.neurframe").stages["train"].started == started


def test_given_feature_edges_count_instead_of_the_angle(documented: dict[str, Any]) -> None:
    tets = documented["tets"]
    edge = np.array([[[0.0, 0, 0], [1.0, 0, 0]]])
    alone = nf.tetize(tets.V, tets.T, nf.TetizeOptions(feature_segments=edge))
    ends = alone.V[alone.features.edges]
    assert np.allclose(ends[..., 1:], 0)
    assert np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1).sum() == pytest.approx(1)


@pytest.mark.parametrize(
    ("V", "F", "says"),
    [
        ([[0, 0]], [[0, 0, 0]], r"expected \(n, 3\)"),
        ([[0, 0, 0]], [[0.5, 0, 0]], "expected integers"),
        ([[0, 0, 0]], [[0, 0]], "expected integers"),
        ([[0, 0, 0]], [[0, 1, 2]], "only 1"),
        ([[0, 0, "x"]], [[0, 0, 0]], "no array of numbers"),
        ([[0, 0, np.nan], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], "finite"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], "open|volume|area"),
    ],
)
def test_arrays_that_are_no_mesh_are_named(V: Any, F: Any, says: str) -> None:
    with pytest.raises(InvalidMesh, match=says):
        nf.tetize(V, F)


def test_a_size_for_two_meshes_is_refused() -> None:
    with pytest.raises(UsageError, match="two would be made"):
        nf.run(cube().V, cube().F, scale=10)
    with pytest.raises(UsageError, match="only one"):
        nf.run(cube().V, cube().F, hex=True, scale=10, edge_length=1)


def test_tets_are_taken_as_they_are(documented: dict[str, Any]) -> None:
    tets = documented["tets"]
    same = nf.tetize(tets.V, tets.T)
    assert np.array_equal(same.T, tets.T)
    assert np.array_equal(tet_adjacency(same.T).boundary_faces, tet_adjacency(tets.T).boundary_faces)


def test_import_loads_nothing_heavy() -> None:
    script = "import sys, neurframe_cli; print([m for m in ('numpy', 'torch', 'click') if m in sys.modules])"
    shown = subprocess.run(
        [sys.executable, "-c", script], env=os.environ, capture_output=True, text=True, check=True
    )
    assert shown.stdout.strip() == "[]"
    assert set(nf.__all__) == set(dir(nf))
    with pytest.raises(AttributeError, match="no attribute"):
        _ = nf.no_such_thing

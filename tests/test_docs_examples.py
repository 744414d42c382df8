"""The worked example of the documentation, on a mesh made here: the closed form is met, better with finer hexes."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from smooth_shapes import cylinder_hexes

from neurframe_cli.mesh.read_cells import CellMesh
from neurframe_cli.mesh.write_cells import write_cells

sys.path.insert(0, str(Path(__file__).parent.parent / "docs" / "examples"))
from heat_in_a_cylinder import compare


def worst_error(path: Path, n: int) -> float:
    shape = cylinder_hexes(n, n, 2)
    write_cells(path, CellMesh("hex", shape.V, shape.cells))
    return compare(str(path)).worst


def test_heat_in_a_cylinder(tmp_path: Path) -> None:
    coarse, fine = (worst_error(tmp_path / f"{n}.vtk", n) for n in (4, 8))
    assert coarse < 0.05
    # second order: a quarter; a wrong corner order or a mantle not cooled would be wrong by the whole
    assert fine == pytest.approx(coarse / 4, rel=0.3)

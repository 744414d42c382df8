"""Every animal of the zoo through `neurframe tetize`: a checked tet mesh, or one clear line and the right exit code."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from zoo import ZOO, Animal

from neurframe_cli.cli.main import run_command_line
from neurframe_cli.mesh.arrays import Floats, Ints
from neurframe_cli.mesh.check_tets import tet_volumes
from neurframe_cli.mesh.read_tets import read_medit


def write_obj(path: Path, V: Floats, F: Ints) -> None:
    """As any program would write it, wrong numbers included."""
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in V.tolist()]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in F.tolist()]
    path.write_text("\n".join(lines) + "\n")


@pytest.mark.parametrize("name", ZOO)
def test_zoo(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    animal: Animal = ZOO[name]
    model, workspace = tmp_path / "model.obj", tmp_path / "model.neurframe"
    write_obj(model, *animal.shape)
    code = run_command_line(
        [
            "tetize",
            str(model),
            "-w",
            str(workspace),
            "--edge-length",
            str(animal.edge_length),
            "--timeout",
            "300",
            "-q",
        ]
    )
    said = capsys.readouterr().err
    assert code in animal.codes, said
    assert "Traceback" not in said
    if code != 0:
        assert sum(line.startswith("neurframe: error: ") for line in said.splitlines()) == 1, said
        assert not (workspace / "tets.mesh").exists()
        return
    tets, _ = read_medit(workspace / "tets.mesh")
    volumes = tet_volumes(tets.V, tets.T)
    assert volumes.min() > 0
    if animal.volume is not None:
        assert volumes.sum() == pytest.approx(animal.volume, rel=0.02)
    extent = np.ptp(tets.V, axis=0) / np.ptp(animal.shape[0], axis=0)
    assert extent == pytest.approx(np.ones(3), abs=0.05)

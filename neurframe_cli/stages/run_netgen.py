"""One run of Netgen in a child process: tets inside a closed surface, which keeps its triangles."""

from __future__ import annotations

import importlib.util
import os
import sys
from pathlib import Path

import numpy as np

import neurframe_cli
from neurframe_cli.errors import ChildCrashed, StageError, UsageError
from neurframe_cli.mesh.arrays import Surface, TetMesh
from neurframe_cli.process import run_child

PACKAGE = Path(neurframe_cli.__file__).resolve().parent


def require_netgen() -> None:
    """Raises UsageError where Netgen is not installed."""
    if importlib.util.find_spec("netgen") is None:
        raise UsageError(
            "--fill needs Netgen for the tets, which is not installed",
            hint="pip install 'neurframe[fill]' (Netgen is under the LGPL and runs as a program of its own)",
        )


def run_netgen(
    surface: Surface,
    edge_length: float,
    *,
    timeout_s: float | None,
    memory_mib: float | None,
    scratch_dir: Path,
) -> TetMesh:
    """Tets of positive volume in the closed surface, whose vertices come first and whose triangles all are faces.

    edge_length: of the tets at most, in units of the surface.  Raises ChildCrashed where Netgen fails, and what
    run_child raises.
    """
    source, target = scratch_dir / "netgen_input.npz", scratch_dir / "netgen_output.npz"
    target.unlink(missing_ok=True)
    np.savez(source, V=surface.V, F=surface.F, edge_length=edge_length)
    result = run_child(
        [sys.executable, "-m", "neurframe_cli.stages.netgen_worker", source, target],
        name="Netgen",
        timeout_s=timeout_s,
        memory_mib=memory_mib,
        env={
            "PYTHONPATH": os.pathsep.join(
                [str(PACKAGE.parent), *filter(None, [os.environ.get("PYTHONPATH")])]
            )
        },
        cwd=scratch_dir,
        accept=(0, 1),
    )
    if result.returncode != 0 or not target.exists():
        raise ChildCrashed(
            f"Netgen gave up: {result.last_lines[-1] if result.last_lines else 'it said nothing'}"
        )
    with np.load(target, allow_pickle=False) as arrays:
        V, T = arrays["V"], arrays["T"]
    if not np.array_equal(V[: len(surface.V)], surface.V):
        raise StageError("Netgen moved vertices of the surface that it was given")
    return TetMesh(V, T[:, [1, 0, 2, 3]])  # Netgen's tets are left-handed

"""One run of fTetWild in a child process."""

from __future__ import annotations

import json
import os
import re
import sys
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

import neurframe_cli
from neurframe_cli.errors import ChildCrashed
from neurframe_cli.mesh.arrays import Floats, Ints, Progress, Surface
from neurframe_cli.process import run_child
from neurframe_cli.stages.tetize_worker import REFUSED

PACKAGE = Path(neurframe_cli.__file__).resolve().parent
SEED_LIBRARY = PACKAGE / "bin" / "libneurframe_seed.so"
PASS = re.compile(r"//+ (pass (?P<number>\d+)|postprocessing) //+")
# how far along fTetWild is when it says this; the passes come after
MILESTONES = {"Tetrahedralization performed.": 0.05, "initializing...": 0.15}


@dataclass(frozen=True)
class TetwildSettings:
    """fTetWild's arguments: lengths as fractions of the bounding-box diagonal, num_threads 0 for all cores.

    decimate: whether the surface was decimated before, which fTetWild is not told.
    """

    edge_length_fac: float
    epsilon: float
    simplify: bool = True
    num_threads: int = 1
    num_opt_iter: int = 80
    decimate: bool = False

    def arguments(self) -> dict[str, Any]:
        """For pytetwild.tetrahedralize."""
        return {name: value for name, value in asdict(self).items() if name != "decimate"}


@dataclass(frozen=True)
class TetwildRun:
    """What fTetWild left: V (n,3), T (m,4) unchecked; CPU seconds; peak MiB; whether the seed was in force."""

    V: Floats
    T: Ints
    cpu_seconds: float
    peak_mib: float
    seeded: bool


def seed_library() -> Path | None:
    """The library that pins std::random_device: $NEURFRAME_SEED_LIBRARY, else the installed one; None off Linux."""
    path = Path(os.environ.get("NEURFRAME_SEED_LIBRARY", SEED_LIBRARY))
    return path if sys.platform.startswith("linux") and path.is_file() else None


def run_tetwild(
    surface: Surface,
    settings: TetwildSettings,
    *,
    seed: int,
    timeout_s: float,
    silence_s: float | None,
    memory_mib: float,
    progress: Progress,
    scratch_dir: Path,
) -> TetwildRun:
    """Runs fTetWild on a validated surface; files of the run stay in `scratch_dir`.

    Raises ChildCrashed (a signal, a Python error in the child, nothing written), ChildOutOfMemory, TimedOut; OSError
    where the result could not be written, which no other settings help against.
    """
    source, target = scratch_dir / "tetwild_input.npz", scratch_dir / "tetwild_output.npz"
    target.unlink(missing_ok=True)
    np.savez(source, V=surface.V, F=surface.F)
    library = seed_library()
    result = run_child(
        [
            sys.executable,
            "-P",  # nothing that lies in the folder where it runs is a module
            "-m",
            "neurframe_cli.stages.tetize_worker",
            source,
            target,
            json.dumps(settings.arguments()),
        ],
        name="fTetWild",
        timeout_s=timeout_s,
        silence_s=silence_s,
        memory_mib=memory_mib,
        env=_environment(library, seed),
        cwd=scratch_dir,  # fTetWild leaves debugging files where it runs
        on_line=_follow(progress),
        accept=(0, 1, REFUSED),
    )
    if result.returncode == REFUSED:
        number = int(result.last_lines[-1])
        raise OSError(number, os.strerror(number), str(target))
    if result.returncode != 0 or not target.exists():
        raise ChildCrashed(
            f"fTetWild gave up: {result.last_lines[-1] if result.last_lines else 'it said nothing'}"
        )
    with np.load(target, allow_pickle=False) as arrays:
        V, T = arrays["V"], arrays["T"]
    return TetwildRun(V, T, result.cpu_seconds, result.peak_mib, library is not None)


def _environment(library: Path | None, seed: int) -> dict[str, str]:
    path = os.pathsep.join([str(PACKAGE.parent), *filter(None, [os.environ.get("PYTHONPATH")])])
    environment = {"PYTHONPATH": path, "NEURFRAME_SEED": str(seed)}
    if library is not None:
        environment["LD_PRELOAD"] = str(library)
    return environment


def _follow(progress: Progress) -> Callable[[str], None]:
    """Turns fTetWild's log into progress; the number of passes is unknown, so the rest shrinks with each."""

    def on_line(line: str) -> None:
        if line in MILESTONES:
            progress(MILESTONES[line], "fTetWild: inserting the surface")
        match = PASS.match(line)
        if match and match["number"]:
            number = int(match["number"]) + 1
            progress(0.95 - 0.75 * 0.8**number, f"fTetWild: optimising, pass {number}")
        elif match:
            progress(0.95, "fTetWild: finishing")

    return on_line

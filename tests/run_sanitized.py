"""Run the executables of a sanitizer build over maps and workspaces: `run_sanitized.py BUILD [--threads N] [PATH...]`.

A PATH is a map (.hexex, or .obj with texture coordinates), a workspace with tets, frames and crosses, or a folder of
them; without one, the maps and workspaces of $NEURFRAME_MODELS, else a cube made here.  Exit code 1 when an executable
ended otherwise than documented, which every report of a sanitizer does.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from fuzz_targets import TARGETS

from neurframe_cli.mesh.arrays import as_surface
from neurframe_cli.mesh.write_mesh import write_surface

DOCUMENTED = (0, 2, 3, 4)


def runs_of(path: Path, scratch: Path) -> Iterator[tuple[str, list[str]]]:
    """Program and arguments for everything that a path has."""
    if path.suffix == ".hexex":
        yield "hexex", [str(path), "-o", str(scratch / "hex.mesh"), "--partial-boundary"]
    elif path.suffix == ".obj":
        yield "qex", [str(path), "-o", str(scratch / "quad.obj")]
    elif (path / "tets.fra").is_file():
        features = ["--features", str(path / "features.json")] if (path / "features.json").is_file() else []
        tets, frames, map_file = str(path / "tets.mesh"), str(path / "tets.fra"), str(scratch / "map.hexex")
        yield "cubecover", [tets, frames, "-o", map_file, "--scale", "10", "--retries", "0", *features]
        yield "hexex", [map_file, "-o", str(scratch / "hex.mesh"), "--partial-boundary"]
    if (path / "cross.npz").is_file():
        yield "miq", [*_crosses_of(path, scratch), "-o", str(scratch / "map.obj"), "--scale", "15"]
        yield "qex", [str(scratch / "map.obj"), "-o", str(scratch / "quad.obj")]


def _crosses_of(workspace: Path, scratch: Path) -> list[str]:
    with np.load(workspace / "cross.npz", allow_pickle=False) as arrays:
        surface, crosses = as_surface(arrays["V"], arrays["F"]), arrays["crosses"]
    write_surface(scratch / "surface.obj", surface)
    np.savetxt(scratch / "crosses.txt", crosses.reshape(-1, 6))
    return [str(scratch / "surface.obj"), str(scratch / "crosses.txt")]


def found_in(folder: Path) -> list[Path]:
    """The folder itself where it is a workspace, else the maps and workspaces in it, two levels down."""
    if folder.is_file() or (folder / "tets.fra").is_file():
        return [folder]
    maps = (found for name in ("*.hexex", "hexex/*.hexex", "*/map.obj") for found in folder.glob(name))
    return sorted([*maps, *(frames.parent for frames in folder.glob("*/tets.fra"))])


def made_here(folder: Path) -> list[Path]:
    """A cube as maps and as a workspace."""
    for name in ("hexex map", "qex map", "cubecover tets.mesh", "crosses"):
        next(target for target in TARGETS if target.name == name).prepare(folder)
    return [folder / "map.hexex", folder / "map.obj", folder]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("build", type=Path)
    parser.add_argument("paths", nargs="*", type=Path)
    parser.add_argument("--threads", default="1")
    options = parser.parse_args()
    codes: list[int] = []
    with tempfile.TemporaryDirectory() as name:
        models = os.environ.get("NEURFRAME_MODELS")
        given = options.paths or ([Path(models)] if models else [])
        paths = [path for folder in given for path in found_in(folder)] or made_here(Path(name))
        for path in paths:
            for program, arguments in runs_of(path, Path(name)):
                command = [
                    options.build / program / f"neurframe-{program}",
                    *arguments,
                    "--threads",
                    options.threads,
                ]
                ended = subprocess.run(command, capture_output=True, text=True, errors="replace", check=False)
                codes.append(ended.returncode)
                print(f"{ended.returncode:4} {program:10} {path}", flush=True)
                if ended.returncode not in DOCUMENTED:
                    print(ended.stderr[-3000:])
    bad = sum(code not in DOCUMENTED for code in codes)
    print(f"{len(codes)} runs, {len(codes) - bad} ended as documented")
    return int(bad > 0)


if __name__ == "__main__":
    sys.exit(main())

"""Where the programs of the pipeline are: those built with the package, or others with the same file formats."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

from neurframe_cli.errors import StageError, UsageError

PROGRAMS = ("miq", "qex", "cubecover", "hexex")
FOLDER = Path(__file__).parent.parent / "bin"


def variable_of(program: str) -> str:
    """The environment variable that names another executable for one of PROGRAMS."""
    return f"NEURFRAME_{program.upper()}"


def find_executable(program: str) -> Path:
    """Path of the executable for one of PROGRAMS.

    The environment variable NEURFRAME_MIQ, NEURFRAME_QEX, NEURFRAME_CUBECOVER or NEURFRAME_HEXEX names another one.
    Raises UsageError where that is no executable file, StageError where ours was not built.
    """
    variable = variable_of(program)
    chosen = os.environ.get(variable)
    if chosen:
        found = shutil.which(chosen)
        if found is None:
            raise UsageError(
                f"{variable}={chosen} is not an executable file", hint=f"unset {variable} to use ours"
            )
        return Path(found)
    path = FOLDER / f"neurframe-{program}"
    if not os.access(path, os.X_OK):
        raise StageError(f"the executable {path.name} is not there", hint="pip install neurframe builds it")
    return path

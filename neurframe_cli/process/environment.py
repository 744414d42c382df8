"""The environment that a child process sees: what it needs and nothing else."""

from __future__ import annotations

import os
from collections.abc import Mapping

# a program finds its libraries, home and temporary files through these; everything else stays out, so that
# the result of a run does not depend on what happens to be exported
INHERITED = (
    "PATH",
    "HOME",
    "TMPDIR",
    "LANG",
    "LC_ALL",
    "LC_CTYPE",
    "LD_LIBRARY_PATH",
    "DYLD_LIBRARY_PATH",
    "VIRTUAL_ENV",
    "PYTHONPATH",
    "PYTHONHOME",
    "CUDA_VISIBLE_DEVICES",
)
OWN = "NEURFRAME_"  # settings for neurframe itself, which may be the child


def child_environment(
    extra: Mapping[str, str] | None = None, *, threads: int | None = None
) -> dict[str, str]:
    """Environment variables for a child: the inherited few and our own, the thread count where given, then `extra`."""
    environment = {
        name: value for name, value in os.environ.items() if name in INHERITED or name.startswith(OWN)
    }
    if threads is not None:
        for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
            environment[name] = str(threads)
    return environment | dict(extra or {})

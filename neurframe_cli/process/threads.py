"""How many threads our own loops may use."""

from __future__ import annotations

import os

VARIABLE = "OMP_NUM_THREADS"  # which --threads sets, and users do where they call us as a library


def usable_threads() -> int:
    """The number that the environment variable OMP_NUM_THREADS asks for (the first one of a list), or all cores."""
    wanted = os.environ.get(VARIABLE, "").split(",")[0].strip()
    return int(wanted) if wanted.isdecimal() and int(wanted) > 0 else len(os.sched_getaffinity(0))

"""CPU seconds and peak memory of a stage, its child processes included."""

from __future__ import annotations

import contextlib
import re
import resource
from pathlib import Path


class Usage:
    """Counts from the moment it is made."""

    def __init__(self) -> None:
        self._start = _cpu_seconds()
        # Linux forgets the high-water mark of this process when asked, so that each stage has its own
        with contextlib.suppress(OSError):
            Path("/proc/self/clear_refs").write_text("5")

    def cpu_seconds(self) -> float:
        """User and system seconds so far, of this process and of the children that have ended."""
        return round(_cpu_seconds() - self._start, 3)

    def peak_mib(self) -> float:
        """Largest resident size in MiB: of this process since the start, or of any child that has ended."""
        own = _high_water_mib()
        children = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
        return round(max(own, children), 1)


def _cpu_seconds() -> float:
    kinds = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    return sum(resource.getrusage(kind).ru_utime + resource.getrusage(kind).ru_stime for kind in kinds)


def _high_water_mib() -> float:
    with contextlib.suppress(OSError):
        found = re.search(r"VmHWM:\s*(\d+) kB", Path("/proc/self/status").read_text())
        if found:
            return int(found[1]) / 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024

"""CPU seconds and peak memory of a stage, its child processes included."""

from __future__ import annotations

import contextlib
import resource
from collections.abc import Iterator
from pathlib import Path

from neurframe_cli.process.child_peaks import child_peaks
from neurframe_cli.process.memory import high_water_mib


class Usage:
    """Counts from the moment it is made; `children`: peaks of those that have ended since, see child_peaks()."""

    def __init__(self, children: list[float]) -> None:
        self._children = children
        self._start = _cpu_seconds()
        # Linux forgets the high-water mark of this process when asked, so that each stage has its own
        with contextlib.suppress(OSError):
            Path("/proc/self/clear_refs").write_text("5")

    def cpu_seconds(self) -> float:
        """User and system seconds so far, of this process and of the children that have ended."""
        return round(_cpu_seconds() - self._start, 3)

    def peak_mib(self) -> float:
        """The most that this process alone, or this process and a child together, have held since the start, in MiB."""
        own = high_water_mib() or resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        return round(max([own, *self._children]), 1)


@contextlib.contextmanager
def measured() -> Iterator[Usage]:
    """The usage of what runs in the block."""
    with child_peaks() as peaks:
        yield Usage(peaks)


def _cpu_seconds() -> float:
    kinds = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    return sum(resource.getrusage(kind).ru_utime + resource.getrusage(kind).ru_stime for kind in kinds)

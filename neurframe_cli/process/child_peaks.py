"""How much memory the children of one piece of work took, and not those of the work before it.

The system keeps one high-water mark for all children that this process has ever had.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from contextvars import ContextVar

from neurframe_cli.process.memory import resident_now_mib

_PEAKS: ContextVar[list[float] | None] = ContextVar("neurframe_child_peaks", default=None)


@contextlib.contextmanager
def child_peaks() -> Iterator[list[float]]:
    """The list of peaks, in MiB, that grows by one with each child that ends in the block: the child's and ours."""
    peaks: list[float] = []
    token = _PEAKS.set(peaks)
    try:
        yield peaks
    finally:
        _PEAKS.reset(token)


def note_child(peak_mib: float) -> None:
    """A child has ended; what this process holds at that moment it held beside the child."""
    peaks = _PEAKS.get()
    if peaks is not None:
        peaks.append(peak_mib + resident_now_mib())

"""Memory and end of a child together with everything that it has started."""

from __future__ import annotations

import ctypes
import os
import resource
import signal
import sys
import time
from collections.abc import Callable

PR_SET_PDEATHSIG = 1
_LIBC = ctypes.CDLL(None, use_errno=True) if sys.platform.startswith("linux") else None


def die_with_parent() -> Callable[[], None]:
    """What the child does between fork and exec: asks to be killed when we die, and leaves no core file.

    Everything that takes a lock (imports, library look-ups) happens here in the parent; after a fork in a
    process with threads only system calls are safe.
    """
    parent = os.getpid()

    def prepare() -> None:
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        if _LIBC is not None:
            _LIBC.prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
            if os.getppid() != parent:  # the parent died before the request was in place
                os._exit(1)

    return prepare


def resident_mib(pid: int) -> float:
    """Resident memory of process `pid` and its descendants in MiB; 0 when it has ended."""
    import psutil

    try:
        process = psutil.Process(pid)
        family = [process, *process.children(recursive=True)]
    except psutil.Error:
        return 0.0
    total = 0
    for member in family:
        try:
            total += member.memory_info().rss
        except psutil.Error:  # ended since it was listed
            continue
    return total / 2**20


def signal_group(group: int, number: signal.Signals) -> None:
    """Sends a signal to every process of a group; a group that is gone is fine."""
    try:
        os.killpg(group, number)
    except ProcessLookupError:
        return
    except PermissionError:  # macOS answers so for a group of zombies
        return


def end_group(group: int, has_ended: Callable[[], bool], *, grace_s: float) -> None:
    """TERM to the group, KILL to what is left of it after `grace_s` seconds."""
    signal_group(group, signal.SIGTERM)
    deadline = time.monotonic() + grace_s
    while not has_ended() and time.monotonic() < deadline:
        time.sleep(0.02)
    signal_group(group, signal.SIGKILL)

"""Memory in MiB: what a process has used, and what is free for one."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterator
from pathlib import Path

MIB = 1 << 20
SPARE_MIB = 512  # what is left to the rest of the machine
_CGROUPS = Path("/sys/fs/cgroup")


def high_water_mib(pid: int | str = "self") -> float:
    """Largest resident size of a process since it began to run its program; 0 where the system does not say."""
    return _status_mib(pid, "VmHWM")


def resident_now_mib() -> float:
    """Resident size of this process; 0 where the system does not say."""
    return _status_mib("self", "VmRSS")


def free_mib() -> float:
    """What can be taken before the machine, or the control group that this process is in, runs out of memory."""
    import psutil

    return min([float(psutil.virtual_memory().available), *_left_in_groups()]) / MIB


def usable_mib() -> float:
    """What is free less a spare, for a process that was given no limit."""
    return max(free_mib() - SPARE_MIB, SPARE_MIB)


def _status_mib(pid: int | str, name: str) -> float:
    with contextlib.suppress(OSError):
        found = re.search(rf"{name}:\s*(\d+) kB", Path(f"/proc/{pid}/status").read_text())
        if found:
            return int(found[1]) / 1024
    return 0.0


def _left_in_groups() -> Iterator[int]:
    """Bytes left in this process's control group of version 2 and in all that it lies in: a limit of any holds."""
    group = next((line[3:] for line in _lines(Path("/proc/self/cgroup")) if line.startswith("0::")), None)
    if group is None:
        return
    folder = _CGROUPS / group.strip().lstrip("/")
    for level in (folder, *folder.parents):
        if level.is_relative_to(_CGROUPS):
            yield from _left_in(level)


def _left_in(group: Path) -> Iterator[int]:
    limit = next(_lines(group / "memory.max"), "max").strip()
    used = next(_lines(group / "memory.current"), "").strip()
    if limit.isdigit() and used.isdigit():
        # files that nobody has open are given back when memory runs short
        cached = next(
            (int(s.split()[1]) for s in _lines(group / "memory.stat") if s.startswith("inactive_file ")), 0
        )
        yield max(int(limit) - int(used) + cached, 0)


def _lines(path: Path) -> Iterator[str]:
    with contextlib.suppress(OSError):
        yield from path.read_text().splitlines()

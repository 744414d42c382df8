"""Damage to files, for the fuzz tests: seeded, so that a finding can be made again; and the limits for reading them."""

from __future__ import annotations

import os
import random
import resource
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

HOSTILE_NUMBERS = (-1, 0, 7, 8, 99, 2**31, 2**63, 10**30)
HOSTILE_WORDS = (
    "nan",
    "inf",
    "-inf",
    "1e999",
    "1e-400",
    "1/0",
    "null",
    "true",
    "{}",
    "[[",
    '"',
    "\u00e9",
    "\0",
)

# cases per target: a few in every test run, NEURFRAME_FUZZ_CASES=5000 for a long search
CASES = int(os.environ.get("NEURFRAME_FUZZ_CASES", "40"))
FIRST_SEED = int(os.environ.get("NEURFRAME_FUZZ_SEED", "0"))

# CPU and not wall seconds: a busy machine is no hang
READER_CPU_LIMIT_S = 2  # a file of a kilobyte takes milliseconds
PROGRAM_CPU_LIMIT_S = 20  # an executable reads and solves
READER_MEMORY_MIB = 512  # more than importing meshio and VTK takes; a file of a kilobyte needs none of it


class StillReading(BaseException):
    """No Exception: a reader that turns whatever a library raises into its own error must not swallow the alarm."""


@contextmanager
def reading_limits() -> Iterator[None]:
    """StillReading after READER_CPU_LIMIT_S of this process; AssertionError where its peak memory grew by too much."""

    def stop(_number: int, _frame: FrameType | None) -> None:
        raise StillReading(f"after {READER_CPU_LIMIT_S} CPU seconds")

    peak_kib = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, READER_CPU_LIMIT_S)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)
        grown_mib = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - peak_kib) >> 10
        assert grown_mib < READER_MEMORY_MIB, f"{grown_mib} MiB for a damaged file"


def damaged(content: bytes, rng: random.Random) -> bytes:
    """One to six times: bytes overwritten, cut out, doubled, a word replaced, or the end torn off."""
    broken = bytearray(content)
    for _ in range(rng.randint(1, 6)):
        _hurt(broken, rng)
    return bytes(broken)


def _hurt(broken: bytearray, rng: random.Random) -> None:
    at, length = rng.randint(0, max(len(broken) - 1, 0)), rng.randint(1, 12)
    match rng.choice(("noise", "noise", "cut", "double", "word", "word", "word", "end")):
        case "noise":
            broken[at : at + length] = rng.randbytes(length)
        case "cut":
            del broken[at : at + length]
        case "double":
            broken[at:at] = broken[at : at + length]
        case "word":
            start, end = _word_at(broken, at)
            broken[start:end] = str(rng.choice(HOSTILE_NUMBERS + HOSTILE_WORDS)).encode()
        case "end":
            del broken[at:]


def _word_at(content: bytearray, at: int) -> tuple[int, int]:
    """Ends of the number or name around a position: what a reader takes for one token."""

    def inside(i: int) -> bool:
        return 0 <= i < len(content) and (chr(content[i]).isalnum() or content[i] in b"+-._")

    start = end = at
    while inside(start - 1):
        start -= 1
    while inside(end):
        end += 1
    return start, end

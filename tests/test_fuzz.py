"""Damaged files of every kind: read, or refused in one line; never a traceback, a crash, a hang or much memory."""

from __future__ import annotations

import random
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

import pytest
from damage import CASES, FIRST_SEED, damaged
from fuzz_targets import CPU_LIMIT_S, TARGETS, Target

from neurframe_cli.errors import NeurframeError


@contextmanager
def cpu_limit(seconds: float) -> Iterator[None]:
    """AssertionError after so many CPU seconds of this process."""

    def stop(_number: int, _frame: FrameType | None) -> None:
        raise AssertionError(f"still reading after {seconds} CPU seconds")

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


@pytest.mark.parametrize("target", TARGETS, ids=lambda target: target.name)
def test_good_files_are_read(target: Target, tmp_path: Path) -> None:
    target.prepare(tmp_path)
    target.read(tmp_path)


@pytest.mark.parametrize("target", TARGETS, ids=lambda target: target.name)
def test_damaged_files(target: Target, tmp_path: Path) -> None:
    target.prepare(tmp_path)
    path = tmp_path / target.damage
    content = path.read_bytes()
    for seed in range(FIRST_SEED, FIRST_SEED + CASES):
        path.write_bytes(damaged(content, random.Random(seed)))
        try:
            with cpu_limit(CPU_LIMIT_S):
                target.read(tmp_path)
        except NeurframeError as error:
            if "\n" in str(error):
                raise AssertionError(f"seed {seed}: more than one line: {error}") from error
        except Exception as error:
            raise AssertionError(f"seed {seed}: {type(error).__name__}: {error}") from error

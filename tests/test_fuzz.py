"""Damaged files of every kind: read, or refused in one line; never a traceback, a crash, a hang or much memory."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from damage import CASES, FIRST_SEED, StillReading, damaged, reading_limits
from fuzz_targets import TARGETS, Target

from neurframe_cli.errors import NeurframeError


@pytest.mark.parametrize("target", TARGETS, ids=lambda target: target.name)
def test_good_files_are_read(target: Target, tmp_path: Path) -> None:
    target.prepare(tmp_path)
    target.read(tmp_path)


@pytest.mark.parametrize("target", TARGETS, ids=lambda target: target.name)
def test_damaged_files(target: Target, tmp_path: Path) -> None:
    target.prepare(tmp_path)
    target.read(tmp_path)  # loads the libraries, whose seconds are not those of a reader
    path = tmp_path / target.damage
    content = path.read_bytes()
    for seed in range(FIRST_SEED, FIRST_SEED + CASES):
        path.write_bytes(damaged(content, random.Random(seed)))
        try:
            with reading_limits():
                target.read(tmp_path)
        except NeurframeError as error:
            if "\n" in str(error):
                raise AssertionError(f"seed {seed}: more than one line: {error}") from error
        except (Exception, StillReading) as error:
            raise AssertionError(f"seed {seed}: {type(error).__name__}: {error}") from error

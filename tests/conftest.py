"""What all tests need."""

from __future__ import annotations

import os
import signal
import sys
from pathlib import Path

import faults
import pytest

# A shell that runs the tests in the background has them ignore Ctrl-C, and so would every process that they start
# and interrupt.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# `python -P` tests what is installed, not the sources beside it; so do the processes that the tests start.
if sys.flags.safe_path:
    os.environ["PYTHONSAFEPATH"] = "1"


@pytest.fixture(scope="session")
def staged(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Workspaces of the sample cube: for each stage the one in which it can be run, and "done"."""
    return faults.build(tmp_path_factory.mktemp("staged"))

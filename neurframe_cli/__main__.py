"""`neurframe` and `python -m neurframe_cli`: the one boundary where every failure becomes a line and an exit code."""

from __future__ import annotations

import atexit
import contextlib
import os
import sys

INTERRUPTED = 130


def main() -> None:
    """Run the command line and leave with the documented exit code."""
    codes: list[int] = []
    atexit.register(_end_interrupted, codes)  # what is registered first is called last
    _open_standard_streams()
    try:
        from neurframe_cli.cli.main import run_command_line

        codes.append(run_command_line(sys.argv[1:]))
    except KeyboardInterrupt:  # while the program was being loaded, or a second one while it was ending
        codes.append(INTERRUPTED)
    sys.exit(codes[-1])


def _end_interrupted(codes: list[int]) -> None:
    """Leaves with INTERRUPTED where that is the last code.

    An interpreter in which a Ctrl-C came out of exec or eval of a text (a named tuple is made by one) remembers
    that, whoever has caught it: at the end of `python -m` it sends SIGINT to itself instead of leaving with the code.
    """
    if codes[-1:] == [INTERRUPTED]:
        for stream in (sys.stdout, sys.stderr):
            with contextlib.suppress(OSError, ValueError):
                stream.flush()
        os._exit(INTERRUPTED)


def _open_standard_streams() -> None:
    """Give a program that was started without standard streams such as lead nowhere.

    Otherwise the next files that are opened become the standard streams, and an artifact gets what is printed.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # the lowest number that is free is this one
    sys.stdin = sys.stdin or os.fdopen(0, encoding="utf-8", closefd=False)
    sys.stdout = sys.stdout or os.fdopen(1, "w", encoding="utf-8", closefd=False)
    sys.stderr = sys.stderr or os.fdopen(2, "w", encoding="utf-8", closefd=False)


if __name__ == "__main__":
    main()

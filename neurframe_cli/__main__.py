"""`neurframe` and `python -m neurframe_cli`: the one boundary where every failure becomes a line and an exit code."""

from __future__ import annotations

import sys

from neurframe_cli.cli.main import run_command_line


def main() -> None:
    """Run the command line and leave with the documented exit code."""
    sys.exit(run_command_line(sys.argv[1:]))


if __name__ == "__main__":
    main()

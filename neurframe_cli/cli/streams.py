"""The two standard streams, whatever has become of the terminal, pipe or file behind them."""

from __future__ import annotations

import io
import os
import sys

import click

from neurframe_cli.errors import StageError


def tolerate_every_character() -> None:
    """A name that the locale has no characters for is no reason to fail: it is written with escapes."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def tell(text: str) -> None:
    """A line on standard error; where that is closed or full the work goes on in silence."""
    try:
        click.echo(text, err=True)
    except OSError:
        lead_nowhere(2)


def show(text: str) -> None:
    """What was asked for, on standard output; raises StageError where it cannot be written.

    A reader that has gone, as in `neurframe ... | head`, has read what it wanted to: the command ends as it would have.
    """
    try:
        click.echo(text)
        sys.stdout.flush()
    except BrokenPipeError:
        lead_nowhere(1)
    except OSError as error:
        lead_nowhere(1)
        raise StageError(f"cannot write to standard output: {error.strerror}") from error


def lead_nowhere(number: int) -> None:
    """Let the stream take what is still in its buffer, of which Python would complain when it ends."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, number)
    os.close(nowhere)

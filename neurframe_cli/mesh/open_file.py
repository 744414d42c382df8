"""What every reader does first: is there a file, may it be read, is it of a sane size?"""

from __future__ import annotations

import contextlib
import io
import os
import warnings
from collections.abc import Iterator
from pathlib import Path

from neurframe_cli.errors import InvalidMesh, NeurframeError, UnreadableFile

# A mesh of this size has some 40 million triangles; parsed it takes ten times as much memory.
MAX_FILE_BYTES = 2 << 30


def check_file(path: Path, largest: int = MAX_FILE_BYTES) -> None:
    """Raises UnreadableFile unless `path` is a regular, readable file with 1 to `largest` bytes."""
    try:
        if not path.exists():
            raise UnreadableFile(f"{path}: no such file")
        if not path.is_file():
            raise UnreadableFile(f"{path}: not a file", hint="name one mesh file")
        size = path.stat().st_size
    except (OSError, ValueError) as error:  # ValueError: a NUL byte in the name
        raise UnreadableFile(f"{path}: {error}") from error
    if not os.access(path, os.R_OK):
        raise UnreadableFile(f"{path}: no permission to read it")
    if size == 0:
        raise UnreadableFile(f"{path}: the file is empty")
    if size > largest:
        raise UnreadableFile(
            f"{path}: {size / 2**20:.0f} MiB, at most {largest >> 20} MiB are read",
            hint="simplify the mesh first" if largest == MAX_FILE_BYTES else None,
        )


def read_bytes(path: Path, largest: int = MAX_FILE_BYTES) -> bytes:
    """The whole file; raises UnreadableFile."""
    check_file(path, largest)
    try:
        return path.read_bytes()
    except OSError as error:
        raise UnreadableFile(f"{path}: {error}") from error


@contextlib.contextmanager
def quiet() -> Iterator[io.StringIO]:
    """Around a library call: its prints and warnings go into the string that is yielded."""
    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield said


@contextlib.contextmanager
def foreign_reader(path: Path, library: str) -> Iterator[None]:
    """Around a call of `library` that reads `path`: what it prints is dropped, what it raises is UnreadableFile.

    The libraries answer a bad file with whatever exception their parser runs into, meshio with SystemExit too.
    """
    said = io.StringIO()
    try:
        with quiet() as said:
            yield
    except NeurframeError:
        raise
    except (Exception, SystemExit) as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        if isinstance(error, SystemExit):
            reason = " ".join(said.getvalue().split()) or "the reader gave up"
        raise UnreadableFile(
            f"{path}: {library} cannot read it ({reason[:200]})",
            hint="is the file complete, and is it what its name says?",
        ) from error


def refuse_empty(path: Path, what: str, count: int) -> None:
    """Raises InvalidMesh when a file has no elements of the kind that is wanted."""
    if count == 0:
        raise InvalidMesh(f"{path}: the file has no {what}")

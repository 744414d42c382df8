"""Files that are either whole or not there: written under a temporary name, fsynced, renamed."""

from __future__ import annotations

import contextlib
import errno
import fcntl
import hashlib
import json
import os
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from neurframe_cli.errors import StageError

TEMPORARY_PREFIX = ".neurframe-tmp-"


@contextlib.contextmanager
def atomic_path(path: Path) -> Iterator[Path]:
    """A temporary path with the suffix of `path` in the same folder, renamed to `path` when the block succeeds.

    Raises StageError where the disk is full or the folder cannot be written.
    """
    try:
        handle, name = tempfile.mkstemp(prefix=TEMPORARY_PREFIX, suffix=path.suffix, dir=path.parent)
    except OSError as error:
        raise write_error(path, error) from error
    temporary = Path(name)
    try:
        _mark_in_use(handle)
        yield temporary
        _settle(temporary, path)
    except OSError as error:
        raise write_error(path, error) from error
    finally:
        temporary.unlink(missing_ok=True)
        os.close(handle)


def _settle(temporary: Path, path: Path) -> None:
    """Make the content durable, give it the permissions of a new file, then the name, then make the name durable."""
    with temporary.open("rb") as written:
        os.fsync(written.fileno())
    umask = os.umask(0)
    os.umask(umask)
    temporary.chmod(0o666 & ~umask)
    temporary.replace(path)
    folder = os.open(path.parent, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)


def write_error(path: Path, error: OSError) -> StageError:
    """The StageError for a failed write: full disk, read-only folder, or what the system said."""
    if error.errno in (errno.ENOSPC, errno.EDQUOT):
        return StageError(
            f"cannot write {path}: the disk is full", hint="free some space and run the same command again"
        )
    if error.errno in (errno.EACCES, errno.EROFS, errno.EPERM):
        return StageError(f"cannot write {path}: permission denied", hint="choose another folder with -w")
    return StageError(f"cannot write {path}: {error.strerror or error}")


def write_json(path: Path, value: Any) -> None:
    """Write a JSON file atomically; the same value gives the same bytes."""
    with atomic_path(path) as temporary:
        temporary.write_text(json.dumps(value, indent=1, sort_keys=True, allow_nan=False) + "\n")


def remove_leftovers(folder: Path) -> None:
    """Delete temporary files and folders that a killed process left, and none that a living one works on.

    The workspace's lock does not keep all others out: a report may be written while a stage runs.
    """
    for leftover in folder.glob(TEMPORARY_PREFIX + "*"):
        if _is_in_use(leftover):
            continue
        if leftover.is_dir() and not leftover.is_symlink():
            shutil.rmtree(leftover)
        else:
            leftover.unlink(missing_ok=True)


def _mark_in_use(handle: int) -> None:
    """Lock an open temporary file or folder; the system drops the lock when its holder dies."""
    with contextlib.suppress(OSError):  # a file system without locks
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)


def _is_in_use(leftover: Path) -> bool:
    try:
        handle = os.open(leftover, os.O_RDONLY | os.O_NOFOLLOW | os.O_CLOEXEC)
    except OSError:  # a link, or gone
        return False
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        return False
    finally:
        os.close(handle)
    return False


@contextlib.contextmanager
def scratch_folder(parent: Path) -> Iterator[Path]:
    """A folder for the files between two programs, gone at the end of the block."""
    try:
        scratch = tempfile.TemporaryDirectory(prefix=TEMPORARY_PREFIX, dir=parent.resolve())
    except OSError as error:
        raise write_error(parent, error) from error
    with scratch as name:
        handle = os.open(name, os.O_RDONLY | os.O_CLOEXEC)
        try:
            _mark_in_use(handle)
            yield Path(name)
        finally:
            os.close(handle)


def sha256_of(path: Path) -> str:
    """Hex digest of the file's content."""
    with path.open("rb") as content:
        return hashlib.file_digest(content, "sha256").hexdigest()

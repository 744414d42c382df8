"""Option values from TOML files: --config FILE, the workspace's neurframe.toml, the current directory's."""

from __future__ import annotations

import contextlib
import difflib
import os
import shutil
import tomllib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import click

from neurframe_cli.errors import UnreadableFile, UsageError
from neurframe_cli.mesh.open_file import read_bytes
from neurframe_cli.pipeline.executables import PROGRAMS, variable_of

CONFIG_NAME = "neurframe.toml"
MAX_CONFIG_BYTES = 1 << 20
EXECUTABLES = "executables"  # the table that names other programs in place of ours


def config_files(explicit: Path | None, workspace: Path | None) -> list[Path]:
    """The files that apply, strongest first."""
    found = [explicit] if explicit is not None else []
    found += [folder / CONFIG_NAME for folder in (workspace, Path()) if folder is not None]
    return [path for path in dict.fromkeys(found) if path == explicit or path.is_file()]


def read_config(path: Path) -> dict[str, dict[str, Any]]:
    """Tables of a config file by command name; raises UnreadableFile or UsageError naming file and entry."""
    try:
        document = tomllib.loads(read_bytes(path, MAX_CONFIG_BYTES).decode("utf-8"))
    except UnicodeDecodeError as error:
        raise UnreadableFile(f"config file {path} cannot be read: {error}") from error
    except tomllib.TOMLDecodeError as error:
        raise UsageError(f"config file {path} is not valid TOML: {error}") from error
    for name, table in document.items():
        if not isinstance(table, dict):
            raise UsageError(
                f"config file {path}: {name!r} stands outside a table",
                hint="put it below [tetize], [train], ...",
            )
    return document


def defaults_for(
    command: click.Command, files: Sequence[Path], known_commands: Sequence[str]
) -> dict[str, Any]:
    """Option values for `command` from `files`, by parameter name; an unknown table or key is an error."""
    options = {config_key(option): option for option in command.params if isinstance(option, click.Option)}
    values: dict[str, Any] = {}
    for path in reversed(files):
        for name, table in read_config(path).items():
            _expect(name, [*known_commands, EXECUTABLES], f"config file {path}: there is no command {name!r}")
            if name != command.name:
                continue
            for key, value in table.items():
                _expect(key, list(options), f"config file {path}: `{name}` has no option {key!r}")
                if not _takes(options[key], value):
                    raise UsageError(
                        f"config file {path}: `{name}` takes no {type(value).__name__} for {key!r}"
                    )
                values[options[key].name or key] = value
    return values


@contextlib.contextmanager
def configured_executables(files: Sequence[Path], untrusted: Path | None = None) -> Iterator[None]:
    """Put the programs of the [executables] tables in place of ours; an environment variable beats the files.

    They travel as environment variables, so that the processes that a command starts see them too.  `untrusted` is the
    config file of the workspace: a folder that came from somebody else must not say what is run here.
    """
    for path in files:
        if (
            untrusted is not None
            and path.resolve() == untrusted.resolve()
            and EXECUTABLES in read_config(path)
        ):
            raise UsageError(
                f"config file {path} of the workspace names programs to run, which only your own files may",
                hint=f"if you trust it: --config {path}",
            )
    found = {variable_of(name): path for name, path in read_executables(files).items()}
    ours = {variable: path for variable, path in found.items() if not os.environ.get(variable)}
    os.environ.update(ours)
    try:
        yield
    finally:
        for variable in ours:
            del os.environ[variable]


def read_executables(files: Sequence[Path]) -> dict[str, str]:
    """Program -> path from the [executables] tables; relative paths count from the file that names them.

    Raises UsageError where a name is none of PROGRAMS or the file is not executable.
    """
    chosen: dict[str, str] = {}
    for path in reversed(files):
        for name, value in read_config(path).get(EXECUTABLES, {}).items():
            _expect(name, PROGRAMS, f"config file {path}: there is no program {name!r}")
            named = str(path.parent.resolve() / str(value)) if os.sep in str(value) else str(value)
            found = shutil.which(named)
            if found is None:
                raise UsageError(f"config file {path}: {name} = {value!r} is not an executable file")
            chosen[name] = found
    return chosen


def _takes(option: click.Option, value: Any) -> bool:
    """Whether a TOML value is of the option's kind: a flag takes true or false, which are no numbers elsewhere."""
    if option.is_flag or isinstance(value, bool):
        return option.is_flag and isinstance(value, bool)
    if isinstance(option.type, click.IntRange):
        return isinstance(value, int)
    return isinstance(value, int | float if isinstance(option.type, click.FloatRange) else str)


def config_key(option: click.Option) -> str:
    """What a config file calls an option: its long name."""
    return max(option.opts, key=len).lstrip("-")


def _expect(name: str, allowed: Sequence[str], message: str) -> None:
    if name not in allowed:
        close = difflib.get_close_matches(name, allowed, 1)
        raise UsageError(message, hint=f"{close[0]}" if close else f"one of {', '.join(sorted(allowed))}")

"""`neurframe config`: where options come from here, and all of them as TOML that --config reads back."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from neurframe_cli import __version__
from neurframe_cli.cli.command import StageCommand, config_files_of
from neurframe_cli.cli.configuration import EXECUTABLES, config_key, defaults_for, read_executables
from neurframe_cli.cli.options import workspace_option
from neurframe_cli.pipeline.executables import PROGRAMS

if TYPE_CHECKING:
    from neurframe_cli.cli.console import Console

_NOT_IN_FILES = ("config", "help")  # a config file names no further one


@click.command(name="config", cls=StageCommand)
@workspace_option
@click.option(
    "--dump", is_flag=True, help="Print every option of every command with its value here, as TOML."
)
@click.pass_context
def command(ctx: click.Context, workspace: Path | None, dump: bool, threads: int, console: Console) -> None:
    """Say which config files apply here, strongest first, or dump all options as a config file.

    Files: --config FILE, the workspace's neurframe.toml, the current directory's neurframe.toml.  The command line
    beats them all.
    """
    files = config_files_of(ctx)
    if dump:
        console.result("\n".join(_document(files)))
    elif files:
        console.result("\n".join(map(str, files)))
    else:
        console.log.info("no config file applies here; `neurframe config --dump > neurframe.toml` writes one")


def _document(files: Sequence[Path]) -> Iterator[str]:
    from neurframe_cli.cli.main import COMMANDS, group

    yield f"# neurframe {__version__}: every option with its value here; those without a value are commented out"
    for name in COMMANDS:
        command = group.get_command(click.Context(group), name)
        assert command is not None, "COMMANDS lists what get_command finds"
        yield f"\n[{name}]"
        given = defaults_for(command, files, list(COMMANDS))
        for option in command.params:
            if isinstance(option, click.Option) and option.name not in _NOT_IN_FILES:
                yield from _entry(option, given)
    yield f"\n[{EXECUTABLES}]"
    chosen = read_executables(files)
    for program in PROGRAMS:
        yield f"{program} = {_toml(chosen[program])}" if program in chosen else f"# {program} ="


def _entry(option: click.Option, given: dict[str, Any]) -> Iterator[str]:
    # click marks "no default" with a sentinel of its own since 8.3, also that of a flag that is off
    switch = option.is_flag and not option.secondary_opts  # one of a pair may have no default
    default = option.default is True if switch else option.default
    value = given.get(option.name or "", default)
    yield f"# {option.help}"
    if isinstance(value, bool | int | float | str):
        yield f"{config_key(option)} = {_toml(value)}"
    else:
        yield f"# {config_key(option)} ="


def _toml(value: bool | int | float | str) -> str:
    # TOML's strings, numbers and booleans are JSON's
    return json.dumps(value, ensure_ascii=False)

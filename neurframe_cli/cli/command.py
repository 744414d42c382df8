"""The click command class of all subcommands: global options, config files, console."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from neurframe_cli.cli.configuration import config_files, defaults_for
from neurframe_cli.cli.console import Console
from neurframe_cli.cli.settings import GLOBAL_OPTIONS, Settings

_GLOBAL_NAMES = [option.name or "" for option in GLOBAL_OPTIONS()]


class StageCommand(click.Command):
    """A subcommand; its callback gets `console` (Console) and `threads` (int) besides its own options."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.params += GLOBAL_OPTIONS()

    def make_context(
        self, info_name: str | None, args: list[str], parent: click.Context | None = None, **extra: Any
    ) -> click.Context:
        """Lay the config files under the command line before it is parsed."""
        before: Settings = parent.obj if parent is not None and parent.obj else Settings()
        explicit = _peek(args, "--config") or before.config
        files = config_files(explicit, _peek(args, "-w", "--workspace"))
        if files:
            from neurframe_cli.cli.main import COMMANDS

            extra["default_map"] = defaults_for(self, files, list(COMMANDS))
        return super().make_context(info_name, args, parent, **extra)

    def invoke(self, ctx: click.Context) -> Any:
        """Run the callback with a console and the number of threads."""
        own = Settings.from_options({name: ctx.params.pop(name, None) for name in _GLOBAL_NAMES})
        settings = (ctx.obj or Settings()).merged(own)
        ctx.params["threads"] = settings.apply_threads()
        with Console(settings.verbosity, settings.log_json) as console:
            ctx.params["console"] = console
            return super().invoke(ctx)


def _peek(args: list[str], *names: str) -> Path | None:
    """The value of an option in unparsed arguments: click has not seen them yet when config files are chosen."""
    for index, argument in enumerate(args):
        for name in names:
            if argument == name and index + 1 < len(args):
                return Path(args[index + 1])
            if name.startswith("--") and argument.startswith(name + "="):
                return Path(argument.partition("=")[2])
            if len(name) == 2 and argument.startswith(name) and len(argument) > 2:
                return Path(argument[2:])
    return None

"""The click command class of all subcommands: global options, config files, console."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from neurframe_cli.cli.configuration import CONFIG_NAME, config_files, configured_executables, defaults_for
from neurframe_cli.cli.console import Console
from neurframe_cli.cli.settings import GLOBAL_OPTIONS, Settings
from neurframe_cli.errors import UsageError

_GLOBAL_NAMES = [option.name or "" for option in GLOBAL_OPTIONS()]
# keys in the context's meta
_FILES, _SETTINGS = "neurframe_cli.config_files", "neurframe_cli.settings"
_UNTRUSTED = "neurframe_cli.untrusted_config_file"


class StageCommand(click.Command):
    """A subcommand; its callback gets `console` (Console) and `threads` (int) besides its own options."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.params += GLOBAL_OPTIONS()

    def make_context(
        self, info_name: str | None, args: list[str], parent: click.Context | None = None, **extra: Any
    ) -> click.Context:
        """Lay the config files under the command line."""
        if extra.get("resilient_parsing"):  # click completes a line for a shell
            return super().make_context(info_name, args, parent, **extra)
        # which files apply is known from the command line: it is read once only for that, without complaints
        first = super().make_context(info_name, list(args), parent, resilient_parsing=True, **extra).params
        before: Settings = parent.obj if parent is not None and parent.obj else Settings()
        explicit, workspace = first.get("config") or before.config, self._workspace(first)
        files = config_files(explicit, workspace)
        if files:
            from neurframe_cli.cli.main import COMMANDS

            extra["default_map"] = defaults_for(self, files, list(COMMANDS))
        context = super().make_context(info_name, args, parent, **extra)
        context.meta[_FILES] = files
        own = workspace / CONFIG_NAME if workspace is not None else None
        context.meta[_UNTRUSTED] = own if own != explicit else None
        return context

    def invoke(self, ctx: click.Context) -> Any:
        """Run the callback with a console and the number of threads."""
        own = Settings.from_options({name: ctx.params.pop(name, None) for name in _GLOBAL_NAMES})
        settings = (ctx.obj or Settings()).merged(own)
        ctx.meta[_SETTINGS] = settings
        ctx.params["threads"] = settings.apply_threads()
        with (
            Console(settings.verbosity, settings.log_json) as console,
            configured_executables(ctx.meta[_FILES], ctx.meta[_UNTRUSTED]),
        ):
            ctx.params["console"] = console
            return super().invoke(ctx)

    def _workspace(self, values: dict[str, Any]) -> Path | None:
        """The workspace that the command will work in, None where it has none, or will say itself what is wrong."""
        from neurframe_cli.pipeline.workspace import find_workspace, workspace_folder

        if "workspace" not in values:
            return None
        if values.get("model") is not None:
            return workspace_folder(values["model"], values["workspace"])
        try:
            return find_workspace(values["workspace"]).folder
        except UsageError:
            return None


def config_files_of(ctx: click.Context) -> list[Path]:
    """The config files that lie under the command line of `ctx`, strongest first."""
    files: list[Path] = ctx.meta[_FILES]
    return files


def settings_of(ctx: click.Context) -> Settings:
    """The global options as they were given, before or after the command's name."""
    settings: Settings = ctx.meta[_SETTINGS]
    return settings

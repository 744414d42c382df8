"""`neurframe completion SHELL`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click
from click.shell_completion import get_completion_class

from neurframe_cli.cli.command import StageCommand

if TYPE_CHECKING:
    from neurframe_cli.cli.console import Console


@click.command(name="completion", cls=StageCommand)
@click.argument("shell", type=click.Choice(["bash", "zsh", "fish"]))
def command(shell: str, threads: int, console: Console) -> None:
    """Print a script that completes commands, options and their values in SHELL.

    \b
    bash:  eval "$(neurframe completion bash)"    in ~/.bashrc
    zsh:   eval "$(neurframe completion zsh)"     in ~/.zshrc
    fish:  neurframe completion fish > ~/.config/fish/completions/neurframe.fish
    """
    from neurframe_cli.cli.main import COMPLETE_VARIABLE, PROGRAM, group

    script = get_completion_class(shell)
    assert script is not None, "click knows the three shells of the argument"
    console.result(script(group, {}, PROGRAM, COMPLETE_VARIABLE).source())

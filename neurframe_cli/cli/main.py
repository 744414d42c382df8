"""The command group: names and one-line helps here, everything else loaded when a command is called."""

from __future__ import annotations

import importlib
import os
import signal
import sys
from collections.abc import Sequence
from types import FrameType
from typing import Any

import click
from click.shell_completion import shell_complete

from neurframe_cli import __version__
from neurframe_cli.cli.settings import GLOBAL_OPTIONS, Settings
from neurframe_cli.cli.streams import lead_nowhere, tell, tolerate_every_character
from neurframe_cli.errors import Cancelled, NeurframeError, UsageError

INTERRUPTED = Cancelled.exit_code
PROGRAM = "neurframe"
COMPLETE_VARIABLE = "_NEURFRAME_COMPLETE"  # set by the completion script that a shell has loaded

# command -> what the help says; the module neurframe_cli.cli.NAME has a click command called `command`
COMMANDS = {
    "run": "Everything in one go: tets, field, frames, and the meshes asked for.",
    "batch": "`run` for many models, here or on a cluster, and one table.",
    "tetize": "Fill a surface with tetrahedra, or take a tet mesh as it is.",
    "train": "Learn a smooth, aligned frame field in the tets.",
    "discretize": "Query the field: frames on tets, crosses on triangles.",
    "singularities": "Points on the singular graph of the continuous field.",
    "streamlines": "Curves along the axes of the continuous field.",
    "quad": "Quad mesh from the crosses: integer-grid map, extraction, smoothing, check.",
    "hex": "Hex mesh from the frames: integer-grid map, extraction, smoothing, check.",
    "distill": "The field of the hexes' map, as a network to be asked anywhere.",
    "check": "Validity and quality of a quad or hex mesh against its input.",
    "report": "What happened in a workspace, as one HTML file.",
    "view": "A workspace or a mesh in the browser, with an interactive 3D view.",
    "doctor": "What is installed here, and does it work.",
    "config": "The options in force here, as a config file.",
    "completion": "Completion of commands and options for a shell.",
}


class LazyGroup(click.Group):
    """A group whose commands are imported only when they are called, so that --help answers at once."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in COMMANDS:
            return None
        command = importlib.import_module(f"neurframe_cli.cli.{cmd_name}").command
        assert isinstance(command, click.Command)
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


@click.group(
    cls=LazyGroup,
    params=[*GLOBAL_OPTIONS()],
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110},
    epilog="Exit codes: 0 done, 2 unusable input or wrong options, 3 a stage failed, 4 finished but the mesh is not "
    "valid, 124 timed out, 130 interrupted.",
)
@click.version_option(__version__, prog_name=PROGRAM)
@click.pass_context
def group(ctx: click.Context, /, **values: Any) -> None:
    """Turn any surface mesh into a clean quad mesh or hex mesh, guided by a learned continuous frame field."""
    ctx.obj = Settings.from_options(values)


def run_command_line(arguments: Sequence[str]) -> int:
    """Run `neurframe ARGUMENTS`; returns the exit code, after one line on stderr where it is not 0."""
    signal.signal(signal.SIGTERM, _interrupt)
    tolerate_every_character()
    instruction = os.environ.get(COMPLETE_VARIABLE)
    if instruction is not None:
        return shell_complete(group, {}, PROGRAM, COMPLETE_VARIABLE, instruction)
    try:
        with group.make_context(PROGRAM, list(arguments)) as context:
            returned = group.invoke(context)
        sys.stdout.flush()
        return returned if isinstance(returned, int) else 0
    except click.exceptions.Exit as ended:
        return ended.exit_code
    except click.exceptions.NoArgsIsHelpError as error:
        error.show()  # `neurframe` alone is a question, and the help its answer
        return UsageError.exit_code
    except click.ClickException as error:
        _say(f"error: {error.format_message()}", _help_for(error))
        return UsageError.exit_code
    except NeurframeError as error:
        _say(f"error: {error}", error.hint)
        return error.exit_code
    except (KeyboardInterrupt, click.Abort):
        _say("interrupted", "run the same command again to go on from here")
        return INTERRUPTED
    except BrokenPipeError:  # of --help, which click writes
        lead_nowhere(1)
        return 0
    except OSError as error:
        _say(f"error: {error.filename or 'the system'}: {error.strerror or error}")
        return NeurframeError.exit_code
    except Exception as error:
        return _internal_error(error)


def _interrupt(signum: int, frame: FrameType | None) -> None:
    raise KeyboardInterrupt


def _help_for(error: click.ClickException) -> str | None:
    """What explains the command that was called wrongly."""
    context = error.ctx if isinstance(error, click.UsageError) else None
    return f"`{context.command_path} --help` lists what it takes" if context is not None else None


def _say(line: str, hint: str | None = None) -> None:
    tell(_printable(f"neurframe: {line}"))
    if hint:
        tell(_printable(f"  try: {hint}"))


def _printable(text: str) -> str:
    """One line, whatever a file name in it holds: line ends and terminal controls are shown, not carried out."""
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in " ".join(text.split("\n")))


def _internal_error(error: Exception) -> int:
    """A bug of ours: one line, and the traceback only for those who ask for it with NEURFRAME_DEBUG=1."""
    if os.environ.get("NEURFRAME_DEBUG"):
        import traceback

        traceback.print_exception(error)
    where = error.__traceback__
    while where is not None and where.tb_next is not None:
        where = where.tb_next
    place = f" at {os.path.basename(where.tb_frame.f_code.co_filename)}:{where.tb_lineno}" if where else ""
    _say(
        f"internal error{place}: {type(error).__name__}: {error}",
        "this is a bug in neurframe; NEURFRAME_DEBUG=1 shows its traceback, please report it",
    )
    return NeurframeError.exit_code

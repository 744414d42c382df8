"""Every way a command can end badly, as one tree.

    NeurframeError            3  a stage failed
    ├── UsageError            2  wrong options, missing workspace
    ├── InputError            2  a file that cannot be used
    │   ├── UnreadableFile       missing, not permitted, truncated, not what its name says
    │   ├── UnsupportedFormat    no reader or writer for it
    │   ├── TooNewFile           written by a later version
    │   └── InvalidMesh          read, but no mesh that can be worked on
    ├── StageError            3  the stage ran and could not finish
    │   ├── ChildCrashed         a child process died of a signal
    │   ├── ChildOutOfMemory     a child process went over its memory limit
    │   ├── NotEnoughMemory      the stage would need more than there is, or went over its limit itself
    │   └── WorkspaceBusy        another process writes in the workspace
    ├── NotValid              4  finished, but the mesh does not pass its checks
    ├── TimedOut            124  a time limit was reached
    └── Cancelled           130  whoever had asked for it does not want it any more

Ctrl-C and SIGTERM are KeyboardInterrupt, which no handler of errors takes for one, and end with exit code 130.

The number is the exit code.  A message says what happened, in which file or element, what was found and what is
allowed; `hint` says what to try.
"""

from __future__ import annotations


class NeurframeError(Exception):
    """Base of all expected failures: `str(error)` is one line for a person, `hint` the next step or None."""

    exit_code = 3

    def __init__(self, what: str, *, hint: str | None = None) -> None:
        # a library's reason, or a file's name, may bring line ends along
        super().__init__(" ".join(what.splitlines()))
        self.hint = hint


class UsageError(NeurframeError):
    exit_code = 2


class InputError(NeurframeError):
    exit_code = 2


class UnreadableFile(InputError):
    pass


class UnsupportedFormat(InputError):
    pass


class TooNewFile(InputError):
    pass


class InvalidMesh(InputError):
    pass


class StageError(NeurframeError):
    exit_code = 3


class ChildCrashed(StageError):
    pass


class ChildOutOfMemory(StageError):
    pass


class NotEnoughMemory(StageError):
    pass


class WorkspaceBusy(StageError):
    pass


class NotValid(NeurframeError):
    exit_code = 4


class TimedOut(NeurframeError):
    exit_code = 124


class Cancelled(NeurframeError):
    exit_code = 130

"""Runs a program under limits and turns its end into a result or a classed error."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from neurframe_cli.errors import Cancelled, ChildCrashed, ChildOutOfMemory, InputError, StageError, TimedOut
from neurframe_cli.mesh.arrays import Progress
from neurframe_cli.process.child_output import ChildOutput
from neurframe_cli.process.child_peaks import note_child
from neurframe_cli.process.environment import child_environment
from neurframe_cli.process.memory import high_water_mib
from neurframe_cli.process.process_tree import die_with_parent, end_group, resident_mib

POLL_S = 0.1
GRACE_S = 2.0  # between TERM and KILL: enough to remove temporary files, short for a person who waits


@dataclass(frozen=True)
class ChildResult:
    """What a child left: exit code, output, last lines of stderr, wall and CPU seconds, peak memory in MiB."""

    returncode: int
    stdout: bytes
    last_lines: tuple[str, ...]
    seconds: float
    cpu_seconds: float
    peak_mib: float


def run_child(
    argv: Sequence[str | os.PathLike[str]],
    *,
    name: str,
    timeout_s: float | None = None,
    silence_s: float | None = None,
    memory_mib: float | None = None,
    env: Mapping[str, str] | None = None,
    threads: int | None = None,
    cwd: Path | None = None,
    on_progress: Progress | None = None,
    on_line: Callable[[str], None] | None = None,
    accept: Sequence[int] = (0,),
    should_stop: Callable[[], bool] | None = None,
) -> ChildResult:
    """Runs `argv` to its end in a process group of its own, with a clean environment plus `env`.

    `name` is what messages call the child.  Limits: `timeout_s` wall seconds, `silence_s` wall seconds without
    output, `memory_mib` of resident memory (child and descendants).  `progress FRACTION TEXT` lines on its stderr
    reach `on_progress`, the other lines `on_line`.  When we end, for whatever reason, so does the child;
    `should_stop` is asked ten times a second and ends it too, for callers in a thread, which no Ctrl-C reaches.

    Raises StageError when the program cannot be started or returns a code outside `accept` (InputError for
    code 2), TimedOut, ChildOutOfMemory, ChildCrashed when a signal ended it, Cancelled after should_stop.
    """
    child = _start(argv, name=name, env=child_environment(env, threads=threads), cwd=cwd)
    output = ChildOutput(child, name, on_progress, on_line)
    watch = _Watch(child, name, output, _Limits(timeout_s, silence_s, memory_mib), should_stop)
    try:
        watch.until_end()
    finally:
        watch.end()
        note_child(watch.peak_mib)
    result = watch.result()
    _raise_for_code(result, name, accept)
    return result


def _start(
    argv: Sequence[str | os.PathLike[str]], *, name: str, env: dict[str, str], cwd: Path | None
) -> subprocess.Popen[bytes]:
    arguments = [os.fspath(argument) for argument in argv]
    try:
        return subprocess.Popen(
            arguments,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env=env,
            cwd=cwd,
            start_new_session=True,
            preexec_fn=die_with_parent(),
        )
    except (OSError, ValueError) as error:
        raise StageError(
            f"{name} could not be started: {arguments[0]}: {error}",
            hint="`neurframe doctor` lists the programs that neurframe uses and where it looks for them",
        ) from error


@dataclass(frozen=True)
class _Limits:
    """None does not bind."""

    timeout_s: float | None
    silence_s: float | None
    memory_mib: float | None


class _Watch:
    """The loop around a running child: output, clock, memory."""

    def __init__(
        self,
        child: subprocess.Popen[bytes],
        name: str,
        output: ChildOutput,
        limits: _Limits,
        should_stop: Callable[[], bool] | None,
    ) -> None:
        self.child, self.name, self.output = child, name, output
        self.limits, self.should_stop = limits, should_stop
        self.started = self.last_heard = time.monotonic()
        self.peak_mib = 0.0
        self.cpu_seconds = 0.0
        self._inherited_mib = high_water_mib()
        self._next_memory_check = 0.0

    def until_end(self) -> None:
        """Returns when the child has ended and its pipes are empty; raises when it goes over a limit."""
        while not self.has_ended():
            if not self.output.is_open:
                time.sleep(POLL_S)
            elif self.output.read(POLL_S):
                self.last_heard = time.monotonic()
            self._check_limits()
        while self.output.is_open and self.output.read(POLL_S):
            self._check_limits()

    def has_ended(self) -> bool:
        """Collects the child when it is done, with what it used."""
        if self.child.returncode is not None:
            return True
        pid, status, usage = os.wait4(self.child.pid, os.WNOHANG)
        if pid == 0:
            return False
        self.child.returncode = os.waitstatus_to_exitcode(status)
        self.cpu_seconds = usage.ru_utime + usage.ru_stime
        kib = usage.ru_maxrss if os.uname().sysname == "Linux" else usage.ru_maxrss / 1024
        # until it begins its own program a child is a copy of us, and the system counts that copy too
        if kib / 1024 > self._inherited_mib:
            self.peak_mib = max(self.peak_mib, kib / 1024)
        return True

    def end(self) -> None:
        """Ends what is still running of the child's group and closes the pipes."""
        if not self.has_ended():
            end_group(self.child.pid, self.has_ended, grace_s=GRACE_S)
            while not self.has_ended():
                time.sleep(0.01)
        self.output.close()
        for pipe in (self.child.stdout, self.child.stderr):
            if pipe is not None:
                pipe.close()

    def result(self) -> ChildResult:
        return ChildResult(
            returncode=self.child.returncode,
            stdout=bytes(self.output.stdout),
            last_lines=tuple(self.output.last_lines),
            seconds=time.monotonic() - self.started,
            cpu_seconds=self.cpu_seconds,
            peak_mib=self.peak_mib,
        )

    def _check_limits(self) -> None:
        if self.should_stop is not None and self.should_stop():
            raise Cancelled(f"{self.name} was stopped before its end")
        now, limits = time.monotonic(), self.limits
        if limits.timeout_s is not None and now - self.started > limits.timeout_s:
            raise TimedOut(
                f"{self.name} was stopped after {limits.timeout_s:.4g} seconds",
                hint="give it more time with --timeout, or make the problem coarser",
            )
        if limits.silence_s is not None and now - self.last_heard > limits.silence_s:
            raise TimedOut(
                f"{self.name} was stopped: it had said nothing for {limits.silence_s:.4g} seconds",
                hint="give it more time with --timeout",
            )
        if now >= self._next_memory_check:
            self._next_memory_check = now + POLL_S
            self._check_memory(limits.memory_mib)

    def _check_memory(self, allowed_mib: float | None) -> None:
        self.peak_mib = max(self.peak_mib, high_water_mib(self.child.pid))
        if allowed_mib is None:
            return
        resident = resident_mib(self.child.pid)
        self.peak_mib = max(self.peak_mib, resident)
        if resident > allowed_mib:
            raise ChildOutOfMemory(
                f"{self.name} was stopped: it used {resident:.0f} MiB, allowed are {allowed_mib:.0f} MiB",
                hint="make the problem coarser, or run it on a machine with more memory",
            )


def _raise_for_code(result: ChildResult, name: str, accept: Sequence[int]) -> None:
    code = result.returncode
    if code in accept:
        return
    words = next((line.strip() for line in reversed(result.last_lines) if line.strip()), "")
    said = f": {words}" if words else ""
    if code == -signal.SIGKILL:
        raise ChildOutOfMemory(
            f"{name} was killed from outside (SIGKILL, peak {result.peak_mib:.0f} MiB){said}",
            hint="usually the system ran out of memory: make the problem coarser or free memory",
        )
    if code < 0:
        raise ChildCrashed(f"{name} crashed with {_signal_name(-code)}{said}", hint="try other settings")
    if code == 2:
        raise InputError(f"{name} cannot use its input{said}")
    raise StageError(f"{name} failed with exit code {code}{said}")


def _signal_name(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"

"""What a child writes: its stdout whole, of its stderr the progress lines and the last words."""

from __future__ import annotations

import os
import selectors
from collections import deque
from collections.abc import Callable
from subprocess import Popen

from neurframe_cli.errors import StageError
from neurframe_cli.mesh.arrays import Progress

STDOUT_LIMIT = 64 << 20  # bytes; a JSON object of statistics has a few kB, so more than this is a runaway
KEPT_STDERR_LINES = 200
CHUNK = 1 << 16


def parse_progress(line: str) -> tuple[float, str] | None:
    """(fraction in [0, 1], text) of a `progress FRACTION TEXT` line, None for any other line."""
    word, _, rest = line.partition(" ")
    number, _, text = rest.partition(" ")
    if word != "progress":
        return None
    try:
        fraction = float(number)
    except ValueError:
        return None
    return (fraction, text) if 0.0 <= fraction <= 1.0 else None


class ChildOutput:
    """Reads both pipes of a child without ever blocking on one of them."""

    def __init__(
        self,
        child: Popen[bytes],
        name: str,
        on_progress: Progress | None,
        on_line: Callable[[str], None] | None,
    ) -> None:
        self.name = name
        self.stdout = bytearray()
        self.last_lines: deque[str] = deque(maxlen=KEPT_STDERR_LINES)
        self._on_progress, self._on_line = on_progress, on_line
        self._partial_line = b""
        self._selector = selectors.DefaultSelector()
        for pipe, take in ((child.stdout, self._take_stdout), (child.stderr, self._take_stderr)):
            assert pipe is not None
            os.set_blocking(pipe.fileno(), False)
            self._selector.register(pipe, selectors.EVENT_READ, take)

    @property
    def is_open(self) -> bool:
        return bool(self._selector.get_map())

    def read(self, wait_s: float) -> bool:
        """Takes what is there, waiting at most `wait_s` seconds for it; True where something came."""
        events = self._selector.select(wait_s)
        for key, _ in events:
            take: Callable[[bytes], None] = key.data
            chunk = os.read(key.fd, CHUNK)
            if chunk:
                take(chunk)
            else:
                self._selector.unregister(key.fileobj)
        return bool(events)

    def close(self) -> None:
        """Lets go of the pipes; an unfinished last line of stderr counts as a line."""
        if self._partial_line:
            self._take_line(self._partial_line)
        self._selector.close()

    def last_words(self) -> str:
        """The last line on stderr that is no progress, for an error message; empty where there is none."""
        return next((line for line in reversed(self.last_lines) if line.strip()), "").strip()

    def _take_stdout(self, chunk: bytes) -> None:
        self.stdout += chunk
        if len(self.stdout) > STDOUT_LIMIT:
            raise StageError(f"{self.name} wrote more than {STDOUT_LIMIT >> 20} MiB to its standard output")

    def _take_stderr(self, chunk: bytes) -> None:
        *lines, self._partial_line = (self._partial_line + chunk).split(b"\n")
        # a child that never ends its line must not fill our memory
        self._partial_line = self._partial_line[-CHUNK:]
        for line in lines:
            self._take_line(line)

    def _take_line(self, raw: bytes) -> None:
        line = raw.decode("utf-8", "replace").rstrip("\r")
        progress = parse_progress(line)
        if progress is None:
            self.last_lines.append(line)
            if self._on_line is not None:
                self._on_line(line)
        elif self._on_progress is not None:
            self._on_progress(*progress)

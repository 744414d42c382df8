"""Children that end well, badly, or not at all."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import textwrap
import time

import psutil
import pytest

from neurframe_cli.errors import ChildCrashed, ChildOutOfMemory, InputError, StageError, TimedOut
from neurframe_cli.process import ChildResult, run_child
from neurframe_cli.process.child_output import parse_progress
from neurframe_cli.process.environment import child_environment


def python(code: str) -> list[str]:
    return [sys.executable, "-c", textwrap.dedent(code)]


def run(code: str, **options: object) -> ChildResult:
    return run_child(python(code), name="the child", **options)  # type: ignore[arg-type]  # any option


def test_stdout_code_and_use_are_reported() -> None:
    result = run(
        """
        import json, sys
        block = bytearray(64 << 20)
        sum(i * i for i in range(10**6))
        json.dump({"tets": 5}, sys.stdout)
        """
    )
    assert json.loads(result.stdout) == {"tets": 5}
    assert result.returncode == 0
    assert result.peak_mib > 64
    assert 0 < result.cpu_seconds < 30


def test_more_output_than_a_pipe_holds_arrives_whole() -> None:
    result = run("import sys; sys.stdout.write('x' * 3_000_000); sys.stderr.write('y\\n' * 300_000)")
    assert len(result.stdout) == 3_000_000
    assert set(result.last_lines) == {"y"}


def test_progress_lines_reach_the_callback_and_the_others_do_not() -> None:
    seen: list[tuple[float, str]] = []
    lines: list[str] = []
    code = "import sys; print('progress 0.25 solving the system', 'note', 'progress x y', sep='\\n', file=sys.stderr)"
    run(code, on_progress=lambda fraction, text: seen.append((fraction, text)), on_line=lines.append)
    assert seen == [(0.25, "solving the system")]
    assert lines == ["note", "progress x y"]


@pytest.mark.parametrize(
    "line", ["progress", "progress 2 x", "progress nan x", "progressive 0.5 x", " progress 0.5 x"]
)
def test_what_is_no_progress(line: str) -> None:
    assert parse_progress(line) is None


def test_a_crash_is_named_with_its_signal_and_last_words() -> None:
    with pytest.raises(ChildCrashed, match=r"the child crashed with SIGSEGV: at tet 7"):
        run("import os, sys; print('at tet 7', file=sys.stderr, flush=True); os.kill(os.getpid(), 11)")


def test_a_kill_from_outside_counts_as_out_of_memory() -> None:
    with pytest.raises(ChildOutOfMemory, match="SIGKILL"):
        run("import os; os.kill(os.getpid(), 9)")


def test_memory_limit() -> None:
    with pytest.raises(ChildOutOfMemory, match="allowed are 100 MiB") as caught:
        run("import time; block = bytearray(300 << 20); time.sleep(60)", memory_mib=100)
    assert caught.value.hint


def test_memory_of_grandchildren_counts() -> None:
    code = (
        "import subprocess, sys; subprocess.run([sys.executable, '-c', 'b = bytearray(300 << 20); input()'])"
    )
    with pytest.raises(ChildOutOfMemory):
        run(code.replace("input()", "import time; time.sleep(60)"), memory_mib=150)


def test_time_limit() -> None:
    started = time.monotonic()
    with pytest.raises(TimedOut, match=r"stopped after 0.3 seconds"):
        run("import time; time.sleep(60)", timeout_s=0.3)
    assert time.monotonic() - started < 30  # not the sixty of the child


def test_silence_limit() -> None:
    with pytest.raises(TimedOut, match=r"said nothing for 1\.5 seconds"):
        run("import time; print('begun', flush=True); time.sleep(60)", silence_s=1.5)


def test_a_child_that_talks_is_not_silent() -> None:
    code = "import sys, time; [(print('.', file=sys.stderr, flush=True), time.sleep(0.2)) for _ in range(10)]"
    assert run(code, silence_s=10).returncode == 0


def ends_within(pid: int, seconds: float) -> bool:
    """True once the process is gone, or is a zombie that nobody has collected."""
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        try:
            if psutil.Process(pid).status() == psutil.STATUS_ZOMBIE:
                return True
        except psutil.NoSuchProcess:
            return True
        time.sleep(0.05)
    return False


def test_a_child_that_ignores_term_is_killed_with_its_children(tmp_path: object) -> None:
    code = f"""
        import signal, subprocess, sys, time
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"])
        open({str(tmp_path)!r} + "/pid", "w").write(str(child.pid))
        time.sleep(60)
    """
    with pytest.raises(TimedOut):
        run(code, timeout_s=1.5)
    with open(f"{tmp_path}/pid") as file:
        grandchild = int(file.read())
    assert ends_within(grandchild, seconds=10)  # a process that got SIGKILL still has to be scheduled to die


def test_exit_codes() -> None:
    with pytest.raises(InputError, match=r"map\.hexex: no tets"):
        run("import sys; print('map.hexex: no tets', file=sys.stderr); sys.exit(2)")
    with pytest.raises(StageError, match="exit code 3"):
        run("import sys; sys.exit(3)")
    assert run("import sys; sys.exit(4)", accept=(0, 4)).returncode == 4


def test_a_program_that_is_not_there() -> None:
    with pytest.raises(StageError, match="gmesh could not be started"):
        run_child(["/no/such/gmesh"], name="gmesh")


def test_the_environment_is_clean(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LD_PRELOAD_NOT", "1")
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    environment = child_environment({"NEURFRAME_SEED": "3"}, threads=2)
    assert "LD_PRELOAD_NOT" not in environment
    assert environment["OMP_NUM_THREADS"] == "2"
    assert environment["NEURFRAME_SEED"] == "3"
    assert environment["PATH"] == os.environ["PATH"]


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="PR_SET_PDEATHSIG is a Linux call")
def test_the_child_dies_with_its_parent(tmp_path: object) -> None:
    """A parent that is killed outright cannot clean up; the kernel does."""
    pid_file = f"{tmp_path}/pid"
    child = f"import os, time; open({pid_file!r}, 'w').write(str(os.getpid())); time.sleep(60)"
    parent = f"""
        import sys
        from neurframe_cli.process import run_child
        run_child([sys.executable, "-c", {child!r}], name="child")
    """
    process = subprocess.Popen(python(parent))
    pid = _wait_for_pid(pid_file)
    process.send_signal(signal.SIGKILL)
    process.wait()
    deadline = time.monotonic() + 5
    while psutil.pid_exists(pid) and psutil.Process(pid).status() != psutil.STATUS_ZOMBIE:
        assert time.monotonic() < deadline, "the child outlived its parent"
        time.sleep(0.02)


def _wait_for_pid(path: str) -> int:
    deadline = time.monotonic() + 20
    while time.monotonic() < deadline:
        if os.path.exists(path):
            with open(path) as file:
                text = file.read()
            if text:
                return int(text)
        time.sleep(0.02)
    raise AssertionError("the child never started")

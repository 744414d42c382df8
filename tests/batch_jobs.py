"""Jobs of a fraction of a second, for the tests of what runs jobs: real processes, no meshes."""

from __future__ import annotations

import textwrap
from pathlib import Path

from neurframe_cli.batch.job import Job


def script_job(folder: Path, name: str, script: str = "", **limits: float | int | None) -> Job:
    """A job that runs `script` in Python, after noting its process and that of its worker in NAME.began."""
    began = f"import os; open({str(folder / name) + '.began'!r}, 'a').write(f'{{os.getpid()}} {{os.getppid()}}\\n')\n"
    return Job(
        model=folder / f"{name}.stl",
        workspace=folder / f"{name}.neurframe",
        folder=folder,
        arguments=("-c", began + textwrap.dedent(script)),
        timeout_s=limits.get("timeout_s", 60.0),
        memory_mib=limits.get("memory_mib"),
        attempts=int(limits.get("attempts") or 2),
    )


def began(folder: Path, name: str) -> list[tuple[int, int]]:
    """(process, its worker) of each attempt of a job so far."""
    path = folder / f"{name}.began"
    lines = path.read_text().splitlines() if path.exists() else []
    return [(int(line.split()[0]), int(line.split()[1])) for line in lines]

#!/usr/bin/env python3
"""Size of what neurframe and each of its extras install, from the records of the packages in this environment.

    install_size.py

MiB of the core with all that it needs, then of what each extra adds; the largest packages of each, and those packages
that are not installed here.  Sizes are those of the files in the wheels, without the .pyc files that Python adds.
"""

from __future__ import annotations

import importlib.metadata as metadata
import re
import tomllib
from collections.abc import Iterable
from pathlib import Path

from packaging.requirements import Requirement

PROJECT = Path(__file__).parent.parent / "pyproject.toml"
SHOWN = 4  # packages of each line


def closure(requirements: Iterable[str]) -> tuple[set[str], set[str]]:
    """Names of the packages that are needed for `requirements`: installed, and missing."""
    found: set[str] = set()
    missing: set[str] = set()
    left = [Requirement(text) for text in requirements]
    while left:
        wanted = left.pop()
        name = re.sub("[-_.]+", "-", wanted.name).lower()
        if name in found or not _applies(wanted, {""}):
            continue
        try:
            needs = metadata.requires(name) or []
        except metadata.PackageNotFoundError:
            missing.add(name)
            continue
        found.add(name)
        left += [need for need in map(Requirement, needs) if _applies(need, {"", *wanted.extras})]
    return found, missing


def _applies(requirement: Requirement, extras: set[str]) -> bool:
    marker = requirement.marker
    return marker is None or any(marker.evaluate({"extra": extra}) for extra in extras)


def size_mib(name: str) -> float:
    """Size of the files that the wheel says it has."""
    return sum(file.size or 0 for file in metadata.files(name) or []) / 2**20


def line(title: str, packages: set[str], missing: set[str]) -> str:
    sizes = sorted(((size_mib(name), name) for name in packages), reverse=True)
    largest = ", ".join(f"{name} {size:.0f}" for size, name in sizes[:SHOWN])
    absent = f"; not installed: {', '.join(sorted(missing))}" if missing else ""
    return f"| {title} | {len(sizes)} | {sum(size for size, _ in sizes):.0f} | {largest}{absent} |"


def main() -> None:
    project = tomllib.loads(PROJECT.read_text(encoding="utf-8"))["project"]
    core, missing = closure(project["dependencies"])
    print("| | packages | MiB | the largest |\n|---|---|---|---|")
    print(line("core", core, missing))
    for extra, requirements in project["optional-dependencies"].items():
        packages, missing = closure(requirements)
        print(line(f"`{extra}` adds", packages - core, missing))


if __name__ == "__main__":
    main()

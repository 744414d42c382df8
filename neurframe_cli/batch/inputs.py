"""Which models a batch is about: folders, globs, list files and files become one list without repetition."""

from __future__ import annotations

import glob
import hashlib
import os
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from neurframe_cli.batch.thingi10k import PREFIX, thingi10k_files
from neurframe_cli.errors import UsageError
from neurframe_cli.mesh.file_format import EXTENSIONS
from neurframe_cli.mesh.open_file import check_file

LIST_SUFFIXES = (".txt", ".lst", ".list")


@dataclass(frozen=True)
class Shard:
    """The number-th of `count` parts of a batch, counted from 1."""

    number: int = 1
    count: int = 1

    def __str__(self) -> str:
        return f"{self.number}-of-{self.count}"


def parse_shard(text: str) -> Shard:
    """Shard of "k/n"; raises UsageError."""
    found = re.fullmatch(r"(\d+)/(\d+)", text)
    if found is None or not 1 <= int(found[1]) <= int(found[2]):
        raise UsageError(f"--shard is {text!r}, expected k/n with 1 <= k <= n, as 2/8")
    return Shard(int(found[1]), int(found[2]))


def find_models(inputs: Sequence[str], thingi10k: Path | None = None) -> list[Path]:
    """Absolute paths of the models, sorted, each once; `thingi10k` is a local copy of that data set.

    A folder stands for every mesh file below it; a list file has a path, a glob or thingi10k:ID in each line, relative
    to the list.  Raises UsageError where an input or a line stands for nothing.  Files of a list that do not exist are
    kept: each of them gets its outcome.
    """
    entries = [entry for text in inputs for entry in _entries(text, Path())]
    ids = [int(entry.removeprefix(PREFIX)) for entry in entries if entry.startswith(PREFIX)]
    files = [Path(entry) for entry in entries if not entry.startswith(PREFIX)]
    if ids:
        files += thingi10k_files(ids, thingi10k)
    return sorted({path.resolve() for path in files})


def take_shard(models: Sequence[Path], shard: Shard) -> list[Path]:
    """Every count-th model: sizes grow with names in many collections, so that neighbours are dealt out."""
    return list(models[shard.number - 1 :: shard.count])


def workspace_names(models: Sequence[Path]) -> dict[Path, str]:
    """A folder name for each model: its stem, with folder and digest of the path where several share that stem."""
    stems = Counter(model.stem for model in models)
    return {model: model.stem if stems[model.stem] == 1 else _long_name(model) for model in models}


def _long_name(model: Path) -> str:
    digest = hashlib.sha256(os.fsencode(model)).hexdigest()[:8]
    return f"{model.parent.name}-{model.stem}-{digest}"


def _entries(text: str, base: Path) -> Iterator[str]:
    """What one input stands for; `base` is the folder that relative paths count from."""
    if text.startswith(PREFIX):
        if not text.removeprefix(PREFIX).isdigit():
            raise UsageError(f"{text}: a model of Thingi10K is named by its number, as {PREFIX}65004")
        yield text
        return
    path = base / text
    if path.is_dir():
        yield from _meshes_in(path)
    elif path.suffix.lower() in LIST_SUFFIXES:
        yield from _lines_of(path)
    elif not path.exists() and glob.has_magic(text):
        yield from _matches(str(path))
    else:
        yield str(path)


def _meshes_in(folder: Path) -> list[str]:
    found = [str(path) for path in folder.rglob("*") if path.suffix.lower() in EXTENSIONS and path.is_file()]
    if not found:
        raise UsageError(f"there is no mesh file below {folder}", hint=f"known: {', '.join(EXTENSIONS)}")
    return found


def _matches(pattern: str) -> list[str]:
    found = glob.glob(pattern, recursive=True)
    if not found:
        raise UsageError(f"no file matches {pattern}")
    return found


def _lines_of(path: Path) -> Iterator[str]:
    check_file(path)
    for line in path.read_text(encoding="utf-8").splitlines():
        text = line.partition("#")[0].strip()
        if text:
            yield from _entries(text, path.parent)

"""Models of Thingi10K (Zhou and Jacobson 2016) by number, from a local copy or through the package `thingi10k`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from neurframe_cli.errors import StageError, UsageError
from neurframe_cli.mesh.file_format import EXTENSIONS

PREFIX = "thingi10k:"


def thingi10k_files(ids: Sequence[int], folder: Path | None) -> list[Path]:
    """The files of these models; from `folder` if one is given, else downloaded and kept by the package.

    A model that the folder lacks stands as ID.stl there, for its outcome to say so.  Raises UsageError where there is
    neither folder nor package, StageError where the package cannot deliver.
    """
    return _from_folder(ids, folder) if folder is not None else _from_package(ids)


def _from_folder(ids: Sequence[int], folder: Path) -> list[Path]:
    if not folder.is_dir():
        raise UsageError(f"there is no folder {folder}", hint="name a copy of Thingi10K with --thingi10k")
    # copies name their files 65004.stl, or thingi10k_65004.stl
    found: dict[int, Path] = {}
    for path in sorted(folder.rglob("*")):
        number = path.stem.rpartition("_")[2]
        if path.suffix.lower() in EXTENSIONS and number.isascii() and number.isdigit():
            found.setdefault(int(number), path)
    return [found.get(number, folder / f"{number}.stl") for number in ids]


def _from_package(ids: Sequence[int]) -> list[Path]:
    try:
        import thingi10k
    except ImportError as error:
        raise UsageError(
            "models of Thingi10K need a local copy or the extra `thingi10k`",
            hint="--thingi10k FOLDER, or: pip install 'neurframe[thingi10k]' (downloads several GB)",
        ) from error
    try:
        thingi10k.init(variant="raw")
        entries = {
            int(entry["file_id"]): Path(entry["file_path"]) for entry in thingi10k.dataset(file_id=list(ids))
        }
    except (OSError, RuntimeError, ValueError, KeyError) as error:
        raise StageError(
            f"Thingi10K could not be fetched: {error}", hint="name a local copy with --thingi10k"
        ) from error
    missing = sorted(set(ids) - entries.keys())
    if missing:
        raise UsageError(f"Thingi10K has no model {', '.join(map(str, missing))}")
    return [entries[number] for number in ids]

"""manifest.json: what every stage did, from what, with which options."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from neurframe_cli.errors import TooNewFile, UnreadableFile
from neurframe_cli.mesh.open_file import read_bytes
from neurframe_cli.pipeline.atomic import write_json

FORMAT = "neurframe-workspace"
VERSION = 1
MANIFEST_NAME = "manifest.json"
MAX_BYTES = 256 << 20


@dataclass
class StageRecord:
    """One stage's entry.

    status: running, done, invalid (written, but it fails its checks), failed, interrupted; key: digest of
    everything that determines the outputs; inputs, outputs: file name -> sha256; peak_mib, expected_mib: the most
    memory that it held, and the estimate before it began (0: none); report: the stage's own numbers.
    """

    status: str
    key: str
    options: dict[str, Any] = field(default_factory=dict)
    inputs: dict[str, str] = field(default_factory=dict)
    outputs: dict[str, str] = field(default_factory=dict)
    versions: dict[str, str] = field(default_factory=dict)
    started: str = ""
    seconds: float = 0.0
    cpu_seconds: float = 0.0
    peak_mib: float = 0.0
    expected_mib: float = 0.0
    warnings: list[str] = field(default_factory=list)
    report: dict[str, Any] = field(default_factory=dict)
    error: str | None = None


@dataclass
class Manifest:
    """The stages of a workspace by name, in the order in which they were first run."""

    stages: dict[str, StageRecord] = field(default_factory=dict)


def read_manifest(folder: Path) -> Manifest:
    """The manifest in `folder`, empty where there is none; raises UnreadableFile or TooNewFile."""
    path = folder / MANIFEST_NAME
    if not path.exists():
        return Manifest()
    try:
        document = json.loads(read_bytes(path, MAX_BYTES))
        if not isinstance(document, dict) or document.get("format") != FORMAT:
            raise ValueError(f"it is no {FORMAT} document")
        if int(document["version"]) > VERSION:
            raise TooNewFile(
                f"{path} has version {document['version']}, this neurframe reads up to {VERSION}",
                hint="update neurframe, or use another workspace with -w",
            )
        return Manifest({name: _record(name, value) for name, value in document["stages"].items()})
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise UnreadableFile(
            f"{path} cannot be read as a workspace manifest: {error}",
            hint="delete that file to start the workspace afresh, or use another workspace with -w",
        ) from error


def write_manifest(folder: Path, manifest: Manifest) -> None:
    """Write the manifest atomically."""
    stages = {name: asdict(record) for name, record in manifest.stages.items()}
    write_json(folder / MANIFEST_NAME, {"format": FORMAT, "version": VERSION, "stages": stages})


_TYPES: dict[str, type | tuple[type, ...]] = {
    "status": str,
    "key": str,
    "options": dict,
    "inputs": dict,
    "outputs": dict,
    "versions": dict,
    "started": str,
    "seconds": (int, float),
    "cpu_seconds": (int, float),
    "peak_mib": (int, float),
    "expected_mib": (int, float),
    "warnings": list,
    "report": dict,
    "error": (str, type(None)),
}


def _record(name: str, value: dict[str, Any]) -> StageRecord:
    for key, entry in value.items():
        if key not in _TYPES or not isinstance(entry, _TYPES[key]):
            raise ValueError(f"stage {name!r}: unexpected entry {key!r}")
    return StageRecord(**value)

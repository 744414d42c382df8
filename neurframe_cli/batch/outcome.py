"""What came of one model of a batch, as a value and as a line of results.jsonl."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field, fields
from typing import Any

from neurframe_cli.errors import TooNewFile, UnreadableFile

VERSION = 1
# what can become of a model; all but the last three are the exit codes of `neurframe run` in words
OUTCOMES = (
    "valid",
    "invalid",
    "unusable",
    "failed",
    "timed out",
    "interrupted",
    "out of memory",
    "crashed",
    "lost",
)


@dataclass(frozen=True)
class Outcome:
    """The one outcome of a model.

    model, workspace: absolute paths; outcome: one of OUTCOMES; exit_code: of `neurframe run`, negative for a signal,
    None where it did not end by itself; message: what went wrong, empty if nothing; attempts: how often it was
    started; seconds, cpu_seconds, peak_mib: sums and maximum over the stages of the workspace, the interrupted attempts
    not counted; options: as they were given to `neurframe run`; tets: None where there are none; meshes: the numbers of
    the check by kind, `valid` among them; stages: seconds by name; host: where it ran.
    """

    model: str
    workspace: str
    outcome: str
    exit_code: int | None
    message: str
    attempts: int
    host: str
    options: list[str] = field(default_factory=list)
    seconds: float = 0.0
    cpu_seconds: float = 0.0
    peak_mib: float = 0.0
    tets: int | None = None
    meshes: dict[str, dict[str, Any]] = field(default_factory=dict)
    stages: dict[str, float] = field(default_factory=dict)


def to_line(outcome: Outcome) -> str:
    """One line of JSON, with the line end."""
    return json.dumps({"version": VERSION, **asdict(outcome)}, allow_nan=False, sort_keys=True) + "\n"


def from_line(line: str, where: str) -> Outcome:
    """The outcome of a line; raises TooNewFile or UnreadableFile naming `where` it stands."""
    try:
        document = json.loads(line)
        if int(document.pop("version")) > VERSION:
            raise TooNewFile(f"{where} was written by a later neurframe", hint="update neurframe")
        if document.keys() != {entry.name for entry in fields(Outcome)}:
            raise ValueError(f"its entries are {', '.join(sorted(document))}")
        return Outcome(**document)
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise UnreadableFile(f"{where} is no outcome of a batch: {error}") from error


def row(outcome: Outcome) -> dict[str, Any]:
    """The outcome as a row of a table: what a person compares, most telling first."""
    cells: dict[str, Any] = {"model": outcome.model, "outcome": outcome.outcome, "tets": outcome.tets}
    for kind, elements in (("quad", "quads"), ("hex", "hexes")):
        mesh = outcome.meshes.get(kind, {})
        cells[elements] = mesh.get("cells")
        for name in ("valid", "min_scaled_jacobian", "mean_scaled_jacobian", "hausdorff", "feature_recall"):
            cells[f"{kind}_{name}"] = mesh.get(name)
    for name in (
        "seconds",
        "cpu_seconds",
        "peak_mib",
        "attempts",
        "exit_code",
        "host",
        "workspace",
        "message",
    ):
        cells[name] = getattr(outcome, name)
    return cells

"""train on files: tets.mesh, features.json -> field.safetensors, train.jsonl."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from neurframe_cli.errors import UnreadableFile
from neurframe_cli.field.field_file import field_to_bytes
from neurframe_cli.mesh.features import read_features
from neurframe_cli.mesh.open_file import read_bytes
from neurframe_cli.mesh.read_tets import read_medit
from neurframe_cli.pipeline.atomic import atomic_path
from neurframe_cli.pipeline.forecast import Amount
from neurframe_cli.pipeline.runner import StageContext, Step
from neurframe_cli.pipeline.tetize_step import FEATURES, TETS
from neurframe_cli.pipeline.workspace import Workspace
from neurframe_cli.stages.train import TrainOptions, train

FIELD, LOG, CHECKPOINT = "field.safetensors", "train.jsonl", "train.checkpoint"
# speed and bookkeeping; threads change the last bits of a sum, not the field
_UNKEYED = ("threads", "log_every", "checkpoint_every_s")


def train_step(
    workspace: Workspace, options: TrainOptions, *, fresh: bool = False, memory_mib: float | None = None
) -> Step:
    """The stage bound to its files; fresh forgets the checkpoint of an unfinished run; memory_mib: see Step."""
    tets = workspace.require(TETS, "tetize INPUT")
    features = workspace.require(FEATURES, "tetize INPUT")
    values = options.__dict__

    def work(context: StageContext) -> dict[str, Any]:
        journal = _Journal(context.workspace / CHECKPOINT, context.workspace / LOG, context)
        if fresh:
            journal.forget()
        journal.drop_damaged()
        mesh, _ = read_medit(tets)
        context.expect("train", Amount(len(mesh.T)))
        edges = read_features(features, len(mesh.V))
        result = train(mesh, edges, options, context.progress, journal.log, journal)
        with atomic_path(context.workspace / FIELD) as path:
            path.write_bytes(field_to_bytes(result.field))
        journal.finish()
        if result.report["stopped_by_time_budget"]:
            context.warn(
                f"the time budget ended training early, at a loss of {result.report['losses']['total']:.3g}"
            )
        return result.report

    return Step(
        name="train",
        version=1,
        inputs={TETS: tets, FEATURES: features},
        outputs=(FIELD, LOG),
        options={name: value for name, value in values.items() if name not in _UNKEYED},
        unkeyed_options={**{name: values[name] for name in _UNKEYED}, "memory_mib": memory_mib},
        work=work,
        packages=("torch", "safetensors", "numpy", "scipy"),
        memory_mib=memory_mib,
    )


class _Journal:
    """The checkpoint and the log of a run, written together, so that a resumed run goes on with both.

    The checkpoint file knows by its own key which run it belongs to; one of another run is ignored by train().
    """

    def __init__(self, checkpoint: Path, log: Path, context: StageContext) -> None:
        self._checkpoint, self._log, self._context = checkpoint, log, context
        self._records: list[str] = []
        self._begun = False

    def read(self) -> bytes | None:
        """The last checkpoint, None before the first; its log lines come back with it."""
        if not self._checkpoint.is_file():
            return None
        if self._log.is_file():
            self._records = self._log.read_text(encoding="utf-8", errors="replace").splitlines()
        return read_bytes(self._checkpoint)

    def write(self, content: bytes) -> None:
        with atomic_path(self._checkpoint) as path:
            path.write_bytes(content)
        self._write_log()

    def log(self, record: dict[str, Any]) -> None:
        if not self._begun and record.get("event") != "resumed":
            self._records.clear()  # the checkpoint that was read belongs to another run
        self._begun = True
        self._records.append(json.dumps(record, allow_nan=False, sort_keys=True))

    def forget(self) -> None:
        """Start from nothing."""
        self._checkpoint.unlink(missing_ok=True)

    def drop_damaged(self) -> None:
        """A checkpoint that cannot be read costs its steps, not the run."""
        from neurframe_cli.field.checkpoint import checkpoint_from_bytes

        if not self._checkpoint.is_file():
            return
        try:
            checkpoint_from_bytes(read_bytes(self._checkpoint))
        except UnreadableFile as error:
            self._context.warn(f"{self._checkpoint} is not used: {error}")
            self.forget()

    def finish(self) -> None:
        """The log is an artifact, the checkpoint of a finished run is nothing any more."""
        self._write_log()
        self._checkpoint.unlink(missing_ok=True)

    def _write_log(self) -> None:
        with atomic_path(self._log) as path:
            path.write_text("".join(line + "\n" for line in self._records))

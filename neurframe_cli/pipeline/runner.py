"""Running one stage in a workspace: skip what is unchanged, record what was done, leave nothing half-written."""

from __future__ import annotations

import datetime
import hashlib
import json
import logging
import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from neurframe_cli import __version__
from neurframe_cli.errors import NeurframeError, NotEnoughMemory, NotValid, UsageError
from neurframe_cli.mesh.arrays import Progress
from neurframe_cli.pipeline.atomic import remove_leftovers, sha256_of, write_error
from neurframe_cli.pipeline.forecast import Amount
from neurframe_cli.pipeline.lock import exclusive
from neurframe_cli.pipeline.manifest import Manifest, StageRecord, read_manifest, write_manifest
from neurframe_cli.pipeline.memory import expected_mib, refuse_too_large, within
from neurframe_cli.pipeline.usage import Usage, measured
from neurframe_cli.pipeline.workspace import Workspace

log = logging.getLogger("neurframe")

UNFINISHED = ""  # in place of the hash of an output whose stage has not finished


@dataclass
class StageContext:
    """What a step's work gets: where to read and write, how to tell progress, how much memory it may take.

    A work that has written a mesh that does not pass its checks says why in `invalid` and returns its report.
    """

    workspace: Workspace
    progress: Progress
    warnings: list[str] = field(default_factory=list)
    invalid: str | None = None
    memory_mib: float | None = None
    expected_mib: float = 0.0

    def warn(self, message: str) -> None:
        """Note something the user should know; it goes to the log and into the manifest."""
        log.warning(message)
        self.warnings.append(message)

    def expect(self, stage: str, amount: Amount) -> None:
        """Note how much memory the work will take; raises NotEnoughMemory where there is not so much."""
        self.expected_mib = round(expected_mib(stage, amount), 1)
        refuse_too_large(stage, self.expected_mib, self.memory_mib)


@dataclass(frozen=True)
class Step:
    """A stage bound to files.

    version is raised whenever the same inputs and options would give other outputs; inputs: label -> path;
    options: values that determine the outputs; unkeyed_options: values that do not (limits, threads), recorded only;
    memory_mib: what the stage, and each of its programs, may take, None for what is free;
    work writes the outputs (atomically) and returns the report.
    """

    name: str
    version: int
    inputs: Mapping[str, Path]
    outputs: tuple[str, ...]
    options: Mapping[str, Any]
    work: Callable[[StageContext], dict[str, Any]]
    unkeyed_options: Mapping[str, Any] = field(default_factory=dict)
    packages: tuple[str, ...] = ()
    memory_mib: float | None = None


@dataclass(frozen=True)
class StageOutcome:
    """What a stage left behind: its record, and whether it was skipped because nothing had changed."""

    record: StageRecord
    skipped: bool


def run_stage(workspace: Workspace, step: Step, progress: Progress, *, force: bool = False) -> StageOutcome:
    """Run `step` unless its outputs are there, unharmed, made from the same inputs and options.

    Raises what the work raises, after the manifest has recorded it, and NotValid where the work (now or when it was
    last done) found its own result invalid.
    """
    _refuse_overwriting(workspace, step)
    with exclusive(workspace.folder):
        remove_leftovers(workspace.folder)
        manifest = read_manifest(workspace.folder)
        inputs = {label: sha256_of(path) for label, path in step.inputs.items()}
        foreign = _foreign_inputs(workspace, step, manifest, inputs)
        key = _key(step, inputs)
        previous = manifest.stages.get(step.name)
        log.debug("%s: options %s, inputs %s", step.name, dict(step.options), inputs)
        if not force and previous is not None and is_current(workspace, previous, key):
            return _judged(StageOutcome(previous, skipped=True))
        record = StageRecord("running", key, {**step.options, **step.unkeyed_options}, inputs)
        record.outputs = dict.fromkeys(step.outputs, UNFINISHED)
        record.versions = _versions(step.packages)
        record.started = datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")
        manifest.stages[step.name] = record
        write_manifest(workspace.folder, manifest)
        bounded = within(progress, step.name, step.memory_mib)
        context = StageContext(workspace, bounded, record.warnings, memory_mib=step.memory_mib)
        for warning in foreign:
            context.warn(warning)
        with measured() as usage:
            _carry_out(workspace, step, context, manifest, usage)
        return _judged(StageOutcome(record, skipped=False))


def _judged(outcome: StageOutcome) -> StageOutcome:
    if outcome.record.status == "invalid":
        raise NotValid(outcome.record.error or "not valid")
    return outcome


def is_unchanged(workspace: Workspace, step: Step) -> bool:
    """Whether run_stage would have nothing to do."""
    record = read_manifest(workspace.folder).stages.get(step.name)
    if record is None:
        return False
    return is_current(
        workspace, record, _key(step, {label: sha256_of(path) for label, path in step.inputs.items()})
    )


def is_current(workspace: Workspace, record: StageRecord, key: str) -> bool:
    """Whether a stage's outputs are all there with the hashes recorded, made under the same key."""
    if record.status not in ("done", "invalid") or record.key != key:
        log.debug("done again: the last run was %s, its key %.8s, now %.8s", record.status, record.key, key)
        return False
    for name, digest in record.outputs.items():
        path = workspace / name
        if not path.is_file():
            return False
        if sha256_of(path) != digest:
            log.warning("%s has changed since it was written: it is made again", path)
            return False
    return True


def _carry_out(
    workspace: Workspace, step: Step, context: StageContext, manifest: Manifest, usage: Usage
) -> None:
    record = manifest.stages[step.name]
    before = _made_at(workspace, step)
    started = time.perf_counter()
    try:
        record.report = _finite(step.work(context))
        record.status, record.error = ("invalid" if context.invalid else "done"), context.invalid
    except KeyboardInterrupt:
        record.status, record.error = "interrupted", "interrupted"
        raise
    except MemoryError as error:
        record.status, record.error = "failed", "out of memory"
        raise NotEnoughMemory(
            f"{step.name}: the system gave no more memory", hint="make the problem coarser, or free memory"
        ) from error
    except OSError as error:
        record.status, record.error = "failed", str(error)
        raise write_error(workspace.folder, error) from error
    except NeurframeError as error:
        record.status, record.error = "failed", str(error)
        raise
    except Exception as error:
        record.status, record.error = "failed", f"internal error: {error!r}"
        raise
    finally:
        record.seconds = round(time.perf_counter() - started, 3)
        record.cpu_seconds, record.peak_mib = usage.cpu_seconds(), usage.peak_mib()
        record.expected_mib = context.expected_mib
        if record.status in ("done", "invalid"):
            # a picture of an earlier run that this one did not draw again is none of its outputs
            made = [name for name, when in _made_at(workspace, step).items() if when != before.get(name)]
            record.outputs = {name: sha256_of(workspace / name) for name in made}
        write_manifest(workspace.folder, manifest)


def _refuse_overwriting(workspace: Workspace, step: Step) -> None:
    """Raises UsageError where the stage would write over one of its own inputs."""
    inputs = {path.resolve() for path in step.inputs.values()}
    for name in step.outputs:
        if (workspace / name).resolve() in inputs:
            raise UsageError(
                f"{step.name} would write over its input {workspace / name}", hint="choose another -w"
            )


def _made_at(workspace: Workspace, step: Step) -> dict[str, int]:
    """When each output that is there was last written, in nanoseconds."""
    paths = {name: workspace / name for name in step.outputs}
    return {name: path.stat().st_mtime_ns for name, path in paths.items() if path.is_file()}


def _finite(value: Any) -> Any:
    """The value with null in place of infinities and NaN, which JSON has no words for."""
    if isinstance(value, dict):
        return {key: _finite(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _foreign_inputs(
    workspace: Workspace, step: Step, manifest: Manifest, inputs: Mapping[str, str]
) -> list[str]:
    """A warning for each input that is not what its stage has written: put there by the user, or damaged.

    Raises UsageError where an input comes from an unfinished stage, or from other files than those there now.
    """
    warnings = []
    for label in inputs:
        for name, record in manifest.stages.items():
            if name == step.name or label not in record.outputs:
                continue
            if record.status not in ("done", "invalid"):
                raise UsageError(
                    f"{label} comes from a {name} that did not finish", hint=f"run `neurframe {name}` again"
                )
            if record.outputs[label] != inputs[label]:
                warnings.append(f"{label} is not the file that {name} has written; it is used all the same")
                continue
            for source, digest in record.inputs.items():
                if (workspace / source).is_file() and sha256_of(workspace / source) != digest:
                    raise UsageError(
                        f"{label} was made from another {source} than the one there now",
                        hint=f"run `neurframe {name}` again",
                    )
    return warnings


def _key(step: Step, inputs: Mapping[str, str]) -> str:
    document = {"stage": step.name, "version": step.version, "inputs": inputs, "options": step.options}
    return hashlib.sha256(json.dumps(document, sort_keys=True).encode()).hexdigest()


def _versions(packages: tuple[str, ...]) -> dict[str, str]:
    from importlib.metadata import PackageNotFoundError, version

    found = {"neurframe": __version__}
    for package in packages:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "not installed"
    return found

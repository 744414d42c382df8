"""The state of a training run as bytes of a safetensors file: resumed from it, a run ends with the same weights."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
import torch

from neurframe_cli.errors import TooNewFile, UnreadableFile
from neurframe_cli.field.network import FieldNetwork
from neurframe_cli.field.optimizers import Optimizer, State
from neurframe_cli.mesh.arrays import Floats

FORMAT, VERSION = "neurframe-checkpoint", 1
NUMBERS = ("floor", "losses", "step", "seconds", "cpu_seconds")  # the state beside the tensors


class CheckpointStore(Protocol):
    """Where one checkpoint is kept; write replaces it in one piece, so that a kill leaves the old or the new one."""

    def read(self) -> bytes | None:
        """The last checkpoint, None before the first."""

    def write(self, content: bytes) -> None: ...


@dataclass
class TrainingState:
    """Everything a run depends on: the network, the optimizer of the current round, what is done so far.

    target (m,9) and floor: the discrete solution, once known; losses: total loss at the end of each finished round;
    round and step: the next step; seconds and cpu_seconds: used so far, over all resumed parts.
    """

    network: FieldNetwork
    optimizer: Optimizer | None = None
    target: Floats | None = None
    floor: float | None = None
    losses: list[float] = field(default_factory=list)
    step: int = 0
    seconds: float = 0.0
    cpu_seconds: float = 0.0


def state_to_bytes(state: TrainingState, key: str) -> bytes:
    """The checkpoint; key names the inputs and options that it belongs to."""
    from safetensors.torch import save

    tensors = {f"network.{n}": t.cpu().contiguous() for n, t in state.network.state_dict().items()}
    if state.optimizer is not None:
        tensors |= {f"optimizer.{n}": t.cpu().contiguous() for n, t in state.optimizer.state().items()}
    if state.target is not None:
        tensors["target"] = torch.from_numpy(state.target)
    numbers = {name: getattr(state, name) for name in NUMBERS}
    document = {"format": FORMAT, "version": VERSION, "key": key, "state": numbers}
    document["sha256"] = _digest(tensors, key, numbers)
    return bytes(save(tensors, {"neurframe": json.dumps(document, sort_keys=True)}))


@dataclass(frozen=True)
class Checkpoint:
    """A checkpoint that was read: tensors by name, its key and the numbers of the state."""

    tensors: State
    key: str
    numbers: dict[str, Any]

    def restore_into(self, state: TrainingState) -> None:
        """Puts all but the optimizer into the state of a fresh run; UnreadableFile where it is of another network."""
        try:
            state.network.load_state_dict(self._part("network."))
        except RuntimeError as error:
            raise UnreadableFile(f"the training checkpoint does not fit the network: {error}") from error
        target = self.tensors.get("target")
        state.target = None if target is None else np.asarray(target.numpy(), np.float64)
        for name, value in self.numbers.items():
            setattr(state, name, value)

    def optimizer_state(self) -> State:
        """What Optimizer.restore takes; empty between rounds."""
        return self._part("optimizer.")

    def _part(self, prefix: str) -> State:
        return {name.removeprefix(prefix): t for name, t in self.tensors.items() if name.startswith(prefix)}


def checkpoint_from_bytes(content: bytes) -> Checkpoint:
    """Raises UnreadableFile where it is no whole checkpoint, TooNewFile where a later version wrote it."""
    tensors, document = read_safetensors(content, "the training checkpoint", FORMAT, VERSION)
    try:
        key, stored = str(document["key"]), document["state"]
        numbers = {name: stored[name] for name in NUMBERS}
        digest = document["sha256"]
    except (KeyError, TypeError, ValueError) as error:
        raise UnreadableFile(
            f"the training checkpoint lacks {error}", hint="use --force to start anew"
        ) from error
    if digest != _digest(tensors, key, numbers):
        raise UnreadableFile("the training checkpoint is damaged", hint="use --force to start anew")
    return Checkpoint(tensors, key, numbers)


def _digest(tensors: State, key: str, numbers: dict[str, Any]) -> str:
    """SHA-256 of everything in a checkpoint: weights that a bad disk has changed would train on without a word."""
    shapes = {name: [str(t.dtype), list(t.shape)] for name, t in tensors.items()}
    digest = hashlib.sha256(json.dumps([key, numbers, shapes], sort_keys=True).encode())
    for name in sorted(tensors):
        digest.update(tensors[name].contiguous().reshape(-1).view(torch.uint8).numpy().tobytes())
    return digest.hexdigest()


def read_safetensors(
    content: bytes, name: str, format_name: str, version: int
) -> tuple[State, dict[str, Any]]:
    """(tensors, JSON document) of a safetensors file of ours; raises UnreadableFile or TooNewFile."""
    from safetensors import SafetensorError
    from safetensors.torch import load

    try:
        tensors = load(content)
        length = int.from_bytes(content[:8], "little")
        document = json.loads(json.loads(content[8 : 8 + length])["__metadata__"]["neurframe"])
        found, its_version = str(document["format"]), int(document["version"])
    except (SafetensorError, KeyError, TypeError, ValueError) as error:
        raise UnreadableFile(f"{name} is damaged or not written by neurframe: {error}") from error
    if found != format_name:
        raise UnreadableFile(f"{name} holds {found}, {format_name} is expected")
    if its_version > version:
        raise TooNewFile(
            f"{name} has format version {its_version}, this program reads up to {version}",
            hint="upgrade neurframe",
        )
    return tensors, document

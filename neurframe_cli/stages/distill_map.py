"""Stage distill: the network takes over the field of the integer-grid map that the hexes are of.

neurframe-cubecover diffuses the frames that the network gave it, heals them in places, or takes those of a polycube:
the field that carries the map is not the network's any more.  Trained further on the frames of the map, the network is
a continuous field again that agrees with the hexes and their matchings, and can be asked at every point.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from neurframe_cli.errors import InvalidMesh, StageError, UsageError
from neurframe_cli.mesh.arrays import Floats, Ints, Progress, part, silent
from neurframe_cli.mesh.read_hex_map import HexMap
from neurframe_cli.mesh.tet_adjacency import TetAdjacency, tet_adjacency

if TYPE_CHECKING:
    from neurframe_cli.field.field_file import Field, NeuralField
    from neurframe_cli.field.network import FieldNetwork
    from neurframe_cli.field.recipe import Round


@dataclass(frozen=True)
class DistillOptions:
    """iterations: steps, None for as many as `train` takes for so many tets; seed: of the batches; device: auto | cpu |
    cuda; threads: of PyTorch, on the CPU."""

    iterations: int | None = None
    seed: int = 0
    device: str = "auto"
    threads: int | None = None


@dataclass(frozen=True)
class DistilledField:
    """The field, and how near it and the one before are to the map: angles between frames at the centroids in degrees,
    and the share of the inner faces across which the matching of the nearest frames is that of the map."""

    field: NeuralField
    report: dict[str, Any]


def distill_map(
    field: Field, hex_map: HexMap, options: DistillOptions | None = None, progress: Progress = silent
) -> DistilledField:
    """The network of `field`, trained further on the frames of a map; `field` itself stays as it is.

    Raises UsageError for a field without a network, InvalidMesh for a map whose tets share a face by threes, StageError
    where the training diverges.
    """
    import torch

    from neurframe_cli.field.device import choose_device
    from neurframe_cli.field.field_file import NeuralField
    from neurframe_cli.field.map_frames import map_frames, map_matchings
    from neurframe_cli.field.network import FieldNetwork
    from neurframe_cli.field.recipe import distillation_round

    options = options or DistillOptions()
    if not isinstance(field, NeuralField):
        raise UsageError(
            "the field has no network to train further", hint="train it without --method discrete"
        )
    if options.threads:
        torch.set_num_threads(options.threads)
    device = choose_device(options.device, "auto")
    try:
        adjacency = tet_adjacency(hex_map.T)
    except ValueError as error:
        raise InvalidMesh(f"the tets of the map are no mesh: {error}") from error
    frames, matchings = map_frames(hex_map), map_matchings(hex_map, adjacency)
    points = hex_map.V[hex_map.T].mean(axis=1)
    begun = time.perf_counter()
    before = _agreement(field, points, frames, matchings, adjacency)
    network = FieldNetwork(field.network.architecture, torch.Generator().manual_seed(options.seed))
    network.load_state_dict(field.network.state_dict())
    network.hidden_dtype = device.hidden_dtype
    lesson = distillation_round(len(points), options.iterations, None, None)
    normalized = field.normalization.apply(points)
    _train(network.to(device.name), normalized, frames, lesson, options.seed, part(progress, 0.05, 0.9))
    distilled = NeuralField(network.cpu(), field.normalization)
    after = _agreement(distilled, points, frames, matchings, adjacency)
    report = {
        "tets": len(points),
        "steps": lesson.steps,
        "before": before,
        "after": after,
        "seconds": round(time.perf_counter() - begun, 3),
        "device": device.label,
    }
    return DistilledField(distilled, report)


def _train(
    network: FieldNetwork, points: Floats, frames: Floats, lesson: Round, seed: int, progress: Progress
) -> None:
    """All steps of a round of distillation, on the network."""
    from neurframe_cli.field.frames import frame_to_band4
    from neurframe_cli.field.objectives import Distillation
    from neurframe_cli.field.optimizers import MuonAndAdam, Schedule

    device = next(network.parameters()).device.type
    objective = Distillation(points, frame_to_band4(frames), lesson.batch, [seed], device)
    optimizer = MuonAndAdam(network)
    schedule = Schedule(lesson.peak, lesson.steps, lesson.warm_up, lesson.cosine)
    for step in range(lesson.steps):
        value = objective.backpropagate(network, step)
        if not np.isfinite(value):
            raise StageError(f"the training diverged at step {step}: the loss is {value}")
        optimizer.step(schedule.rate(step))
        progress((step + 1) / lesson.steps, f"step {step + 1}: {value:.5f}")


def _agreement(
    field: NeuralField, points: Floats, frames: Floats, matchings: Ints, adjacency: TetAdjacency
) -> dict[str, float]:
    """How near the field is to the frames (m,3,3) at points (m,3), whose matchings (e,) are those of the map."""
    from neurframe_cli.field.frames import nearest_frames
    from neurframe_cli.field.matching import best_matchings
    from neurframe_cli.field.octahedral_group import GROUP, nearest_element
    from neurframe_cli.field.rotations import angle_between

    found = nearest_frames(field.query(points)).frames
    # of the 24 frames that are one cross, that which is nearest to the map's
    found = found @ GROUP[nearest_element(np.swapaxes(found, 1, 2) @ frames)]
    degrees = np.degrees(angle_between(found, frames))
    same = best_matchings(found, adjacency).index == matchings
    return {
        "mean_deg": float(degrees.mean()),
        "p95_deg": float(np.percentile(degrees, 95)),
        "max_deg": float(degrees.max()),
        "same_matchings": float(same.mean()) if len(same) else 1.0,
    }

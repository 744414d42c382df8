"""The training loop: rounds of steps, logged, checkpointed, resumable bit for bit on the CPU."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch

from neurframe_cli.errors import StageError
from neurframe_cli.field.checkpoint import Checkpoint, CheckpointStore, TrainingState, state_to_bytes
from neurframe_cli.field.device import Device
from neurframe_cli.field.energy_terms import EnergyTerms
from neurframe_cli.field.network import FieldNetwork, evaluate
from neurframe_cli.field.objectives import Distillation, FullLoss, Objective, SampledLoss
from neurframe_cli.field.optimizers import Adam, MuonAndAdam, Optimizer, Schedule
from neurframe_cli.field.recipe import Recipe, Round
from neurframe_cli.mesh.arrays import Floats, Progress

Log = Callable[[dict[str, Any]], None]


class Clock:
    """Wall and CPU seconds of a run, going on from those of its earlier parts."""

    def __init__(self, seconds: float, cpu_seconds: float) -> None:
        self._start = time.perf_counter() - seconds
        self._cpu_start = time.process_time() - cpu_seconds

    def seconds(self) -> float:
        return time.perf_counter() - self._start

    def cpu_seconds(self) -> float:
        return time.process_time() - self._cpu_start


@dataclass(frozen=True)
class Saver:
    """Writes the state to the store, at most every `every_s` seconds unless asked; without a store it does nothing."""

    store: CheckpointStore | None
    key: str
    every_s: float
    clock: Clock

    def save(self, state: TrainingState) -> None:
        state.seconds, state.cpu_seconds = self.clock.seconds(), self.clock.cpu_seconds()
        if self.store is not None:
            self.store.write(state_to_bytes(state, self.key))

    def is_due(self, state: TrainingState) -> bool:
        return self.store is not None and self.clock.seconds() - state.seconds >= self.every_s


@dataclass(frozen=True)
class TrainingRun:
    """What stays the same during a run."""

    terms: EnergyTerms
    device: Device
    seed: int
    recipe: Recipe
    saver: Saver
    log: Log
    log_every: int
    time_budget_s: float | None
    progress: Progress


def run_rounds(run: TrainingRun, state: TrainingState, resumed: Checkpoint | None) -> bool:
    """Trains state.network until the recipe has enough or the time budget is spent; returns whether it was cut short.

    Raises StageError where the loss is not finite.
    """
    while (training_round := run.recipe.next_round(state.losses)) is not None:
        state.optimizer = _optimizer(training_round, state.network)
        if resumed is not None and (saved := resumed.optimizer_state()):
            state.optimizer.restore(saved)
        resumed = None
        finished = _run_round(run, state, training_round)
        state.losses.append(run.terms.losses(coefficients(state.network, run.terms.points)).total)
        state.optimizer, state.step = None, 0
        run.log({"event": "round", "round": len(state.losses), "loss": state.losses[-1]})
        run.saver.save(state)
        if not finished:
            return True
    return False


def coefficients(network: FieldNetwork, points: Floats) -> Floats:
    """The network at normalised points (n,3): unit rows (n,9) float64."""
    device = next(network.parameters()).device
    q = evaluate(network, torch.as_tensor(points, dtype=torch.float32, device=device)).double().cpu().numpy()
    return np.asarray(q / np.linalg.norm(q, axis=1, keepdims=True))


def _run_round(run: TrainingRun, state: TrainingState, training_round: Round) -> bool:
    objective = _objective(run, state, training_round)
    schedule = Schedule(
        training_round.peak, training_round.steps, training_round.warm_up, training_round.cosine
    )
    assert state.optimizer is not None, "set by run_rounds"
    while state.step < training_round.steps:
        value = objective.backpropagate(state.network, state.step)
        if not np.isfinite(value):
            raise StageError(
                f"the training diverged at step {state.step}: the loss is {value}",
                hint="train again with a smaller --learning-rate",
            )
        rate = schedule.rate(state.step)
        state.optimizer.step(rate)
        state.step += 1
        _report_step(run, state, training_round, value, rate)
        if run.saver.is_due(state):
            run.saver.save(state)
        if run.time_budget_s is not None and run.saver.clock.seconds() >= run.time_budget_s:
            return False
    return True


def _report_step(
    run: TrainingRun, state: TrainingState, training_round: Round, value: float, rate: float
) -> None:
    kind, number, steps = training_round.objective, len(state.losses) + 1, training_round.steps
    if state.step % run.log_every == 0 or state.step in (1, steps):
        seconds = round(run.saver.clock.seconds(), 3)
        record = {"event": "step", "round": number, "objective": kind, "step": state.step, "steps": steps}
        run.log(record | {"value": value, "rate": rate, "seconds": seconds})
    begin, end = run.recipe.share(number - 1)
    run.progress(begin + (end - begin) * state.step / steps, f"round {number}: {kind} {value:.5f}")


def _optimizer(training_round: Round, network: FieldNetwork) -> Optimizer:
    return Adam(list(network.parameters())) if training_round.optimizer == "adam" else MuonAndAdam(network)


def _objective(run: TrainingRun, state: TrainingState, training_round: Round) -> Objective:
    device, number = run.device.name, len(state.losses)
    seed = [run.seed, number]
    if training_round.objective == "distill":
        assert state.target is not None, "the recipe that distils has solved the discrete problem"
        return Distillation(run.terms.points, state.target, training_round.batch, seed, device)
    if training_round.fraction < 1.0:
        return SampledLoss(run.terms, training_round.fraction, seed, device)
    return FullLoss(run.terms, device)

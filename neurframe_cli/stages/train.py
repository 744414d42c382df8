"""Stage train: from a tet mesh to a continuous frame field (paper, section 4)."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from neurframe_cli.errors import InvalidMesh
from neurframe_cli.field.energy_terms import EnergyTerms, energy_terms, normalization_of
from neurframe_cli.mesh.arrays import Features, Floats, Progress, TetMesh, silent
from neurframe_cli.mesh.tet_adjacency import TetAdjacency, tet_adjacency
from neurframe_cli.stages.train_options import TrainOptions

if TYPE_CHECKING:
    from neurframe_cli.field.checkpoint import Checkpoint, CheckpointStore, TrainingState
    from neurframe_cli.field.device import Device
    from neurframe_cli.field.field_file import Field
    from neurframe_cli.field.recipe import Recipe
    from neurframe_cli.field.training import Clock

__all__ = ["TrainOptions", "TrainResult", "train"]

Log = Callable[[dict[str, Any]], None]


@dataclass(frozen=True)
class TrainResult:
    """The field, to query and to write (field_file.field_to_bytes), and the report for the manifest."""

    field: Field
    report: dict[str, Any]


def train(
    tets: TetMesh,
    features: Features,
    options: TrainOptions | None = None,
    progress: Progress = silent,
    log: Log | None = None,
    checkpoint: CheckpointStore | None = None,
) -> TrainResult:
    """Trains a field on the centroids of `tets`, aligned with its boundary and its `features`.

    log gets one JSON-ready dict per logged step.  With a checkpoint store a run that was killed goes on where it
    was and ends, on the same CPU with the same number of threads, with the same bytes.  Raises StageError where the
    training diverges, UsageError for a device that is not there, UnreadableFile for a damaged checkpoint, InvalidMesh
    for tets that are none or that share a face by threes.
    """
    import torch

    from neurframe_cli.field.device import choose_device

    options = options or TrainOptions()
    if options.threads:
        torch.set_num_threads(options.threads)
    # the paper trains in float32; a precision that was asked for is taken
    by_preset = "fp32" if options.is_paper and options.precision == "auto" else options.precision
    device = choose_device(options.device, by_preset)
    adjacency = _adjacency(tets)
    terms = energy_terms(tets, features, options.weights(), adjacency)
    session = _Session(
        tets, features, adjacency, terms, options, device, progress, log or _no_log, checkpoint
    )
    return session.discrete() if options.method == "discrete" else session.neural()


@dataclass(frozen=True)
class _Session:
    """The inputs of one call of train()."""

    tets: TetMesh
    features: Features
    adjacency: TetAdjacency
    terms: EnergyTerms
    options: TrainOptions
    device: Device
    progress: Progress
    log: Log
    checkpoint: CheckpointStore | None

    def discrete(self) -> TrainResult:
        """The field of the discrete solver, interpolated between the centroids."""
        from neurframe_cli.field.field_file import SampledField
        from neurframe_cli.field.training import Clock

        clock = Clock(0.0, 0.0)
        q, floor = self._solve(self.progress)
        field = SampledField(self.terms.points, q, normalization_of(self.tets.V))
        return TrainResult(field, self._report(q, floor, clock, rounds=[], stopped=False))

    def neural(self) -> TrainResult:
        """The trained network."""
        from neurframe_cli.field.field_file import NeuralField
        from neurframe_cli.field.training import Clock, Saver, TrainingRun, coefficients, run_rounds

        state, resumed = self._initial_state()
        clock = Clock(state.seconds, state.cpu_seconds)
        saver = Saver(self.checkpoint, self._key(), self.options.checkpoint_every_s, clock)
        if not self.options.is_paper and state.target is None:
            state.target, state.floor = self._solve(lambda x, text: self.progress(0.2 * x, text))
            saver.save(state)
        run = TrainingRun(
            self.terms,
            self.device,
            self.options.seed,
            self._recipe(state),
            saver,
            self.log,
            self.options.log_every,
            self.options.time_budget_s,
            self.progress,
        )
        stopped = run_rounds(run, state, resumed)
        field = NeuralField(state.network.cpu(), normalization_of(self.tets.V))
        q = coefficients(state.network, self.terms.points)
        return TrainResult(field, self._report(q, state.floor, clock, rounds=state.losses, stopped=stopped))

    def _solve(self, progress: Progress) -> tuple[Floats, float]:
        """The discrete field, of true frames where that is wanted, and the least energy without that wish."""
        from neurframe_cli.field.discrete_solver import solve_discrete
        from neurframe_cli.field.frame_diffusion import diffuse_and_project

        solution = solve_discrete(self.terms, device=self.device.name, progress=progress)
        self.log({"event": "discrete", "loss": solution.value, "iterations": solution.iterations})
        if not self.options.project:
            return solution.q, solution.value
        q = diffuse_and_project(self.terms, solution.q, device=self.device.name, progress=progress)
        self.log({"event": "projected", "loss": self.terms.losses(q).total})
        return q, solution.value

    def _initial_state(self) -> tuple[TrainingState, Checkpoint | None]:
        import torch

        from neurframe_cli.field.checkpoint import TrainingState, checkpoint_from_bytes
        from neurframe_cli.field.network import Architecture, FieldNetwork

        network = FieldNetwork(Architecture(), torch.Generator().manual_seed(self.options.seed))
        network.hidden_dtype = self.device.hidden_dtype
        state = TrainingState(network.to(self.device.name))
        content = self.checkpoint.read() if self.checkpoint is not None else None
        found = checkpoint_from_bytes(content) if content is not None else None
        if found is None or found.key != self._key():
            return state, None
        found.restore_into(state)
        self.log({"event": "resumed", "round": len(state.losses) + 1, "step": state.step})
        return state, found

    def _recipe(self, state: TrainingState) -> Recipe:
        from neurframe_cli.field import recipe

        options = self.options
        if options.is_paper:
            return recipe.PaperRecipe(
                options.iterations or 10_000, options.learning_rate or 5e-5, options.batch_fraction or 1.0
            )
        assert state.target is not None, "neural() has solved the discrete problem"
        first = recipe.distillation_round(
            len(self.terms.points), options.iterations, options.batch_fraction, options.learning_rate
        )
        # the true loss would pull projected frames back to where they came from
        refinements = 0 if options.project else options.refinements
        floor = self.terms.losses(state.target).total
        return recipe.FastRecipe(floor, self._constant(), first, refinements=refinements)

    def _constant(self) -> float:
        """The loss of q = 0, the scale on which a loss is small."""
        return self.terms.losses(np.zeros((len(self.terms.points), 9))).total

    def _key(self) -> str:
        """Digest of what determines the weights: inputs, options, device, precision and version of PyTorch."""
        import torch

        digest = hashlib.sha256()
        for array in (self.tets.V, self.tets.T, self.features.edges):
            digest.update(np.ascontiguousarray(array).tobytes())
        context = [self.device.label, str(self.device.hidden_dtype), torch.__version__]
        digest.update(json.dumps([self.options.keyed(), context], sort_keys=True).encode())
        return digest.hexdigest()

    def _report(
        self, q: Floats, floor: float | None, clock: Clock, *, rounds: list[float], stopped: bool
    ) -> dict[str, Any]:
        import torch

        from neurframe_cli.field.field_report import field_report

        seconds, cpu_seconds = clock.seconds(), clock.cpu_seconds()
        report = field_report(self.terms, q, self.tets, self.features, self.adjacency)
        has_floor = floor is not None and floor > 1e-6 * self._constant()
        gap = report["losses"]["total"] / floor - 1.0 if floor and has_floor else None
        return report | {
            "tets": len(self.terms.points),
            "discrete_floor": floor,
            "above_floor": gap,
            "round_losses": rounds,
            "stopped_by_time_budget": stopped,
            "seconds": round(seconds, 3),
            "cpu_seconds": round(cpu_seconds, 3),
            "device": self.device.label,
            "precision": str(self.device.hidden_dtype).removeprefix("torch."),
            "threads": torch.get_num_threads(),
            "torch": torch.__version__,
        }


def _adjacency(tets: TetMesh) -> TetAdjacency:
    if not len(tets.T):
        raise InvalidMesh("the tet mesh has no tets")
    try:
        return tet_adjacency(tets.T)
    except ValueError as error:
        raise InvalidMesh(f"no field can be trained on these tets: {error}") from error


def _no_log(record: dict[str, Any]) -> None:
    """Drops a log record."""

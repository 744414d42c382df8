"""fTetWild with one setting after the other until the result passes its checks."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from neurframe_cli.errors import ChildOutOfMemory, InvalidMesh, NeurframeError, StageError, TimedOut
from neurframe_cli.mesh.arrays import Floats, Progress, Surface, TetMesh, as_surface
from neurframe_cli.mesh.check_tets import checked_tets
from neurframe_cli.mesh.clean_surface import CleaningReport
from neurframe_cli.mesh.decimate_surface import decimated_surface
from neurframe_cli.mesh.manifold_boundary import ManifoldReport, make_boundary_manifold
from neurframe_cli.mesh.measure import box_diagonal
from neurframe_cli.process.memory import usable_mib
from neurframe_cli.stages.run_tetwild import TetwildRun, TetwildSettings, run_tetwild
from neurframe_cli.stages.tetize_check import Fit, fit, refuse_misfit

if TYPE_CHECKING:
    from neurframe_cli.stages.tetize import TetizeOptions

# of the time that is left, an attempt that has another one behind it gets this part
TIME_SHARE = 0.6
COARSEST = 0.25  # coarser than this a tet mesh says nothing about its shape
COARSEST_FACTOR = 4  # nor does one that is so much coarser than what was asked for
# fTetWild's simplification of the input can run for ever, silently; after a twentieth of the time without a word, and
# after so many seconds at least, the surface is decimated before it is given to fTetWild again
SILENT_SHARE, LEAST_SILENCE_S = 0.05, 20.0
DECIMATION_TOLERANCE = 0.5  # of epsilon


class EmptyResultError(StageError):
    """fTetWild ended well and returned nothing."""


@dataclass(frozen=True)
class Attempt:
    """One run of fTetWild: its settings, `done` or what went wrong, wall and CPU seconds, peak MiB."""

    settings: TetwildSettings
    outcome: str
    seconds: float
    cpu_seconds: float = 0.0
    peak_mib: float = 0.0


@dataclass(frozen=True)
class Success:
    """Tets in input coordinates that passed their checks, and how they came about."""

    tets: TetMesh
    fit: Fit
    seeded: bool
    warnings: list[str]
    attempts: tuple[Attempt, ...]


@dataclass(frozen=True)
class Task:
    """What every attempt works on."""

    surface: Surface
    report: CleaningReport
    options: TetizeOptions
    progress: Progress
    scratch_dir: Path


def first_success(task: Task) -> Success:
    """The tets of the first settings that lead to valid ones; raises the error of the last when none do."""
    options = task.options
    deadline = time.monotonic() + options.timeout_s
    first = settings = TetwildSettings(options.edge_length, options.epsilon, num_threads=options.threads)
    manifold = task.report.nonmanifold_edges == 0
    attempts: list[Attempt] = []
    while True:
        started = time.monotonic()
        share = TIME_SHARE if settings_after(first, settings, TimedOut(""), manifold=manifold) else 1.0
        try:
            run, accepted = _attempt(task, settings, (deadline - started) * share)
        except (StageError, TimedOut) as error:
            attempts.append(Attempt(settings, f"{type(error).__name__}: {error}", time.monotonic() - started))
            following = settings_after(first, settings, error, manifold=manifold)
            if following is None or time.monotonic() >= deadline:
                raise _final(error, attempts) from error
            settings = following
            task.progress(0.0, f"again with other settings ({error})")
            continue
        attempts.append(Attempt(settings, "done", time.monotonic() - started, run.cpu_seconds, run.peak_mib))
        warnings = _other_settings(attempts) + accepted.warnings
        return Success(accepted.tets, accepted.fit, run.seeded, warnings, tuple(attempts))


def _attempt(task: Task, settings: TetwildSettings, timeout_s: float) -> tuple[TetwildRun, Accepted]:
    """One run and its checks; raises StageError or TimedOut."""
    boxed = _to_unit_box(task.surface)
    given = boxed.surface
    if settings.decimate:
        diagonal = box_diagonal(given.V)
        given = decimated_surface(given, DECIMATION_TOLERANCE * settings.epsilon * diagonal)
    run = run_tetwild(
        given,
        settings,
        seed=task.options.seed,
        timeout_s=timeout_s,
        silence_s=_longest_silence(task, settings),
        memory_mib=task.options.memory_mib or usable_mib(),
        progress=task.progress,
        scratch_dir=task.scratch_dir,
    )
    task.progress(0.96, "checking the tets")
    return run, _accepted(run, boxed, task, settings.epsilon)


def _longest_silence(task: Task, settings: TetwildSettings) -> float | None:
    """Seconds; None where there is nothing to do against a simplification that never ends."""
    if settings.decimate or not settings.simplify or task.report.nonmanifold_edges:
        return None
    return max(SILENT_SHARE * task.options.timeout_s, LEAST_SILENCE_S)


def settings_after(
    first: TetwildSettings, last: TetwildSettings, error: Exception, *, manifold: bool
) -> TetwildSettings | None:
    """What to try after `last` failed with `error`, None where nothing is left.

    Too slow or too large: fewer triangles where the surface is `manifold`, which decimation asks for, then twice the
    edge length, up to four times the first.  Anything else: without fTetWild's
    simplification of the input, then (unless it returned nothing) with twice the envelope, then coarser as well.
    """
    doubled = 2 * last.edge_length_fac
    coarser = replace(last, edge_length_fac=doubled, simplify=True)
    coarse_enough = doubled > min(COARSEST, COARSEST_FACTOR * first.edge_length_fac)
    if isinstance(error, TimedOut | ChildOutOfMemory):
        if manifold and not last.decimate:
            return replace(last, decimate=True)
        return None if coarse_enough else coarser
    if last == first:
        return replace(last, simplify=False)
    if isinstance(error, EmptyResultError):
        return None
    if last.epsilon == first.epsilon:
        return replace(last, epsilon=2 * first.epsilon, simplify=True)
    return None if coarse_enough else coarser


@dataclass(frozen=True)
class UnitBox:
    """A surface moved to the origin and scaled by a power of two to a diagonal between 1/2 and 1.

    fTetWild loses itself in coordinates of 1e-20 or 1e20; a power of two keeps every bit of the mantissa.
    """

    surface: Surface
    origin: Floats
    scale: float


def _to_unit_box(surface: Surface) -> UnitBox:
    origin = surface.V.min(axis=0)
    diagonal = box_diagonal(surface.V)
    scale = 2.0 ** np.ceil(np.log2(diagonal))
    return UnitBox(as_surface((surface.V - origin) / scale, surface.F), origin, float(scale))


@dataclass(frozen=True)
class Accepted:
    """Tets in input coordinates that passed the checks."""

    tets: TetMesh
    fit: Fit
    warnings: list[str]


def _accepted(run: TetwildRun, boxed: UnitBox, task: Task, epsilon: float) -> Accepted:
    """Moves fTetWild's tets back and checks them; raises StageError for what cannot be used."""
    if len(run.T) == 0:
        raise EmptyResultError("fTetWild returned no tets")
    try:
        tets, _ = checked_tets(run.V * boxed.scale + boxed.origin, run.T, "fTetWild's result")
        tets, manifold = make_boundary_manifold(tets)
        checked_tets(tets.V, tets.T, "fTetWild's result, taken apart where it touches itself")
    except InvalidMesh as error:
        raise StageError(str(error)) from error
    if manifold.pinched_vertices:
        raise StageError(f"the boundary of the tets touches itself at {manifold.pinched_vertices} vertices")
    found = fit(tets, task.surface, task.report)
    warnings = refuse_misfit(found, epsilon, task.report)
    return Accepted(tets, found, warnings + manifold_warnings(manifold))


def manifold_warnings(report: ManifoldReport) -> list[str]:
    """What make_boundary_manifold had to do."""
    if report.unchanged:
        return []
    return [
        f"taken apart where the solid only touches itself: {report.halved_edges} edges, "
        f"{report.copied_vertices + report.cut_vertices} vertices"
    ]


def _other_settings(attempts: list[Attempt]) -> list[str]:
    """A warning where it was not the first attempt that succeeded."""
    first, last = attempts[0].settings, attempts[-1].settings
    if first == last:
        return []
    return [
        f"needed {len(attempts)} attempts, the first ended with {attempts[0].outcome}; reached with edge length "
        f"{last.edge_length_fac:g}, epsilon {last.epsilon:g}, simplification {'on' if last.simplify else 'off'}, "
        f"{'decimated' if last.decimate else 'all'} triangles"
    ]


def _final(error: StageError | TimedOut, attempts: list[Attempt]) -> NeurframeError:
    """The error that the user sees after the last attempt."""
    if all(attempt.outcome.startswith(EmptyResultError.__name__) for attempt in attempts):
        return InvalidMesh(
            f"no tets: the surface encloses nothing thicker than epsilon ({len(attempts)} attempts)",
            hint="close the surface, or lower --epsilon",
        )
    kind = StageError if isinstance(error, EmptyResultError) else type(error)
    tried = f" ({len(attempts)} attempts)" if len(attempts) > 1 else ""
    return kind(f"{error}{tried}", hint=error.hint or "try a larger --edge-length or --epsilon")

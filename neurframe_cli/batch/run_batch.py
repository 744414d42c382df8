"""The batch itself: every job to a pool, every outcome to the caller, once."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait

from neurframe_cli.batch.job import Job, lost
from neurframe_cli.batch.outcome import Outcome
from neurframe_cli.batch.pool import NoScheduler, PoolOptions, Submit, open_pool
from neurframe_cli.errors import StageError

log = logging.getLogger("neurframe")

TICK_S = 0.5
RECONNECT_S = 1.0


class _PoolLost(Exception):
    """The scheduler is gone, and with it what was asked of it."""


def run_batch(
    jobs: Sequence[Job],
    options: PoolOptions,
    record: Callable[[Outcome], None],
    tick: Callable[[], None] = lambda: None,
    *,
    patience_s: float = 120.0,
) -> None:
    """Runs all jobs; `record` gets each outcome as it comes, `tick` is called twice a second.

    When the scheduler is lost, the jobs without an outcome are given to the one that answers at the same address
    within `patience_s` seconds; their workspaces let them go on where they were.  Raises StageError where none does.
    """
    pending = list(jobs)
    deadline: float | None = None
    while pending:
        try:
            with open_pool(options) as submit:
                deadline = None
                _drain(submit, pending, record, tick)
        except _PoolLost:
            log.warning(
                "the scheduler is lost: waiting for it, %d models are without an outcome", len(pending)
            )
            deadline = time.monotonic() + patience_s
        except NoScheduler as error:
            if deadline is None:
                raise
            if time.monotonic() > deadline:
                raise StageError(
                    f"the scheduler has not come back, {len(pending)} models are without an outcome",
                    hint="the same command with --resume goes on with them",
                ) from error
            time.sleep(RECONNECT_S)


def _drain(
    submit: Submit, pending: list[Job], record: Callable[[Outcome], None], tick: Callable[[], None]
) -> None:
    """Until no job is pending; takes those with an outcome off the list.  Raises _PoolLost."""
    running = {submit(job): job for job in pending}
    while running:
        done, _ = wait(running, timeout=TICK_S, return_when=FIRST_COMPLETED)
        for future in done:
            job = running.pop(future)
            record(_outcome(future, job))
            pending.remove(job)
        tick()


def _outcome(future: Future[Outcome], job: Job) -> Outcome:
    if future.cancelled():
        raise _PoolLost
    error = future.exception()
    # a job on which worker after worker has died, or a bug of ours: one outcome all the same
    return lost(job, error) if error is not None else future.result()

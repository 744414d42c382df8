"""Where jobs run: threads here, Dask workers anywhere, or nodes of a Slurm cluster.  All give the same futures."""

from __future__ import annotations

import contextlib
import logging
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from neurframe_cli.batch.job import Job, run_job
from neurframe_cli.batch.outcome import Outcome
from neurframe_cli.errors import StageError, UsageError

if TYPE_CHECKING:
    from distributed import Client

LOOPBACK, SLURM = "loopback", "slurm"
CONNECT_S = 10
LATE_S = 300  # a worker on a busy node needs its time to start; dask-jobqueue's own limit is a minute

Submit = Callable[[Job], "Future[Outcome]"]


class NoScheduler(StageError):
    """There is no scheduler at the address."""


@dataclass(frozen=True)
class PoolOptions:
    """scheduler: None for threads of this process, LOOPBACK for Dask workers on this machine, SLURM, or the address
    of a Dask scheduler; jobs: at the same time, where we start the workers; threads, memory_mib: of a job."""

    scheduler: str | None = None
    jobs: int = 1
    threads: int | None = None
    memory_mib: float | None = None


@contextlib.contextmanager
def open_pool(options: PoolOptions) -> Iterator[Submit]:
    """A function that takes jobs; leaving the block ends those that still run.

    A future is cancelled where the scheduler was lost.  Raises UsageError where a package is missing, NoScheduler.
    """
    if options.scheduler is None:
        with _threads(options.jobs) as submit:
            yield submit
    else:
        with _client(options) as client:
            executor = client.get_executor(pure=False)
            try:
                yield lambda job: executor.submit(run_on_worker, job)
            finally:
                executor.shutdown(wait=False)


@contextlib.contextmanager
def _threads(jobs: int) -> Iterator[Submit]:
    """Each thread only waits for its child."""
    stop = threading.Event()
    executor = ThreadPoolExecutor(jobs)
    try:
        yield lambda job: executor.submit(run_job, job, stop.is_set)
    finally:
        stop.set()
        executor.shutdown(cancel_futures=True)


def run_on_worker(job: Job) -> Outcome:
    """run_job in a thread of a Dask worker, until its client gives it up or the worker loses its scheduler."""
    from distributed import get_worker
    from distributed.core import Status

    worker = get_worker()
    key = worker.get_current_task()

    def should_stop() -> bool:
        task = worker.state.tasks.get(key)
        given_up = task is None or task.state in ("cancelled", "released", "forgotten")
        return given_up or worker.status not in (Status.running, Status.paused)

    return run_job(job, should_stop)


@contextlib.contextmanager
def _client(options: PoolOptions) -> Iterator[Client]:
    try:
        from distributed import Client
    except ImportError as error:
        raise _missing("distributed") from error
    # it tells of every closed connection on several lines; what matters here comes back as outcomes
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    with contextlib.ExitStack() as stack:
        target: Any = options.scheduler
        if options.scheduler == LOOPBACK:
            target = stack.enter_context(_loopback(options))
        elif options.scheduler == SLURM:
            target = stack.enter_context(_slurm(options))
        try:
            client = Client(target, timeout=CONNECT_S)
        except (OSError, TimeoutError, ValueError) as error:
            raise NoScheduler(
                f"no Dask scheduler answers at {options.scheduler}: {error}",
                hint="start one with `dask scheduler`, or name another with --scheduler",
            ) from error
        yield stack.enter_context(_until_closed(client))


@contextlib.contextmanager
def _until_closed(client: Client) -> Iterator[Client]:
    """The client's block.  One that is trying to reach a lost scheduler again fails when its connections are closed:
    that must not hide why the block is left."""
    client.__enter__()
    try:
        yield client
    finally:
        with contextlib.suppress(OSError, RuntimeError):
            client.__exit__(None, None, None)


def _loopback(options: PoolOptions) -> Any:
    from distributed import LocalCluster

    return LocalCluster(
        n_workers=options.jobs,
        threads_per_worker=1,
        host="127.0.0.1",
        dashboard_address=None,
        memory_limit=None,  # a job has its own limit
        silence_logs=logging.CRITICAL,
    )


def _slurm(options: PoolOptions) -> Any:
    """A Slurm job for each worker, and another for one that is lost; queue, account, wall time and the like come from
    jobqueue.slurm in Dask's config."""
    try:
        from dask_jobqueue import SLURMCluster
    except ImportError as error:
        raise _missing("dask-jobqueue") from error
    chosen: dict[str, Any] = {"processes": 1, "death_timeout": LATE_S}
    if options.threads is not None:
        chosen["cores"] = options.threads
    if options.memory_mib is not None:
        chosen["memory"] = f"{options.memory_mib:.0f}MiB"
    try:
        cluster = SLURMCluster(**chosen)
    except (ValueError, TypeError) as error:
        raise UsageError(
            f"dask-jobqueue: {error}",
            hint="give --threads and --memory, or set jobqueue.slurm in ~/.config/dask/jobqueue.yaml",
        ) from error
    cluster.adapt(minimum_jobs=options.jobs, maximum_jobs=options.jobs)
    return cluster


def _missing(package: str) -> UsageError:
    return UsageError(f"--scheduler needs the package {package}", hint="pip install 'neurframe[batch]'")

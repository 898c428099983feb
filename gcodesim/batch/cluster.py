"""The distributed run: jobs go to Dask workers, each of which keeps a warm process of its own."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from gcodesim.batch.jobs import Job
from gcodesim.batch.pool import core_count
from gcodesim.batch.process import WorkerProcess
from gcodesim.batch.records import WORKER_LOST, Record, lost
from gcodesim.errors import UsageError

if TYPE_CHECKING:
    from distributed import Client

LOCAL = "local"
"""Address that stands for a cluster of our own on this machine."""

PATIENCE_S = 30
"""[s] Time that a scheduler has to answer, and to have a first worker."""

_here = threading.local()


def check_on_cluster(
    jobs: Sequence[Job], address: str, count: int | None, limit_s: float | None
) -> Iterator[Record]:
    """Yield the records of jobs as they are done.

    What a lost worker had in hand is done again elsewhere; only a job that keeps losing workers
    is given up (`distributed.scheduler.allowed-failures`). The workers must see the same files
    under the same paths.

    Args:
        jobs: in the order in which they are begun.
        address: of the scheduler, or LOCAL.
        count: workers of a local cluster; None: one per core.
        limit_s: time after which a check is ended [s].

    Raises:
        UsageError: Dask is not installed, or the scheduler does not answer or has no worker.
    """
    if not jobs:
        return
    with _client(address, count) as client:
        from distributed import as_completed

        futures = {  # each worker is one of many: it has one thread
            client.submit(
                check_here, job.with_options(threads=1), limit_s, pure=False, priority=-place
            ): job
            for place, job in enumerate(jobs)
        }
        for future in as_completed(list(futures)):
            job, error = futures.pop(future), future.exception()
            if error:
                yield lost(job, WORKER_LOST, f"the cluster gave up: {error!r}")
            else:
                yield future.result()


def check_here(job: Job, limit_s: float | None) -> Record:
    """Check a job in the process that belongs to this thread of a Dask worker."""
    if not hasattr(_here, "worker"):
        _here.worker = WorkerProcess(job.options.device)
    worker: WorkerProcess = _here.worker
    return worker.check(job, limit_s)


@contextmanager
def _client(address: str, count: int | None) -> Iterator[Client]:
    """A client of a scheduler that has a worker."""
    try:
        from distributed import Client, LocalCluster
    except ImportError as error:
        raise UsageError("--scheduler needs Dask: pip install 'gcodesim[cluster]'") from error
    if address == LOCAL:
        cluster = LocalCluster(
            n_workers=count or core_count(), threads_per_worker=1, dashboard_address=None
        )
        with cluster, Client(cluster) as client:
            yield client
        return
    try:
        client = Client(address, timeout=PATIENCE_S)
    except (OSError, ValueError) as error:
        raise UsageError(f"--scheduler {address}: no answer: {error}") from error
    with client:
        try:
            client.wait_for_workers(1, timeout=PATIENCE_S)
        except TimeoutError as error:
            raise UsageError(
                f"--scheduler {address}: has no worker: start `dask worker`"
            ) from error
        yield client

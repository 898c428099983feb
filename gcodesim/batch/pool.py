"""The local run: one thread per warm worker process, all fed from one queue of jobs."""

from __future__ import annotations

import ctypes
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from queue import Empty, SimpleQueue
from threading import Thread
from typing import TYPE_CHECKING

from gcodesim.batch.process import WorkerProcess

if TYPE_CHECKING:
    from gcodesim.batch.jobs import Job
    from gcodesim.batch.records import Record

PLENTY = 8
"""Jobs left per worker while each is sent one before its turn, so that none waits for the next."""


def worker_devices(device: str, count: int | None) -> list[str]:
    """The device of each worker: `count` of them, or one per core or GPU; UsageError."""
    devices = ["cpu"]
    if device != "cpu" and (device != "auto" or _has_driver()):
        # Warp takes half a second to import.
        from gcodesim.collision.geometry.device import every_device

        devices = every_device(device)
    count = count or (core_count() if devices == ["cpu"] else len(devices))
    return [devices[worker % len(devices)] for worker in range(count)]


def _has_driver() -> bool:
    """Whether there is a CUDA driver; without one there is no GPU to ask Warp for."""
    try:
        ctypes.CDLL("nvcuda.dll" if os.name == "nt" else "libcuda.so.1")
    except OSError:
        return False
    return True


def core_count() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@contextmanager
def warm_workers(devices: Sequence[str]) -> Iterator[list[WorkerProcess]]:
    """Worker processes, one per device, that warm up while other things are done."""
    workers = [WorkerProcess(device) for device in devices]
    try:
        yield workers
    finally:
        for worker in workers:
            worker.stop()


def check_local(
    jobs: Sequence[Job], workers: Sequence[WorkerProcess], limit_s: float | None
) -> Iterator[Record]:
    """Yield the records of jobs as they are done; longest first, so that all end together.

    Args:
        jobs: in the order in which they are begun.
        workers: what does them.
        limit_s: time after which a check is ended [s].
    """
    pending: SimpleQueue[Job]
    done: SimpleQueue[Record | Exception]
    pending, done = SimpleQueue(), SimpleQueue()
    for job in jobs:
        pending.put(job)
    share = max(1, core_count() // len(workers))

    def hand_out(worker: WorkerProcess) -> None:
        ahead = 1 if pending.qsize() >= PLENTY * len(workers) else 0
        while worker.in_hand <= ahead:
            job = pending.get_nowait()
            worker.send(job.with_options(device=worker.device, threads=share))

    def feed(worker: WorkerProcess) -> None:
        try:
            while not worker.retired:
                with suppress(Empty):
                    hand_out(worker)
                if not worker.in_hand:
                    return
                done.put(worker.receive(limit_s))
        except Exception as error:
            done.put(error)

    threads = [Thread(target=feed, args=(worker,)) for worker in workers]
    for thread in threads:
        thread.start()
    try:
        for _ in jobs:
            record = done.get()
            if isinstance(record, Exception):
                raise record
            yield record
    finally:
        for worker in workers:
            worker.retire()
        for thread in threads:
            thread.join()

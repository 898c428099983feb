"""A worker process as its parent sees it: a job in, a record out, whatever happens to it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections import deque
from contextlib import suppress
from threading import Timer
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from gcodesim.batch.jobs import Job
    from gcodesim.batch.records import Record

_CODE = """
import gc, sys
gc.disable()
sys.path[:] = {path!r}
from gcodesim.batch.worker import serve
serve({device!r})
"""

_ONE_THREAD = dict.fromkeys(("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"), "1")
"""NumPy's products of a check are small: threads for them take longer to start than they save."""


class WorkerProcess:
    """A process that stays warm: Warp is imported, kernels and machines are loaded once.

    Not multiprocessing, whose processes may not be started from the daemons that Dask workers are,
    and whose main module is run again by every one of them. Lines of JSON on its standard streams
    are all it takes.
    """

    def __init__(self, device: str) -> None:
        self.device = device
        self.retired = False
        self._in_hand: deque[Job] = deque()
        self._warm = False
        self._process: subprocess.Popen[str] | None = _start(device)

    @property
    def in_hand(self) -> int:
        """Jobs that were sent and have no record yet."""
        return len(self._in_hand)

    def check(self, job: Job, limit_s: float | None) -> Record:
        """The record of a job; see `receive`."""
        self.send(job)
        return self.receive(limit_s)

    def send(self, job: Job) -> None:
        """Hand over a job; it is begun as soon as those before it are done."""
        self._process = self._process or _start(self.device)
        if self.retired:  # while it was started
            self._process.kill()
        assert self._process.stdin is not None
        self._in_hand.append(job)
        with suppress(BrokenPipeError):  # `receive` will find out
            print(job.as_json(), flush=True, file=self._process.stdin)

    def receive(self, limit_s: float | None) -> Record:
        """The record of the job that was sent first.

        A process that ends, or is ended after `limit_s` seconds, costs this job only: a new one
        takes over what else was sent.
        """
        assert self._process is not None
        if not self._warm:  # what it takes to start counts for no job
            self._read(None)
            self._warm = True
        begin = time.perf_counter()
        line = self._read(limit_s)
        seconds = time.perf_counter() - begin
        job = self._in_hand.popleft()
        if line.endswith("\n"):
            record: Record = json.loads(line)
            return record
        code = self.stop()
        others, self._in_hand = self._in_hand, deque()
        for other in others:
            self.send(other)
        return _lost(job, code, seconds, limit_s)

    def retire(self) -> None:
        """End the process and let it not be started again; from any thread."""
        self.retired = True
        if process := self._process:
            process.kill()

    def stop(self) -> int:
        """End the process; return its exit status, minus the signal that ended it."""
        process, self._process, self._warm = self._process, None, False
        if process is None:
            return 0
        with suppress(BrokenPipeError), process:  # what was still to be sent to it
            process.kill()
        return process.returncode

    def _read(self, limit_s: float | None) -> str:
        """The next line of the process; a part of one, or nothing, when it ends."""
        assert self._process is not None
        assert self._process.stdout is not None
        if limit_s is None:
            return self._process.stdout.readline()
        clock = Timer(limit_s, self._process.kill)
        clock.start()
        try:
            return self._process.stdout.readline()
        finally:
            clock.cancel()


def _start(device: str) -> subprocess.Popen[str]:
    """A new process, which says a line when it is warm."""
    return subprocess.Popen(
        [sys.executable, "-c", _CODE.format(path=sys.path, device=device)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        encoding="utf-8",
        env=_ONE_THREAD | os.environ,
    )


def _lost(job: Job, code: int, seconds: float, limit_s: float | None) -> Record:
    """The record of a job whose process ended."""
    from gcodesim.batch.records import OVERDUE, WORKER_LOST, lost  # the start is to be quick

    if limit_s is not None and seconds >= limit_s:
        why = f"stopped after {limit_s:g} s, the limit of time for one program"
        return lost(job, OVERDUE, why, seconds)
    return lost(job, WORKER_LOST, f"the worker process ended (exit status {code})", seconds)

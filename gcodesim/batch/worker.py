"""The inside of a worker process: jobs come in line by line, and records go out."""

from __future__ import annotations

import gc
import json
import os
import signal
import sys
import time
import traceback
from contextlib import chdir
from dataclasses import replace
from functools import lru_cache
from threading import Thread
from typing import Any, TextIO

from gcodesim import __version__
from gcodesim.batch.jobs import Job
from gcodesim.batch.records import WORKER_LOST, Record, lost
from gcodesim.checking.flow import check_program
from gcodesim.collision.detector import load_kernels
from gcodesim.collision.geometry.device import resolve_device
from gcodesim.collision.geometry.kernel_cache import remarks
from gcodesim.errors import UsageError
from gcodesim.input_file import file_mark
from gcodesim.machine.loading import load_machine
from gcodesim.machine.model import Machine
from gcodesim.nc.lines import read_program
from gcodesim.policy.policy import Policy
from gcodesim.report.json_report import report_dict

LOADED = 8
"""Machines, each with its setup and tools, that a worker keeps: meshes take memory."""

PARENT_S = 1.0
"""[s] How often a worker looks whether its parent is still there."""


def serve(device: str) -> None:
    """Answer jobs on standard input with records on standard output until it is closed."""
    answers = _take_stdout()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the parent, which ends us
    Thread(target=_end_with, args=(os.getppid(),), daemon=True).start()
    try:
        load_kernels("search", resolve_device(device))
        for remark in remarks():
            print(f"gcodesim: {remark}", file=sys.stderr)
        # Modules stay for good: the collector, off while they were imported, need not look at them.
        gc.freeze()
        gc.enable()
        print(flush=True, file=answers)
        for line in sys.stdin:
            print(json.dumps(do(Job.from_json(line))), flush=True, file=answers)
    except BrokenPipeError:
        pass  # the parent is gone


def _take_stdout() -> TextIO:
    """Standard output for records alone: what anything else prints goes to standard error."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    return answers


def _end_with(parent: int) -> None:
    """End in mid-check when the parent was killed: there is no one to answer to."""
    while os.getppid() == parent:
        time.sleep(PARENT_S)
    os._exit(1)


def do(job: Job) -> Record:
    """The record of a job; a defect of gcodesim costs this program only."""
    begin = time.perf_counter()
    answer: dict[str, Any]
    try:
        with chdir(job.folder):
            answer = _answer(job)
    except (UsageError, OSError) as error:
        answer = {"error": str(error)}
    except Exception as error:
        traceback.print_exc()
        why = f"a defect of gcodesim, please report it: {type(error).__name__}: {error}"
        return lost(job, WORKER_LOST, why, time.perf_counter() - begin)
    return {**job.label, "seconds": time.perf_counter() - begin, **answer}


def _answer(job: Job) -> dict[str, Any]:
    """What a record says besides the label of its job."""
    if job.version != __version__:
        raise UsageError(f"this worker has gcodesim {__version__}, the batch {job.version}")
    text = read_program(job.program)
    machine, policy = _loaded(replace(job, program="", snapshot="", size=0, key=""))
    result = check_program(text, job.program, machine, job.options)
    result = replace(result, setup=job.setup)
    result, gap = policy.apply(result, text, stop_all=job.options.stop_all), {}
    if job.snapshot and result.shown:
        from gcodesim.report.snapshot import with_snapshot  # slow to import, and seldom needed

        try:
            result = with_snapshot(result, job.snapshot)
        except OSError as error:  # the answer stands without it
            gap = {"unwritten": str(error)}
    # What the program called, or would have called, is known only now.
    files = {job.program: file_mark(job.program), **result.looked_up}
    return {"report": report_dict(result), "files": files, **gap}


@lru_cache(LOADED)
def _loaded(job: Job) -> tuple[Machine, Policy]:
    """Machine and policy of a job that names no program; read again when their files change."""
    asked = job.asked
    machine = load_machine(
        job.machine, tools=asked.tools, setup=asked.setup, allow_outside=asked.allow_outside
    )
    return machine.with_readings(rapids=asked.rapids), job.policy()

"""The benchmark: the seed paper's tables, every stage of a check, and the search in figures."""

from __future__ import annotations

import datetime
import os
import platform
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from importlib.metadata import version
from pathlib import Path as FilePath
from typing import Any

import numpy as np

from gcodesim import __version__
from gcodesim.checking.flow import check_program
from gcodesim.checking.options import Options
from gcodesim.collision.geometry.device import resolve_device
from gcodesim.constants import DEFAULT_PERIOD_PS, PS_PER_S
from gcodesim.machine.control_data import control_for
from gcodesim.machine.loading import load_machine
from gcodesim.motion.overtravel import overtravels
from gcodesim.motion.planner import plan
from gcodesim.nc.interpret import interpret
from gcodesim.nc.lines import read_program
from gcodesim.study.clock import RUNS, Timing, time_runs
from gcodesim.study.job import (
    WINDOW_PS,
    StudyJob,
    clearances_at,
    exhaustive_job,
    longest_job,
    repeated,
    search_job,
    window_search,
)
from gcodesim.study.paper_tables import paper_table

SCHEMA = "gcodesim.bench/1"

EXHAUSTIVE_SAMPLES = 4_000
"""Samples at which the exhaustive method and the search are compared; the period follows."""

CLEARANCE_INSTANTS = 200
"""Instants whose smallest distances give the median clearance."""

WINDOWS = 2_000
"""Windows of 1 ms that are timed, spread evenly over the program."""


@dataclass(frozen=True)
class BenchOptions:
    """What to measure.

    Attributes:
        program, machine: as for a check.
        device: auto | cpu | cuda | cuda:N; the paper's method is timed on the CPU too.
        seconds: least machine time of the long search [s].
        paper_samples: samples at which the paper's method is timed.
    """

    program: str
    machine: str
    device: str = "auto"
    seconds: float = 600.0
    paper_samples: int = 50


def bench(options: BenchOptions, progress: Callable[[float], None]) -> dict[str, Any]:
    """Measure, one thing after the other; the result is ready for JSON.

    Raises:
        UsageError: a file cannot be read, the device is not known, or nothing moves.
    """
    device = resolve_device(options.device)
    text, machine = read_program(options.program), load_machine(options.machine)
    meaning = interpret(text, control_for(machine, None, None, False), options.program)
    job = longest_job(plan(meaning.program, machine)[0], machine, DEFAULT_PERIOD_PS)
    stages = _stages_before(options, text)
    stages |= _stages_after(job, device, text, options.program)
    progress(0.2)
    report: dict[str, Any] = {"schema": SCHEMA, **environment(), "device": device, "runs": RUNS}
    report["device_name"] = job.scene(device).arrays.triangles.device.name
    report["program"] = _program(options, job, meaning.blocks)
    report["stages"] = stages
    report["search"] = _search(job, device, options.seconds)
    progress(0.5)
    report["windows"] = _windows(job, device)
    report["exhaustive"] = _exhaustive(job, device)
    progress(0.7)
    report["paper"] = _paper(job, device, options.paper_samples)
    progress(1.0)
    return report


def _stages_before(options: BenchOptions, text: str) -> dict[str, Any]:
    """Stages up to the path."""
    read, _ = time_runs(lambda: read_program(options.program))
    load, machine = time_runs(lambda: load_machine(options.machine))
    control = control_for(machine, None, None, False)
    interpreted, meaning = time_runs(lambda: interpret(text, control, options.program))
    planned, (path, _) = time_runs(lambda: plan(meaning.program, machine))
    limits, _ = time_runs(lambda: overtravels(path, machine.joints))
    command = [sys.executable, "-c", "import gcodesim.collision.detector"]
    started, _ = time_runs(lambda: subprocess.run(command, check=True))
    return {
        "read": seconds(read),
        "load machine": seconds(load),
        "interpret": seconds(interpreted) | {"blocks_per_s": meaning.blocks / interpreted.median},
        "plan": seconds(planned),
        "limits": seconds(limits),
        "start": seconds(started) | {"note": "a fresh Python process that imports the detector"},
    }


def _stages_after(job: StudyJob, device: str, text: str, name: str) -> dict[str, Any]:
    """Stages from the path to the verdict, for the program as it is."""
    scene_timing, scene = time_runs(lambda: job.scene(device))
    forest, _ = time_runs(lambda: job.forest(scene))
    searcher = job.searcher(scene, threads=1)
    search, _ = time_runs(lambda: search_job(searcher))
    options = Options(device=device)
    check, _ = time_runs(lambda: check_program(text, name, job.machine, options))
    compiled = max(0.0, search.first - search.median)
    note = "first search less the median: kernels compiled, or loaded from the cache; once"
    return {
        "scene": seconds(scene_timing),
        "forest": seconds(forest),
        "compile": {"median_s": compiled, "note": note},
        "search": seconds(search),
        "whole check": seconds(check) | {"note": "interpret to verdict, warm, all threads"},
    }


def _program(options: BenchOptions, job: StudyJob, blocks: int) -> dict[str, Any]:
    searcher = job.searcher(job.scene("cpu"), threads=1)
    times = np.linspace(0, job.path.duration_ps, CLEARANCE_INSTANTS + 1)[1:].astype(np.int64)
    distances = clearances_at(searcher, times)
    return {
        "file": FilePath(options.program).name,
        "machine": job.machine.name,
        "blocks": blocks,
        "pieces": len(job.path),
        "duration_s": job.path.duration_s,
        "path_mm": job.length_mm,
        "median_clearance_mm": float(np.median(distances.min(axis=0))),
        "median_clearance_of_pairs_mm": {
            pair.name: float(np.median(row))
            for pair, row in zip(searcher.scene.pairs, distances, strict=True)
        },
    }


def _search(job: StudyJob, device: str, least_seconds: float) -> dict[str, Any]:
    """The search of the long job, with one thread and with two."""
    long_job = repeated(job, least_seconds)
    scene = long_job.scene(device)
    threads = []
    for count in (1, 2) if device == "cpu" else (1,):
        searcher = long_job.searcher(scene, count)
        timing, answer = time_runs(partial(search_job, searcher))
        threads.append(seconds(timing) | {"threads": count} | speed(timing, answer.end_ps, job))
    return {
        "pieces": len(long_job.path),
        "duration_s": long_job.path.duration_s,
        "searched_s": answer.end_ps / PS_PER_S,
        "pairs": len(scene.pairs),
        "first_contact": [answer.sample, answer.pair] if answer.pair else None,
        "items": answer.items,
        "triangle_tests": answer.triangle_tests,
        "threads": threads,
    }


def speed(timing: Timing, searched_ps: int, job: StudyJob) -> dict[str, float]:
    """Microseconds per sample, and how many times faster than the machine moves."""
    samples = max(1, searched_ps // job.period_ps)
    return {
        "us_per_sample": timing.median / samples * 1e6,
        "least_us_per_sample": timing.least / samples * 1e6,
        "times_machine_speed": searched_ps / PS_PER_S / timing.median,
    }


def _windows(job: StudyJob, device: str) -> dict[str, Any]:
    """Cost of single windows of 1 ms of machine time on one thread: the real-time question."""
    searcher = job.searcher(job.scene(device), threads=1)
    last = max(0, job.path.duration_ps // WINDOW_PS - 1)
    numbers = np.unique(np.linspace(0, last, WINDOWS).astype(np.int64))
    costs = [time_runs(window_search(searcher, int(number)))[0].median for number in numbers]
    worst = int(np.argmax(costs))
    return {
        "windows": len(costs),
        "median_us": float(np.median(costs) * 1e6),
        "percentile_99_9_us": float(np.percentile(costs, 99.9) * 1e6),
        "maximum_us": costs[worst] * 1e6,
        "maximum_at_s": float(numbers[worst] * WINDOW_PS / PS_PER_S),
    }


def _exhaustive(job: StudyJob, device: str) -> dict[str, Any]:
    """The exhaustive method against the search, at samples far enough apart to take seconds.

    The answers are compared at that period; the speed of the search is that at the true one.
    """
    period_ps = max(job.period_ps, -(-job.path.duration_ps // EXHAUSTIVE_SAMPLES))
    scene = job.scene(device)
    coarse = replace(job, period_ps=period_ps).searcher(scene, threads=1, between=False)
    exhaustive, expected = time_runs(lambda: exhaustive_job(coarse))
    found = search_job(coarse)
    fine = job.searcher(scene, threads=1)
    search, answer = time_runs(lambda: search_job(fine))
    looked_at = expected.end_ps // period_ps + 1
    per_sample = exhaustive.median / looked_at * 1e6
    searched = speed(search, answer.end_ps, job)["us_per_sample"]
    return {
        "period_s": period_ps / PS_PER_S,
        "samples": looked_at,
        "exhaustive_us_per_sample": per_sample,
        "search_us_per_sample": searched,
        "ratio": per_sample / searched,
        "exhaustive_answer": [expected.sample, expected.pair],
        "search_answer": [found.sample, found.pair],
        "same_answer": (expected.sample, expected.pair) == (found.sample, found.pair),
    }


def _paper(job: StudyJob, device: str, samples: int) -> list[dict[str, Any]]:
    devices = ["cpu"] if device == "cpu" else ["cpu", device]
    return [paper_table(job, each, samples) for each in devices]


def seconds(timing: Timing) -> dict[str, Any]:
    """A timing as values for JSON."""
    return {"median_s": timing.median, "least_s": timing.least}


def cpu_name() -> str:
    """Model name of the processor, as far as the system tells."""
    try:
        lines = FilePath("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


def environment() -> dict[str, Any]:
    """When and on what something was measured."""
    return {
        "date": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "versions": {
            "gcodesim": __version__,
            "warp": version("warp-lang"),
            "numpy": version("numpy"),
            "python": platform.python_version(),
        },
        "cpu": cpu_name(),
        "cores": os.cpu_count(),
    }

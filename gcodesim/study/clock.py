"""Timing: the median of several runs after one that warms up."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

RUNS = 5
"""Runs of which a median is taken; fewer let one disturbance through."""


T = TypeVar("T")


@dataclass(frozen=True)
class Timing:
    """Seconds of several runs of the same work.

    Attributes:
        first: the run that warmed up; caches and kernels were cold [s].
        runs: those after it [s].
    """

    first: float
    runs: tuple[float, ...]

    @property
    def median(self) -> float:
        """Median of the runs [s]."""
        return statistics.median(self.runs)

    @property
    def least(self) -> float:
        """Fastest run [s]: what is left when nothing else works on the machine."""
        return min(self.runs)


def time_runs(work: Callable[[], T], runs: int = RUNS) -> tuple[Timing, T]:
    """Run `work` once to warm up, then `runs` times; the timing and the last result."""
    seconds = []
    for _ in range(runs + 1):
        begin = time.perf_counter()
        result = work()
        seconds.append(time.perf_counter() - begin)
    return Timing(seconds[0], tuple(seconds[1:])), result

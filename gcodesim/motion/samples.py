"""Samples: the instants at which a path is looked at, in windows of the integer sample index."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gcodesim.motion.path import Path


@dataclass(frozen=True)
class Instants:
    """m instants in the order of time.

    Attributes:
        time_ps: shape (m,) int64.
        piece: path piece in force, shape (m,) int32.
        sample: sample index the instant counts for, ceil(time / period), shape (m,) int64.
    """

    time_ps: NDArray[np.int64]
    piece: NDArray[np.int32]
    sample: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.time_ps)


@dataclass(frozen=True)
class Span:
    """A stretch of program time [ps], both ends included, with one tool in the spindle."""

    start_ps: int
    end_ps: int
    tool: int


def tool_spans(path: Path) -> list[Span]:
    """Stretches of the path between tool changes; a path without pieces is one instant."""
    if not len(path):
        return [Span(0, 0, 0)]
    cuts = [0, *(np.flatnonzero(np.diff(path.tool)) + 1).tolist(), len(path)]
    return [
        Span(int(path.bounds_ps[i]), int(path.bounds_ps[j]), int(path.tool[i]))
        for i, j in zip(cuts[:-1], cuts[1:], strict=True)
    ]


def sample_of(time_ps: int, period_ps: int) -> int:
    """Sample index a time counts for: ceil(time / period)."""
    return -(-time_ps // period_ps)


def sample_count(path: Path, period_ps: int) -> int:
    """Number of sample indices of a path: 0 .. ceil(duration / period)."""
    return sample_of(path.duration_ps, period_ps) + 1


def window(path: Path, span: Span, first: int, count: int, period_ps: int) -> Instants:
    """Instants of a span whose sample index lies in [first, first + count).

    Every sample, every piece end and the start of the span. Samples inside a piece that does not
    move (a dwell) repeat the pose of its end and are left out.
    """
    low = max(span.start_ps, (first - 1) * period_ps + 1)
    high = min(span.end_ps, (first + count - 1) * period_ps)
    k0, k1 = sample_of(low, period_ps), high // period_ps
    samples = np.arange(k0, k1 + 1, dtype=np.int64) * period_ps
    i0, i1 = np.searchsorted(path.bounds_ps, [low, high + 1])
    times = np.unique(np.concatenate([samples, path.bounds_ps[i0:i1]]))
    piece = path.piece_at(times)
    if len(path):
        still = np.all(path.q0[piece] == path.q1[piece], axis=1) & (path.arc[piece] < 0)
        at_end = (times == path.bounds_ps[piece + 1]) | (times == span.start_ps)
        times, piece = times[~still | at_end], piece[~still | at_end]
    return Instants(times, piece, -(-times // period_ps))


def windows(path: Path, span: Span, count: int, period_ps: int) -> list[int]:
    """First sample index of each window of `count` samples that covers the span."""
    first = sample_of(span.start_ps, period_ps)
    return list(range(first, sample_of(span.end_ps, period_ps) + 1, count))

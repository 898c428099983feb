"""Samples: the instants at which a path is looked at, in windows of the integer sample index."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gcodesim.constants import PS_PER_S
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
    """A stretch of program time [ps], both ends included, with one tool in the spindle.

    `tool` is None before the first tool change; `line` is the block that changed the tool.
    """

    start_ps: int
    end_ps: int
    tool: int | None
    line: int


@dataclass(frozen=True)
class SomePieces:
    """Some pieces of a path, each with both its ends.

    Attributes:
        wanted: whether a piece is one of them, shape (n,).
    """

    path: Path
    wanted: NDArray[np.bool_]

    def runs(self, first: int, end: int) -> list[tuple[int, int]]:
        """First piece and end of each unbroken run of wanted pieces among first..end."""
        inside = np.concatenate([[False], self.wanted[first:end], [False]])
        edges = np.flatnonzero(inside[1:] != inside[:-1]) + first
        return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]

    def end_ps(self, time_ps: int) -> int:
        """When the run ends [ps] in which a time, or what follows it, lies."""
        piece = int(self.path.piece_at(np.array([time_ps + 1]))[0])
        others = np.flatnonzero(~self.wanted[piece:])
        return int(
            self.path.bounds_ps[piece + others[0]] if len(others) else self.path.bounds_ps[-1]
        )

    def kept(self, instants: Instants) -> Instants:
        """The instants that lie in wanted pieces, or where one begins."""
        piece = instants.piece
        later = np.minimum(piece + 1, len(self.wanted) - 1)
        begins = self.wanted[later] & (instants.time_ps == self.path.bounds_ps[piece + 1])
        starts = self.wanted[piece] & (instants.time_ps >= self.path.bounds_ps[piece])
        some = np.flatnonzero(starts | begins)
        return Instants(instants.time_ps[some], piece[some], instants.sample[some])


def tool_spans(path: Path) -> list[Span]:
    """SomePieces of the path between tool changes."""
    starts: list[tuple[int, int | None, int]] = [(0, None, 0)]
    starts += [
        (int(path.bounds_ps[change.piece]), change.number, change.line)
        for change in path.tool_changes
    ]
    ends = [start for start, _, _ in starts[1:]] + [path.duration_ps]
    return [
        Span(start, end, tool, line) for (start, tool, line), end in zip(starts, ends, strict=True)
    ]


def tool_times(path: Path) -> tuple[tuple[int | None, float], ...]:
    """Program time with each tool in the spindle [s], in the order of first use."""
    ticks: dict[int | None, int] = {}
    for span in tool_spans(path):
        if span.end_ps > span.start_ps:
            ticks[span.tool] = ticks.get(span.tool, 0) + span.end_ps - span.start_ps
    return tuple((tool, count / PS_PER_S) for tool, count in ticks.items())


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
    ends = np.unique(path.bounds_ps[i0:i1])
    ends = ends[ends % period_ps != 0]
    times = np.insert(samples, np.searchsorted(samples, ends), ends)
    piece = path.piece_at(times)
    if len(path) and len(times):
        run = slice(int(piece[0]), int(piece[-1]) + 1)
        still = np.all(path.q0[run] == path.q1[run], axis=1) & (path.arc[run] < 0)
        if still.any():
            inside = still[piece - run.start]
            at_end = (times == path.bounds_ps[piece + 1]) | (times == span.start_ps)
            times, piece = times[~inside | at_end], piece[~inside | at_end]
    return Instants(times, piece, -(-times // period_ps))


def windows(path: Path, span: Span, count: int, period_ps: int) -> Iterator[int]:
    """Yield the first sample index of each window of `count` samples that covers the span.

    Windows in which nothing moves (inside a long dwell) are passed over.
    """
    first, last = sample_of(span.start_ps, period_ps), sample_of(span.end_ps, period_ps)
    while first <= last:
        yield first
        first += count
        if first < last and len(path):
            piece = path.piece_at(np.array([first * period_ps]))[0]
            still = path.arc[piece] < 0 and np.array_equal(path.q0[piece], path.q1[piece])
            # Blocks may end between the last sample looked at and the dwell: not to be jumped.
            if still and path.bounds_ps[piece] <= (first - 1) * period_ps:
                first = max(first, sample_of(int(path.bounds_ps[piece + 1]), period_ps))

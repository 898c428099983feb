"""Contact intervals: every stretch of time in which a pair touches, for --stop all."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from gcodesim.collision.bodies.keys import NO_CONTACT
from gcodesim.collision.search.approach import Approach, event_of
from gcodesim.collision.search.depths import DepthGauge
from gcodesim.collision.search.lasting import touches_at
from gcodesim.collision.search.search import Roots, Searcher
from gcodesim.constants import PS_PER_S
from gcodesim.motion.samples import Instants, Span, window, windows

MERGED_PS = PS_PER_S // 20
"""Contacts of one pair with less than 50 ms between them are one: people act on one place."""

FIRST_WINDOW, LAST_WINDOW = 4_096, 262_144
"""Samples looked at together while a contact lasts: at first, and at most."""


@dataclass(frozen=True)
class Interval:
    """A stretch of time in which a pair touches.

    Attributes:
        pair: index in the scene.
        start_ps, end_ps: first and last instant in contact.
        deepest: largest distance of a vertex inside the other body from its surface [mm], among
            some instants.
        deepest_ps: when.
        deeper_by: how much more it may be at any other instant [mm].
        between: it lies between two samples.
    """

    pair: int
    start_ps: int
    end_ps: int
    deepest: float = 0.0
    deepest_ps: int = 0
    deeper_by: float = 0.0
    between: bool = False


def contact_intervals(searcher: Searcher, span: Span) -> list[Interval]:
    """All contact intervals of all pairs within a span, in the order of time."""
    found: list[Interval] = []
    for pair in range(len(searcher.scene.pairs)):
        if searcher.settings.free_mm[pair] >= 0.0:
            merged: list[Interval] = []
            for interval in _intervals_of(_only(searcher, pair), span, pair):
                if merged and interval.start_ps - merged[-1].end_ps < MERGED_PS:
                    merged[-1] = replace(
                        merged[-1],
                        end_ps=interval.end_ps,
                        between=merged[-1].between and interval.between,
                    )
                else:
                    merged.append(interval)
            found += merged
    return sorted(_with_depths(searcher, found), key=lambda i: (i.start_ps, i.pair))


def _with_depths(searcher: Searcher, intervals: list[Interval]) -> list[Interval]:
    """The intervals with their depths, pair by pair."""
    pairs = sorted({interval.pair for interval in intervals})
    gauge = DepthGauge(searcher, pairs) if pairs else None
    found: list[Interval] = []
    for row, pair in enumerate(pairs):
        own = [interval for interval in intervals if interval.pair == pair]
        assert gauge is not None
        depths = gauge.deepest(row, [(i.start_ps, i.end_ps) for i in own])
        found += [
            replace(i, deepest=d.deepest, deepest_ps=d.time_ps, deeper_by=d.within)
            for i, d in zip(own, depths, strict=True)
        ]
    return found


def _only(searcher: Searcher, pair: int) -> Searcher:
    free = tuple(f if i == pair else -1.0 for i, f in enumerate(searcher.settings.free_mm))
    return replace(searcher, settings=replace(searcher.settings, free_mm=free))


def _intervals_of(searcher: Searcher, span: Span, pair: int) -> Iterator[Interval]:
    time: int | None = span.start_ps
    while time is not None and time < span.end_ps:
        event = _event_after(searcher, span, pair, time)
        if event is None:
            return
        if isinstance(event, Approach):
            yield Interval(pair, event.start_ps, event.end_ps, between=True)
            time = event.end_ps
            continue
        start, end, time = _lasting(searcher, span, pair, event[0])
        yield Interval(pair, start, end)


def _event_after(
    searcher: Searcher, span: Span, pair: int, time_ps: int
) -> tuple[int, int] | Approach | None:
    """The pair's first event after a free instant: the rest of its piece, then whole pieces."""
    path = searcher.path
    piece = int(path.piece_at(np.array([time_ps + 1]))[0])
    stop = int(path.bounds_ps[piece + 1])
    end = int(np.searchsorted(path.bounds_ps, span.end_ps))
    rest = Roots(*(np.array([v]) for v in (piece, -1, time_ps, stop)))
    outcome = searcher.search_stretches(rest, pair)
    near = np.full(len(searcher.scene.pairs), outcome.near.max())
    near[np.arange(len(near)) != pair] = NO_CONTACT
    event = event_of(searcher, replace(outcome, near=near), span.end_ps)
    for first, last in searcher.chunks(piece + 1, end):
        if event is not None:
            break
        event = event_of(searcher, searcher.search_pieces(first, last), span.end_ps)
    return event


def _lasting(searcher: Searcher, span: Span, pair: int, sample: int) -> tuple[int, int, int | None]:
    """First and last instant in contact from a sample on, and the free instant that follows."""
    start = end = -1
    period = searcher.settings.period_ps
    rest = replace(span, start_ps=max(span.start_ps, (sample - 1) * period + 1))
    for instants in _growing(searcher, rest):
        touches = touches_at(searcher, instants, pair)
        if start < 0:
            begin = int(np.argmax(touches))
            start = end = int(instants.time_ps[begin])
            touches[:begin] = True
        free = np.flatnonzero(~touches)
        if len(free):
            end = int(instants.time_ps[free[0] - 1]) if free[0] else end
            return start, end, int(instants.time_ps[free[0]])
        end = int(instants.time_ps[-1])
    return start, end, None


def _growing(searcher: Searcher, span: Span) -> Iterator[Instants]:
    """Yield the instants of a span in windows that grow; a long dwell is passed over."""
    path, period = searcher.path, searcher.settings.period_ps
    count, start = FIRST_WINDOW, span.start_ps
    while start <= span.end_ps:
        for first in windows(path, replace(span, start_ps=start), count, period):
            instants = window(path, replace(span, start_ps=start), first, count, period)
            start = (first + count - 1) * period + 1
            if len(instants):
                yield instants
            break
        else:
            return
        count = min(2 * count, LAST_WINDOW)

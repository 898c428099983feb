"""Contact intervals: every stretch of time in which two parts touch, block by block.

Nothing is joined here: parts, blocks and contacts with little time between them stay apart until it
is known which of them somebody has accepted.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from gcodesim.collision.bodies.keys import NO_CONTACT
from gcodesim.collision.bodies.scene import Scene, by_parts
from gcodesim.collision.bounds.forest import build_forest
from gcodesim.collision.search.approach import Approach, InstantDistance, event_of
from gcodesim.collision.search.depths import Depth
from gcodesim.collision.search.first_reach import Limits, first_reached
from gcodesim.collision.search.lasting import touches_at
from gcodesim.collision.search.parting import Parting
from gcodesim.collision.search.search import Roots, Searcher
from gcodesim.motion.samples import Instants, Span, window, windows

FIRST_WINDOW, LAST_WINDOW = 4_096, 262_144
"""Samples looked at together while a contact lasts: at first, and at most."""


@dataclass(frozen=True)
class BlockContact:
    """The part of an interval that lies in one block.

    Attributes:
        start_ps, end_ps: first and last instant in contact.
        depth: the largest depth.
    """

    start_ps: int
    end_ps: int
    depth: Depth


@dataclass(frozen=True)
class Interval:
    """A stretch of time in which one part of each body of a pair touches the other.

    Attributes:
        pair: index in the scene that was asked about.
        scene, own_pair: a scene whose bodies are these parts only, and the index in it.
        start_ps, end_ps: first and last instant in contact.
        between: the smallest distance reached, where it lies between two samples.
        blocks: its blocks; those at the end in which the bodies only part belong to the one before.
    """

    pair: int
    scene: Scene
    own_pair: int
    start_ps: int
    end_ps: int
    between: InstantDistance | None = None
    blocks: tuple[BlockContact, ...] = ()

    @property
    def deepest(self) -> Depth:
        """Its largest depth."""
        return max((block.depth for block in self.blocks), key=lambda depth: depth.deepest)


def contact_intervals(searcher: Searcher, span: Span) -> list[Interval]:
    """All contact intervals of all parts of all pairs within a span, in the order of time."""
    found: list[Interval] = []
    for pair in _near_pairs(searcher, span):
        of_parts = _by_parts(searcher, pair)
        several = len(of_parts.scene.pairs) > 1
        near = _near_pairs(of_parts, span) if several else [0]
        if not near:
            continue
        gauge = Parting(of_parts, near)
        for row, own_pair in enumerate(near):
            own = list(_intervals_of(_only(of_parts, own_pair), span, own_pair))
            found += [replace(i, pair=pair) for i in _in_blocks(of_parts, gauge, row, span, own)]
    return sorted(found, key=lambda i: (i.start_ps, i.pair, i.own_pair))


def _near_pairs(searcher: Searcher, span: Span) -> list[int]:
    """The pairs that come so near in a span that a touch of theirs cannot be excluded."""
    first, end = np.searchsorted(searcher.path.bounds_ps, [span.start_ps, span.end_ps]).tolist()
    limits = Limits(searcher.settings.free_mm)
    return list(first_reached(searcher, limits, first, end, NO_CONTACT))


def _by_parts(searcher: Searcher, pair: int) -> Searcher:
    """A searcher for a scene of all parts of a pair, each with each part of the other body."""
    scene = by_parts(searcher.scene, pair, searcher.joints)
    free = (searcher.settings.free_mm[pair],) * len(scene.pairs)
    settings = replace(searcher.settings, free_mm=free)
    forest = build_forest(scene, searcher.joints)
    return replace(searcher, scene=scene, forest=forest, settings=settings)


def _only(searcher: Searcher, pair: int) -> Searcher:
    free = tuple(f if i == pair else -1.0 for i, f in enumerate(searcher.settings.free_mm))
    return replace(searcher, settings=replace(searcher.settings, free_mm=free))


def _intervals_of(searcher: Searcher, span: Span, pair: int) -> Iterator[Interval]:
    time: int | None = span.start_ps
    last: Interval | None = None
    while time is not None and time < span.end_ps:
        event = _event_after(searcher, span, pair, time)
        if isinstance(event, Approach):
            ends = event.start_ps, event.end_ps
            if last and event.start_ps <= time + searcher.settings.period_ps:
                # On its way out of a touch a pair is within the tolerance for a moment.
                last = replace(last, end_ps=event.end_ps)
            else:
                yield from [last] if last else []
                last = Interval(pair, searcher.scene, pair, *ends, between=event.nearest)
            time = event.end_ps
            continue
        yield from [last] if last else []
        if event is None:
            return
        start, end, time = _lasting(searcher, span, pair, event[0])
        last = Interval(pair, searcher.scene, pair, start, end)
    yield from [last] if last else []


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


def _in_blocks(
    searcher: Searcher, gauge: Parting, row: int, span: Span, intervals: list[Interval]
) -> Iterator[Interval]:
    """Yield intervals of one pair with their blocks, each with its depth; `row` counts as gauge."""
    ends: list[list[tuple[int, int]]] = []
    for interval in intervals:
        stretches = list(_stretches(searcher, span, interval.start_ps, interval.end_ps))
        if interval.between:
            stretches = []
        # The way out of a contact is no contact of its own.
        while len(stretches) > 1 and gauge.parting(row, interval.start_ps, *stretches[-1]):
            stretches.pop()
        ends.append(stretches or [(interval.start_ps, interval.start_ps)])
    depths = iter(gauge.depth_gauge.deepest(row, [pair for own in ends for pair in own]))
    for interval, stretches in zip(intervals, ends, strict=True):
        untils = [*(end for _, end in stretches[:-1]), interval.end_ps]
        blocks = [
            BlockContact(start, until, next(depths))
            for (start, _), until in zip(stretches, untils, strict=True)
        ]
        yield replace(interval, blocks=tuple(blocks))


def _stretches(
    searcher: Searcher, span: Span, start_ps: int, end_ps: int
) -> Iterator[tuple[int, int]]:
    """Yield the stretches of a contact by the block they lie in; the start of a span is its own."""
    path = searcher.path
    if start_ps == span.start_ps:
        yield start_ps, start_ps
        if start_ps == end_ps:
            return
    ends = np.array([start_ps + (start_ps == span.start_ps), end_ps])
    first, last = path.piece_at(ends).tolist()
    pieces = np.arange(first, last + 1)
    if searcher.stretches is not None:
        pieces = pieces[searcher.stretches.wanted[pieces]]
    cuts = np.flatnonzero(np.diff(path.line[pieces])) + 1
    for run in np.split(pieces, cuts):
        if len(run):
            start, end = path.bounds_ps[[run[0], run[-1] + 1]].tolist()
            yield max(start_ps, start), min(end_ps, end)

"""Limits: the first time a pair is closer than its limit, which may depend on the time.

Every chunk of the path is searched with the largest limit of each pair in it. Only where a pair
comes that near is it looked at again, in windows with limits of their own; what these leave is
halved, each half with the largest limit over it, until that is the limit of the sample step in
which the pair comes to it. A stretch of time is thus always proved free of the largest limit over
it, and what is found does not depend on how the path was cut.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gcodesim.collision.bodies.keys import NO_CONTACT
from gcodesim.collision.bounds.departure import Departures
from gcodesim.collision.search.approach import first_instant
from gcodesim.collision.search.search import Outcome, Roots, Searcher
from gcodesim.collision.search.search_kernel import MODE_APPROACH

LEFT_OUT = -1.0
"""Free distance [mm] that tells the kernel to leave a pair out; plus slack it stays negative."""

BATCH = 64
"""Stretches looked at at once, the earliest first: those after the answer are wasted work."""

Times = NDArray[np.int64]


@dataclass(frozen=True)
class Limits:
    """Distances that pairs must keep, over time.

    Attributes:
        asked: per pair [mm]; LEFT_OUT = not looked at.
        departures: what is added to them, over time.
    """

    asked: tuple[float, ...]
    departures: Departures | None = None

    def over(self, pair: int, start_ps: Times, end_ps: Times) -> NDArray[np.float64]:
        """The largest limit of a pair in each of some stretches of time, shape (m,) [mm]."""
        if self.departures is None:
            return np.full(len(start_ps), self.asked[pair])
        return self.asked[pair] + self.departures.over(pair, start_ps, end_ps)

    def largest(self, pairs: Iterable[int], start_ps: int, end_ps: int) -> tuple[float, ...]:
        """The largest limit in one stretch of time of some pairs, LEFT_OUT of the others."""
        largest = [LEFT_OUT] * len(self.asked)
        times = np.array([start_ps]), np.array([end_ps])
        for pair in pairs:
            largest[pair] = float(self.over(pair, *times)[0])
        return tuple(largest)


@dataclass(frozen=True)
class Reach:
    """When a pair first comes to its limit, the limit and the departure in it then [mm]."""

    time_ps: int
    limit: float
    departure: float


def first_reached(
    searcher: Searcher, limits: Limits, first: int, end: int, best: int
) -> dict[int, Reach]:
    """The pairs that come to their limit within the pieces first..end, and when they first do.

    Args:
        searcher: with the scene and path.
        limits: what the pairs must keep.
        first: first piece.
        end: end of the pieces.
        best: key of the first contact; later times do not count.
    """
    bounds = searcher.path.bounds_ps
    waiting = [pair for pair, asked in enumerate(limits.asked) if asked >= 0.0]
    found: dict[int, Reach] = {}
    for start, stop in searcher.chunks(first, end):
        largest = limits.largest(waiting, int(bounds[start]), int(bounds[stop]))
        finder = _approaching(searcher, largest)
        near = finder.search_pieces(start, stop, Outcome.nothing(len(largest), best)).near
        for pair in [pair for pair in waiting if near[pair] < NO_CONTACT]:
            step = int(near[pair]), largest[pair]
            if limits.departures is not None and limits.departures.varies(pair):
                step = _first_step(finder, limits, pair, (step[0], stop), best)
            if step[0] < NO_CONTACT:
                found[pair] = _reach(searcher, limits, pair, *step)
                waiting.remove(pair)
        if not waiting:
            break
    return dict(sorted(found.items()))


def roots_reached(searcher: Searcher, roots: Roots, pair: int, best: int) -> NDArray[np.bool_]:
    """Whether a pair comes to the limits of some roots in the order of time, shape (m,)."""
    finder = _approaching(searcher, searcher.settings.free_mm)
    motion = finder.motion(int(roots.piece[0]), int(roots.piece[-1]) + 1)
    none = np.full(len(roots.piece), np.inf)
    return np.asarray(finder.settle(roots, motion, best, none, pair).near < NO_CONTACT)


def _approaching(searcher: Searcher, free_mm: tuple[float, ...]) -> Searcher:
    settings = replace(searcher.settings, mode=MODE_APPROACH, free_mm=free_mm)
    return replace(searcher, settings=settings)


def _reach(searcher: Searcher, limits: Limits, pair: int, near_ps: int, limit: float) -> Reach:
    """The instant within a sample step at which a pair comes to the limit of the step."""
    finder = _approaching(searcher, (limit,) * len(limits.asked))
    step_end = int(_step_ends(searcher, np.array([near_ps]))[0])
    time_ps = first_instant(finder, pair, near_ps, step_end)
    return Reach(time_ps, limit, limit - limits.asked[pair])


def _step_ends(searcher: Searcher, near_ps: Times) -> Times:
    """Ends of the sample steps that begin at some times."""
    path, period = searcher.path, searcher.settings.period_ps
    piece_ends = path.bounds_ps[path.piece_at(near_ps + 1) + 1]
    return np.minimum((near_ps // period + 1) * period, piece_ends)


def _first_step(
    finder: Searcher, limits: Limits, pair: int, stretch: tuple[int, int], best: int
) -> tuple[int, float]:
    """Start [ps] of the first sample step in which a pair comes to its limit, and that limit.

    Args:
        finder: a searcher for approaches.
        limits: what the pairs must keep.
        pair: the pair.
        stretch: a time before which it keeps them [ps], and the end of the pieces to search.
        best: see first_reached.

    Returns:
        NO_CONTACT and nothing where the pair keeps its limit.
    """
    path, (from_ps, stop) = finder.path, stretch
    roots, motion = finder.windows(int(path.piece_at(np.array([from_ps + 1]))[0]), stop)
    first, limit = NO_CONTACT, 0.0
    while len(roots.piece):
        some, rest = roots.part(slice(BATCH)), roots.part(slice(BATCH, None))
        low, high = _ends(some, path.bounds_ps, stop)
        allowed = limits.over(pair, low, high)
        none = np.full(len(low), np.inf)
        near = finder.settle(replace(some, free_mm=allowed), motion, best, none, pair).near
        hit = np.flatnonzero(near < first)
        here = limits.over(pair, near[hit], _step_ends(finder, near[hit])) if len(hit) else none[:0]
        # Where the limit of the step is that of the whole stretch, nothing is left to find out.
        sure, left = hit[allowed[hit] <= here], hit[allowed[hit] > here]
        if len(sure):
            earliest = sure[np.argmin(near[sure])]
            first, limit = int(near[earliest]), float(allowed[earliest])
            rest = rest.part(slice(0))
        left = left[near[left] < first]
        roots = _halved(some.part(left), near[left], stop, finder).followed_by(rest)
    return first, limit


def _ends(roots: Roots, bounds_ps: Times, stop: int) -> tuple[Times, Times]:
    """Starts and ends of roots in time [ps]; pieces from `stop` on do not belong to them."""
    run = roots.level >= 0
    after = np.minimum(roots.piece + (1 << np.maximum(roots.level, 0)), stop)
    low = np.where(run, bounds_ps[roots.piece], roots.start_ps)
    return low, np.where(run, bounds_ps[after], roots.end_ps)


def _halved(roots: Roots, near_ps: Times, stop: int, finder: Searcher) -> Roots:
    """The halves of some roots in the order of time, without what ends by the times given."""
    bounds, period = finder.path.bounds_ps, finder.settings.period_ps
    low, high = _ends(roots, bounds, stop)
    run = roots.level > 0
    half = np.where(run, 1 << np.maximum(roots.level - 1, 0), 0)
    low = np.where(run, 0, np.maximum(low, near_ps))
    # Parts of a piece are cut at samples only, so that they begin and end with a sample step.
    cut = np.maximum((low + high) // 2 // period, low // period + 1) * period
    cut = np.where(run, 0, np.minimum(cut, high))
    halves = Roots(
        np.concatenate([roots.piece, roots.piece + half]).astype(np.int32),
        np.tile(np.where(run, roots.level - 1, -1), 2).astype(np.int32),
        np.concatenate([low, cut]),
        np.where(np.tile(run, 2), 0, np.concatenate([cut, high])),
    )
    inside = np.flatnonzero(halves.piece < stop)
    halves, until = halves.part(inside), np.tile(near_ps, 2)[inside]
    low, high = _ends(halves, bounds, stop)
    left = np.flatnonzero((high > until) & (high > low))
    return halves.part(left[np.argsort(low[left])])

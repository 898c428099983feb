"""Near misses between samples: what leads into a contact, or a contact of its own.

The search marks the first sample step in which two bodies come within the tolerance and no sample
touches. From there this module walks on, step by step. A touch at the end of the same near stretch
is an ordinary contact, found as such; a stretch that ends without one is a contact between samples.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gcodesim.collision.bodies.keys import NO_CONTACT, contact_key, sample_and_pair
from gcodesim.collision.instants.contact import halfway
from gcodesim.collision.instants.posed_pair import PosedPair, pose_pair
from gcodesim.collision.search.search import Outcome, Roots, Searcher
from gcodesim.collision.search.search_kernel import MODE_APPROACH, MODE_AT_SAMPLES, MODE_MINIMUM
from gcodesim.constants import SLACK_MM
from gcodesim.motion.lag import GOLDEN
from gcodesim.motion.samples import sample_of

STEPS, GROWTH, MOST_STEPS = 4, 4, 65_536
"""Sample steps looked at per launch along a near stretch: at first, times this each, at most. Most
stretches lead to a touch within a step or two."""

REFINEMENTS, SCANS = 24, 17
"""Instants scanned along a near stretch, and golden-section steps around the best of them."""

HALVINGS = 27
"""Halvings that find when the tolerance is first reached: 1e-6 of a sample step."""


@dataclass(frozen=True)
class InstantDistance:
    """The smallest distance of a pair at one instant.

    Attributes:
        distance: [mm]; 0 when the bodies touch.
        numbers: triangle numbers in the whole shapes of a and b.
        point: halfway between the nearest points [mm], in the frame of body a's link, shape (3,).
    """

    time_ps: int
    pair: int
    distance: float
    numbers: tuple[int, int]
    point: NDArray[np.float64]


@dataclass(frozen=True)
class Approach:
    """A near stretch without a touch at a sample.

    Attributes:
        start_ps: when the distance first falls to the tolerance.
        end_ps: end of the last near sample step.
        nearest: the smallest distance reached, and when.
    """

    start_ps: int
    end_ps: int
    nearest: InstantDistance


def distances_at(searcher: Searcher, pair: int, times_ps: NDArray[np.int64]) -> NDArray[np.float64]:
    """Distance of a pair that does not touch at some instants, to 5e-7 mm from above, (n,) [mm].

    Where it touches, the distance of any two of its triangles.
    """
    free = (0.0,) * len(searcher.scene.pairs)
    settings = replace(searcher.settings, mode=MODE_MINIMUM, free_mm=free)
    pieces = searcher.path.piece_at(times_ps)
    roots = Roots(pieces, np.full(len(pieces), -1, np.int32), times_ps, times_ps)
    return replace(searcher, settings=settings).search_stretches(roots, pair).distance


def nearest_at(searcher: Searcher, pair: int, time_ps: int) -> InstantDistance:
    """Smallest distance of a pair at one instant, and where."""
    posed, (distance, i, j) = _nearest_rows(searcher, pair, time_ps)
    point = halfway(*posed.triangles(i, j))
    return InstantDistance(time_ps, pair, distance, posed.numbers(i, j), point)


def _nearest_rows(
    searcher: Searcher, pair: int, time_ps: int
) -> tuple[PosedPair, tuple[float, int, int]]:
    times = np.array([time_ps])
    within = float(distances_at(searcher, pair, times)[0]) + SLACK_MM
    piece = int(searcher.path.piece_at(times)[0])
    posed = pose_pair(searcher.scene, searcher.arrays, pair, piece, time_ps)
    return posed, posed.nearest(within)


def contact_between(
    searcher: Searcher, pair: int, start_ps: int, end_ps: int, touch: int | None = None
) -> Approach | None:
    """What happens in a near stretch that begins at `start_ps`; None when it leads to a touch.

    Args:
        searcher: with the scene and path.
        pair: the pair.
        start_ps: start of the first near sample step.
        end_ps: end of the time to look at.
        touch: sample of the first touch of this pair, where it is known.
    """
    first_end = start_ps
    for times in _steps(searcher, start_ps, end_ps):
        if first_end == start_ps:
            first_end = int(times[1])
        free = _touching_step(searcher, pair, times, touch)
        near = 0
        if free:
            steps = _look(searcher, pair, times[: free + 1], MODE_APPROACH).near < NO_CONTACT
            near = int(np.argmin(np.append(steps, False)))
        if near < free:
            end_ps = int(times[near])
            break
        if free < len(times) - 1:
            return None
    begin = first_instant(searcher, pair, start_ps, first_end)
    end_ps = max(end_ps, first_end)
    return Approach(begin, end_ps, _nearest_in(searcher, pair, begin, end_ps))


def _look(searcher: Searcher, pair: int, times: NDArray[np.int64], mode: int) -> Outcome:
    """Search the stretches between neighbouring times, each within one piece."""
    settings = replace(searcher.settings, mode=mode)
    if mode == MODE_AT_SAMPLES:
        settings = replace(settings, free_mm=(0.0,) * len(settings.free_mm))
    pieces = searcher.path.piece_at(times[1:])
    roots = Roots(pieces, np.full(len(pieces), -1, np.int32), times[:-1], times[1:])
    return replace(searcher, settings=settings).search_stretches(roots, pair)


def _touching_step(
    searcher: Searcher, pair: int, times: NDArray[np.int64], touch: int | None
) -> int:
    """Number of the first step at an end of which the pair touches, that of all steps if none."""
    samples = -(-times[1:] // searcher.settings.period_ps)
    if touch is not None:
        first, end = np.searchsorted(samples, touch + np.arange(2)).tolist()
        if end - first == 1 or first == len(samples):
            return first
    pieces = searcher.path.piece_at(times[1:])
    within_pieces = [0, *(np.flatnonzero(np.diff(pieces)) + 1), len(pieces)]
    found = _look(searcher, pair, times[within_pieces], MODE_AT_SAMPLES)
    if found.best == NO_CONTACT:
        return len(pieces)
    touched, _ = sample_and_pair(found.best)
    first, end = np.searchsorted(samples, touched + np.arange(2)).tolist()

    def touches_by(step: int) -> bool:
        until = _look(searcher, pair, times[first : step + 2], MODE_AT_SAMPLES)
        return until.best < NO_CONTACT

    # A sample has many steps where many blocks end within it; if no other touches, the last does.
    return first + bisect_left(range(first, end - 1), True, key=touches_by)


def _steps(searcher: Searcher, start_ps: int, end_ps: int) -> Iterator[NDArray[np.int64]]:
    """Yield runs of times of consecutive instants; two neighbours lie within one piece.

    A piece that stands still is one step. Runs grow, so that a long stretch takes few launches.
    """
    path, period, steps = searcher.path, searcher.settings.period_ps, STEPS
    still = (path.arc < 0) & (path.q0 == path.q1).all(axis=1)
    while start_ps < end_ps:
        piece = int(path.piece_at(np.array([start_ps + 1]))[0])
        stop = start_ps + steps * period
        stop = min(end_ps, max(stop, int(path.bounds_ps[piece + 1])) if still[piece] else stop)
        samples = np.arange(start_ps // period + 1, stop // period + 1, dtype=np.int64) * period
        inside = path.bounds_ps[(path.bounds_ps > start_ps) & (path.bounds_ps < stop)]
        samples = samples[~still[path.piece_at(samples)]]
        yield np.unique(np.concatenate([[start_ps, stop], samples, inside]))
        start_ps, steps = stop, min(GROWTH * steps, MOST_STEPS)


def first_instant(searcher: Searcher, pair: int, start_ps: int, end_ps: int) -> int:
    """First time within a near sample step at which the distance is down to the tolerance [ps]."""
    for _ in range(HALVINGS):
        middle = (start_ps + end_ps) // 2
        if middle in (start_ps, end_ps):
            break
        outcome = _look(searcher, pair, np.array([start_ps, middle]), MODE_APPROACH)
        if outcome.near[0] < NO_CONTACT:
            end_ps = middle
        else:
            start_ps = middle
    return end_ps


def _nearest_in(searcher: Searcher, pair: int, start_ps: int, end_ps: int) -> InstantDistance:
    """The smallest distance within a near stretch: a coarse scan, then golden section."""
    seen: dict[int, float] = {}

    def distance(time: float) -> float:
        instant = round(time)
        if instant not in seen:
            seen[instant] = _nearest_rows(searcher, pair, instant)[1][0]
        return seen[instant]

    times = np.unique(np.linspace(start_ps, end_ps, SCANS).astype(np.int64)).tolist()
    best = min(range(len(times)), key=lambda i: distance(times[i]))
    low, high = float(times[max(best - 1, 0)]), float(times[min(best + 1, len(times) - 1)])
    for _ in range(REFINEMENTS):
        if min(seen.values()) == 0.0:
            break
        left, right = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
        if distance(left) <= distance(right):
            high = right
        else:
            low = left
    return nearest_at(searcher, pair, min(seen, key=lambda time: (seen[time], time)))


def first_event(
    searcher: Searcher, first: int, end: int, end_ps: int
) -> tuple[Outcome, tuple[int, int] | Approach | None]:
    """Search the pieces first..end: a touch (sample, pair), a contact between samples, or None.

    Args:
        searcher: with the scene and path.
        first: first piece of the run to search.
        end: end of that run.
        end_ps: how far a near stretch may be followed, the end of the span.
    """
    outcome = searcher.search_pieces(first, end)
    return outcome, event_of(searcher, outcome, end_ps)


def event_of(
    searcher: Searcher, outcome: Outcome, end_ps: int
) -> tuple[int, int] | Approach | None:
    """The first event of a search of all pairs, by sample and pair.

    Near stretches are followed up to `end_ps`, beyond a touch of another pair too: where they lead
    to a touch of their own, they are no event.
    """
    period = searcher.settings.period_ps
    keys = contact_key(np.minimum(outcome.near, end_ps) // period + 1, np.arange(len(outcome.near)))
    sample, touching = sample_and_pair(outcome.best)
    between = [
        contact_between(
            searcher,
            int(pair),
            int(outcome.near[pair]),
            searcher.until(int(outcome.near[pair]), end_ps),
            sample if pair == touching else None,
        )
        for pair in np.flatnonzero((outcome.near < end_ps) & (keys < outcome.best))
    ]
    found = [approach for approach in between if approach]
    if found:
        return min(found, key=lambda f: (sample_of(f.start_ps, period), f.nearest.pair))
    if outcome.best == NO_CONTACT:
        return None
    return sample, touching

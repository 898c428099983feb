"""Clearances: where a pair comes nearer than it may, and how near each pair ever comes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gcodesim.collision.exhaustive import NO_CONTACT
from gcodesim.collision.near import first_instant
from gcodesim.collision.search import Outcome, Roots, Searcher
from gcodesim.collision.search_kernel import MODE_APPROACH, MODE_MINIMUM

LEFT_OUT = -1.0
"""Free distance [mm] that tells the kernel to leave a pair out; plus slack it stays negative."""

SEEDS = 256
"""Instants whose distances bound the minimum from above before the search for it begins."""

FOUND_AGAIN_MM = 1.0e-6
"""The instant of the smallest distance is where the pair first comes within this of it [mm]."""


@dataclass(frozen=True)
class Nearness:
    """A pair at its nearest, or where it first comes nearer than it may.

    Attributes:
        pair: index in the scene.
        distance: smallest distance of the whole stretch searched [mm].
        time_ps: when the pair first comes to `limit`.
        limit: distance asked for, or the smallest distance itself [mm].
        departure: how much of the limit stands for a machine that leaves the path [mm].
    """

    pair: int
    distance: float
    time_ps: int
    limit: float
    departure: float = 0.0


def too_near(
    searcher: Searcher, clearances: list[float], first: int, end: int, best: int
) -> list[Nearness]:
    """Pairs that come nearer than their clearance within the pieces first..end.

    Args:
        searcher: with the scene and path.
        clearances: per pair [mm]; 0 = none asked for.
        first: first piece.
        end: end of the pieces.
        best: key of the first contact; what lies behind it does not count.
    """
    wanted = tuple(c if c > 0.0 else LEFT_OUT for c in clearances)
    if max(wanted) < 0.0:
        return []
    starts = _first_steps(searcher, wanted, first, end, best)
    reached = [pair for pair, start in starts.items() if start is not None]
    distances = smallest_distances(searcher, reached, first, end, best)
    return [
        Nearness(pair, distances[pair], starts[pair] or 0, clearances[pair]) for pair in reached
    ]


def nearest_of_all(searcher: Searcher, first: int, end: int, best: int) -> list[Nearness]:
    """The smallest distance of every pair within the pieces first..end, and when."""
    pairs = list(range(len(searcher.scene.pairs)))
    distances = smallest_distances(searcher, pairs, first, end, best)
    limits = tuple(distances[pair] + FOUND_AGAIN_MM for pair in pairs)
    starts = _first_steps(searcher, limits, first, end, best)
    return [Nearness(pair, distances[pair], starts[pair] or 0, distances[pair]) for pair in pairs]


def smallest_distances(
    searcher: Searcher, pairs: list[int], first: int, end: int, best: int
) -> dict[int, float]:
    """Smallest distance [mm] of some pairs over the pieces first..end, to 5e-7 mm from above."""
    free = tuple(0.0 if p in pairs else LEFT_OUT for p in range(len(searcher.scene.pairs)))
    if not pairs:
        return {}
    settings = replace(searcher.settings, mode=MODE_MINIMUM, free_mm=free)
    finder = replace(searcher, settings=settings)
    outcome = Outcome.nothing(len(searcher.scene.pairs), best)
    path = searcher.path
    low, high = float(path.bounds_ps[first]), float(path.bounds_ps[end])
    times = np.unique(np.linspace(low, high, SEEDS).astype(np.int64))[1:-1]
    pieces = path.piece_at(times)
    for start, stop in searcher.chunks(first, end):
        inside = (pieces >= start) & (pieces < stop)
        if inside.any():
            seeds = Roots(
                pieces[inside], np.full(inside.sum(), -1, np.int32), times[inside], times[inside]
            )
            motion = finder.motion(start, stop)
            outcome.merge(finder.launch(seeds, motion, best, outcome.distance))
    for start, stop in searcher.chunks(first, end):
        outcome = finder.search_pieces(start, stop, outcome)
    return {pair: float(outcome.distance[pair]) for pair in pairs}


def _first_steps(
    searcher: Searcher, limits: tuple[float, ...], first: int, end: int, best: int
) -> dict[int, int | None]:
    """Per pair the first time [ps] at which its distance falls to its limit; None = never."""
    settings = replace(searcher.settings, mode=MODE_APPROACH, free_mm=limits)
    finder = replace(searcher, settings=settings)
    outcome = Outcome.nothing(len(limits), best)
    for start, stop in searcher.chunks(first, end):
        outcome = finder.search_pieces(start, stop, outcome)
    times: dict[int, int | None] = {}
    for pair, near in enumerate(outcome.near.tolist()):
        times[pair] = None
        if near < NO_CONTACT:
            period = searcher.settings.period_ps
            piece = int(searcher.path.piece_at(np.array([near + 1]))[0])
            step_end = min((near // period + 1) * period, int(searcher.path.bounds_ps[piece + 1]))
            times[pair] = first_instant(finder, pair, near, step_end)
    return times

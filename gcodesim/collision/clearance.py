"""Clearances: where a pair comes nearer than it may, and how near each pair ever comes."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gcodesim.collision.departure import Departures
from gcodesim.collision.limits import LEFT_OUT, Limits, first_reached
from gcodesim.collision.search import Outcome, Roots, Searcher
from gcodesim.collision.search_kernel import MODE_MINIMUM
from gcodesim.motion.path import Path

SEEDS = 64
"""Instants whose distances bound the minimum from above before the search for it begins."""

FOUND_AGAIN_MM, FOUND_AGAIN_PART = 1.0e-6, 1.0e-3
"""The time of the smallest distance is when the pair first comes within this [mm] and this part of
it: where a pair stays at one distance for long, finer costs ten times as much."""


@dataclass(frozen=True)
class Nearness:
    """A pair at its nearest, or where it first comes nearer than it may.

    Attributes:
        pair: index in the scene.
        distance: smallest distance [mm] of the whole stretch searched; where the departure depends
            on time, of the rest of the block.
        time_ps: when the pair first comes to `limit`.
        limit: distance asked for then, or the smallest distance itself [mm].
        departure: how much of the limit stands for a machine that leaves the path [mm].
        touch: the departure alone is as large as the distance.
    """

    pair: int
    distance: float
    time_ps: int
    limit: float
    departure: float = 0.0
    touch: bool = False


def too_near(
    searcher: Searcher,
    clearances: tuple[float, ...],
    departures: Departures,
    first: int,
    end: int,
    best: int,
) -> list[Nearness]:
    """Pairs that come nearer than their clearance within the pieces first..end.

    A machine that may be off its path by some distance must keep that much more.

    Args:
        searcher: with the scene and path.
        clearances: per pair [mm]; LEFT_OUT = not to be looked at.
        departures: how far the pairs may be off the path.
        first: first piece.
        end: end of the pieces.
        best: key of the first contact; what lies behind it does not count.
    """
    off = departures.largest.tolist()
    looked_at = [c >= 0.0 and c + d > 0.0 for c, d in zip(clearances, off, strict=True)]
    wanted = tuple(c if look else LEFT_OUT for c, look in zip(clearances, looked_at, strict=True))
    if not any(looked_at):
        return []
    reached = first_reached(searcher, Limits(wanted, departures), first, end, best)
    steady = [pair for pair in reached if not departures.varies(pair)]
    distances = smallest_distances(searcher, steady, first, end, best)
    # That a touch is not excluded weighs more than a clearance that is lost earlier.
    late = [pair for pair in reached if pair not in steady and wanted[pair] > 0.0]
    alone = Limits(tuple(0.0 if p in late else LEFT_OUT for p in range(len(wanted))), departures)
    touching = first_reached(searcher, alone, first, end, best) if late else {}
    found = []
    for pair, reach in (reached | touching).items():
        touch = pair in touching or wanted[pair] == 0.0
        if pair in steady:
            distance = distances[pair]
            touch = touch or distance <= off[pair]
        else:
            block = _rest_of_block(searcher.path, reach.time_ps, end)
            distance = smallest_distances(searcher, [pair], *block, best)[pair]
        found.append(Nearness(pair, distance, reach.time_ps, reach.limit, reach.departure, touch))
    return found


def _rest_of_block(path: Path, time_ps: int, end: int) -> tuple[int, int]:
    """Pieces from a time on, before `end`, that belong to the block in force."""
    piece = int(path.piece_at(np.array([time_ps]))[0])
    others = np.flatnonzero(path.line[piece:end] != path.line[piece])
    return piece, piece + int(others[0]) if len(others) else end


def nearest_of_all(searcher: Searcher, first: int, end: int, best: int) -> list[Nearness]:
    """The smallest distance of every pair within the pieces first..end, and when."""
    pairs = list(range(len(searcher.scene.pairs)))
    distances = smallest_distances(searcher, pairs, first, end, best)
    limits = tuple(distances[pair] * (1.0 + FOUND_AGAIN_PART) + FOUND_AGAIN_MM for pair in pairs)
    reached = first_reached(searcher, Limits(limits), first, end, best)
    times = [reached[pair].time_ps if pair in reached else 0 for pair in pairs]
    return [Nearness(pair, distances[pair], times[pair], distances[pair]) for pair in pairs]


def smallest_distances(
    searcher: Searcher, pairs: list[int], first: int, end: int, best: int
) -> dict[int, float]:
    """Smallest distance [mm] of some pairs over the pieces first..end, from above.

    It is known to 5e-7 mm or a thousandth of it, whichever is more.
    """
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

"""Clearances: where a pair comes closer than its clearance, and how close each pair ever comes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gcodesim.collision.bodies.keys import NO_CONTACT, contact_key
from gcodesim.collision.bounds.departure import Departures
from gcodesim.collision.search.first_reach import LEFT_OUT, Limits, first_reached, roots_reached
from gcodesim.collision.search.intervals import Interval
from gcodesim.collision.search.search import Outcome, Roots, Searcher
from gcodesim.collision.search.search_kernel import MODE_MINIMUM
from gcodesim.constants import FOUND_AGAIN_MM, MINIMUM_KNOWN_PART
from gcodesim.motion.path import Path
from gcodesim.motion.samples import sample_of

SEEDS = 64
"""Instants whose distances bound the minimum from above before the search for it begins."""


@dataclass(frozen=True)
class Nearness:
    """A pair at its closest, or where it first comes closer than its limit.

    Attributes:
        pair: index in the scene.
        distance: smallest distance [mm] of the whole stretch searched; where the departure depends
            on time, of the rest of the block.
        time_ps: when the pair first comes to `limit`.
        limit: distance asked for then, or the smallest distance itself [mm].
        departure: how much of the limit allows for a machine that leaves the path [mm].
        touch: the departure alone is as large as the distance.
        end_ps: end of the stretch searched.
        continues: it goes on from the one before it, in another block.
        in_block: the smallest distance in the first block of a place of several blocks [mm].
    """

    pair: int
    distance: float
    time_ps: int
    limit: float
    departure: float = 0.0
    touch: bool = False
    end_ps: int = 0
    continues: bool = False
    in_block: float | None = None


def every_place(
    searcher: Searcher,
    clearances: tuple[float, ...],
    departures: Departures,
    pieces: tuple[int, int],
    contacts: Sequence[Interval],
) -> list[Nearness]:
    """Every place where a pair comes nearer than its clearance, block by block.

    A place is a run of pieces that come too near, and do so where one ends and the next begins. On
    its way into a contact and out of it a pair is too near anyway: that is no place. The rest of
    the piece in which a contact ends is not looked at.

    Args:
        searcher: with the scene and path.
        clearances: per pair [mm]; LEFT_OUT = not to be looked at.
        departures: how far the pairs may be off the path.
        pieces: first piece, and end of the pieces.
        contacts: all contacts on these pieces.
    """
    found: list[Nearness] = []
    for pair, clearance in enumerate(clearances):
        if clearance < 0.0 or clearance + departures.largest[pair] <= 0.0:
            continue
        only = tuple(c if p == pair else LEFT_OUT for p, c in enumerate(clearances))
        for stretch in _free_stretches(searcher, pieces, pair, _touching(contacts, pair)):
            for place in _places(searcher, Limits(only, departures), pair, stretch):
                found += _place(searcher, (only, departures, stretch.best), place)
    # The blocks of a place stay together.
    return found


def _place(
    searcher: Searcher, limits: tuple[tuple[float, ...], Departures, int], place: tuple[int, int]
) -> list[Nearness]:
    """The place as a whole, with the distance in its first block, then its other blocks."""
    clearances, departures, best = limits
    found = too_near(searcher, clearances, departures, *place, best)
    blocks = list(_blocks(searcher.path, *place))
    if len(blocks) == 1 or not found:
        return found
    near = [n for b in blocks for n in too_near(searcher, clearances, departures, *b, best)]
    begin = [replace(found[0], in_block=near[0].distance)] if near else found
    return begin + [replace(later, continues=True) for later in near[1:]]


def _blocks(path: Path, first: int, end: int) -> Iterator[tuple[int, int]]:
    """Yield first piece and end of every block among the pieces first..end."""
    cuts = np.flatnonzero(np.diff(path.line[first:end])) + first + 1
    yield from pairwise([first, *cuts.tolist(), end])


class FreeSpan(NamedTuple):
    """Pieces first..end up to the key `best`; `after` a contact, or from where they may start."""

    first: int
    end: int
    best: int
    after: bool


def _touching(contacts: Sequence[Interval], pair: int) -> list[tuple[int, int]]:
    """When any parts of a pair touch, from and until [ps]."""
    joined: list[tuple[int, int]] = []
    for contact in sorted((c for c in contacts if c.pair == pair), key=lambda c: c.start_ps):
        start, end = contact.start_ps, contact.end_ps
        if joined and start <= joined[-1][1]:
            start, end = joined[-1][0], max(end, joined.pop()[1])
        joined.append((start, end))
    return joined


def _free_stretches(
    searcher: Searcher, pieces: tuple[int, int], pair: int, contacts: Sequence[tuple[int, int]]
) -> Iterator[FreeSpan]:
    """Yield the stretches between the contacts of one pair."""
    path, (first, end), after = searcher.path, pieces, False
    for start_ps, end_ps in contacts:
        # Up to the last sample before the contact: nothing can be proved about what touches.
        sample = sample_of(start_ps, searcher.settings.period_ps) - 1
        last, back = path.piece_at(np.array([start_ps, end_ps + 1])).tolist()
        if first < end and start_ps > path.bounds_ps[first]:
            yield FreeSpan(first, min(last + 1, end), contact_key(sample, pair), after)
        first, after = back + 1, True
    if first < end:
        yield FreeSpan(first, end, NO_CONTACT, after)


def _places(
    searcher: Searcher, limits: Limits, pair: int, stretch: FreeSpan
) -> Iterator[tuple[int, int]]:
    """Yield the places of a pair in a stretch, without the one on its way out of a contact."""
    bounds, best = searcher.path.bounds_ps, stretch.best
    reached = first_reached(searcher, limits, stretch.first, stretch.end, best).get(pair)
    if reached is None:
        return
    near = [np.zeros(0, np.int32)]
    for start, stop in searcher.chunks(stretch.first, stretch.end):
        pieces = np.arange(start, stop, dtype=np.int32)
        level, none = np.zeros_like(pieces), np.zeros(len(pieces), np.int64)
        roots = Roots(pieces, level, none, none, limits.over(pair, *bounds[[pieces, pieces + 1]]))
        near.append(pieces[roots_reached(searcher, roots, pair, best)])
    hit = np.concatenate(near)
    follows = np.flatnonzero(np.diff(hit) == 1)
    joined = np.zeros(max(len(hit) - 1, 0), bool)
    if len(follows):
        ends = bounds[hit[follows] + 1]
        level, allowed = np.full(len(ends), -1, np.int32), limits.over(pair, ends - 1, ends)
        roots = Roots(hit[follows], level, ends - 1, ends, allowed)
        joined[follows] = roots_reached(searcher, roots, pair, best)
    leaving = stretch.after and reached.time_ps <= bounds[stretch.first]
    for number, run in enumerate(np.split(hit, np.flatnonzero(~joined) + 1) if len(hit) else ()):
        if number or not leaving:
            yield int(run[0]), int(run[-1]) + 1


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
        best: key of the first contact; later times do not count.
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
        # The smallest distance is known to a part of it only, but the limit is reached for sure.
        distance = min(distance, reach.limit)
        place = reach.time_ps, reach.limit, reach.departure, touch
        found.append(Nearness(pair, distance, *place, int(searcher.path.bounds_ps[end])))
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
    limits = tuple(distances[pair] * (1.0 + MINIMUM_KNOWN_PART) + FOUND_AGAIN_MM for pair in pairs)
    reached = first_reached(searcher, Limits(limits), first, end, best)
    times = [reached[pair].time_ps if pair in reached else 0 for pair in pairs]
    return [Nearness(pair, distances[pair], times[pair], distances[pair]) for pair in pairs]


def nearest_pair(searcher: Searcher, first: int, end: int, best: int) -> Nearness:
    """The pair that comes nearest within the pieces first..end, its distance, and when."""
    count = len(searcher.scene.pairs)
    settings = replace(
        searcher.settings,
        mode=MODE_MINIMUM,
        free_mm=(0.0,) * count,
        part=MINIMUM_KNOWN_PART,
        together=True,
    )
    distances = _smallest(replace(searcher, settings=settings), first, end, best)[:count]
    pair = int(np.argmin(distances))
    distance = float(distances[pair])
    limit = distance * (1.0 + MINIMUM_KNOWN_PART) + FOUND_AGAIN_MM
    limits = Limits(tuple(limit if p == pair else LEFT_OUT for p in range(count)))
    reached = first_reached(searcher, limits, first, end, best)
    return Nearness(pair, distance, reached[pair].time_ps if pair in reached else 0, distance)


def smallest_distances(
    searcher: Searcher, pairs: list[int], first: int, end: int, best: int
) -> dict[int, float]:
    """Smallest distance [mm] of some pairs over the pieces first..end, from above.

    It is known to 5e-7 mm or a thousandth of it, whichever is more.
    """
    free = tuple(0.0 if p in pairs else LEFT_OUT for p in range(len(searcher.scene.pairs)))
    if not pairs:
        return {}
    settings = replace(searcher.settings, mode=MODE_MINIMUM, free_mm=free, part=MINIMUM_KNOWN_PART)
    distances = _smallest(replace(searcher, settings=settings), first, end, best)
    return {pair: float(distances[pair]) for pair in pairs}


def _smallest(finder: Searcher, first: int, end: int, best: int) -> NDArray[np.float64]:
    """Smallest distance of every slot over the pieces first..end [mm]."""
    path, slots = finder.path, len(finder.scene.pairs) + finder.settings.together
    outcome = Outcome.nothing(slots, best)
    low, high = float(path.bounds_ps[first]), float(path.bounds_ps[end])
    times = np.unique(np.linspace(low, high, SEEDS).astype(np.int64))[1:-1]
    pieces = path.piece_at(times)
    for start, stop in finder.chunks(first, end):
        inside = (pieces >= start) & (pieces < stop)
        if inside.any():
            seeds = Roots(
                pieces[inside], np.full(inside.sum(), -1, np.int32), times[inside], times[inside]
            )
            motion = finder.motion(start, stop)
            outcome.merge(finder.launch(seeds, motion, best, outcome.distance))
    for start, stop in finder.chunks(first, end):
        outcome = finder.search_pieces(start, stop, outcome)
    return outcome.distance

"""Stretches: phases of speed cut at the ends of the moves they run over, with laws of their own."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gcodesim.constants import PS_PER_S
from gcodesim.motion.ramps import Phases, time_law

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

VANISHING_S = 0.5 / PS_PER_S
"""Phases below this time would round to none: their way is left to the next one of their move."""

BISECTIONS = 60
"""Halvings that find when a phase passes the end of a move: below 1e-17 of the phase."""


class Stretches(NamedTuple):
    """n stretches in order: their move, its fractions from and to, time [s] and law, (n, 3)."""

    move: Indices
    start: Floats
    end: Floats
    seconds: Floats
    law: Floats


def stretches(ramps: Phases, length: Floats, unit: Indices, move_length: Floats) -> Stretches:
    """The phases of units of moves as stretches of single moves, without gaps.

    Args:
        ramps: phases of each unit, (units, k).
        length: of the units, shape (units,) [mm].
        unit: number of the unit of each move, never falling, shape (moves,).
        move_length: of the moves, shape (moves,) [mm].
    """
    shape = ramps.seconds.shape
    owner = np.repeat(np.arange(shape[0]), shape[1])
    kept = _lasting(owner, ramps.seconds.ravel())
    owner, seconds = owner[kept], ramps.seconds.ravel()[kept]
    law = time_law(ramps.shape.ravel()[kept], ramps.u.ravel()[kept], ramps.w.ravel()[kept])
    ends = np.minimum(np.cumsum(ramps.length, axis=1), length[:, None]).ravel()[kept]
    last = np.append(np.diff(owner) > 0, True)
    ends = np.where(last, length[owner], ends)
    begins = _previous(owner, ends)
    first_move = np.flatnonzero(np.diff(unit, prepend=-1))
    way = length[owner]
    whole = Stretches(first_move[owner], begins / way, ends / way, seconds, law)
    if len(unit) == len(length):
        return whole
    # Most units are one move, whose phases are its stretches as they are.
    shared = np.diff(first_move, append=len(unit)) > 1
    number = np.cumsum(shared) - 1
    moves, parted = np.flatnonzero(shared[unit]), shared[owner]
    cut = _cut(
        number[owner[parted]],
        begins[parted],
        ends[parted],
        seconds[parted],
        law[parted],
        number[unit[moves]],
        move_length[moves],
    )
    cut = cut._replace(move=moves[cut.move])
    both = [np.concatenate([x[~parted], y]) for x, y in zip(whole, cut, strict=True)]
    order = np.argsort(both[0], kind="stable")
    return Stretches(*(column[order] for column in both))


def _lasting(owner: Indices, seconds: Floats) -> Indices:
    """Which phases stay: those that last, and the longest of each owner."""
    first = np.flatnonzero(np.diff(owner, prepend=-1))
    longest = np.maximum.reduceat(seconds, first)[np.cumsum(np.diff(owner, prepend=-1) > 0) - 1]
    return np.flatnonzero((seconds >= VANISHING_S) | (seconds == longest))


def _previous(owner: Indices, ends: Floats) -> Floats:
    """Where each entry begins: the end of the one before it, 0 for the first of its owner."""
    begins = np.append(0.0, ends[:-1])
    begins[np.diff(owner, prepend=-1) > 0] = 0.0
    return begins


def _cut(
    owner: Indices,
    begins: Floats,
    ends: Floats,
    seconds: Floats,
    law: Floats,
    unit: Indices,
    move_length: Floats,
) -> Stretches:
    """Cut phases (see `stretches`) where a move of their unit ends."""
    first_move = np.flatnonzero(np.diff(unit, prepend=-1))
    total = np.cumsum(move_length)
    passed = total - np.append(0.0, total)[first_move][unit]
    inner = np.flatnonzero(np.diff(unit) == 0)
    # In the order of the path; a move's end before the phase's where both are the same.
    units = np.concatenate([unit[inner], owner])
    place = np.concatenate([passed[inner], ends])
    is_phase = np.concatenate([np.zeros(len(inner), bool), np.ones(len(owner), bool)])
    order = np.lexsort((is_phase, place, units))
    units, place, is_phase = units[order], place[order], is_phase[order]
    phase = np.cumsum(is_phase) - is_phase
    # The last move of a unit ends with its last phase.
    ends_move = ~is_phase | np.append(np.diff(units) > 0, True)
    move = np.cumsum(ends_move) - ends_move
    place = np.minimum(place, ends[phase])
    tau_end = np.ones(len(place))
    inside = np.flatnonzero(~is_phase)
    at = phase[inside]
    tau_end[inside] = _tau(law[at], begins[at], ends[at], place[inside])
    fresh = np.append(True, is_phase[:-1])
    tau_start = np.where(fresh, 0.0, np.append(0.0, tau_end[:-1]))
    tau_end = np.maximum(tau_end, tau_start)
    time = (tau_end - tau_start) * seconds[phase]
    kept = _lasting(move, time)
    move, phase = move[kept], phase[kept]
    offset = np.append(0.0, passed[:-1])
    offset[first_move] = 0.0
    fraction = np.clip((place[kept] - offset[move]) / move_length[move], 0.0, 1.0)
    fraction = np.where(np.append(np.diff(move) > 0, True), 1.0, fraction)
    part = _restricted(law[phase], tau_start[kept], tau_end[kept])
    return Stretches(move, _previous(move, fraction), fraction, time[kept], part)


def _tau(law: Floats, begin: Floats, end: Floats, place: Floats) -> Floats:
    """When a law that never falls passes a place between its begin and end, as fraction of time."""
    share = np.divide(place - begin, end - begin, out=np.ones_like(place), where=end > begin)
    tau = np.clip(share, 0.0, 1.0)
    # At constant speed the way is the time.
    bent = np.flatnonzero(law[:, 1:].any(axis=1))
    share, (c1, c2, c3) = share[bent], law[bent].T
    low, high = np.zeros(len(share)), np.ones(len(share))
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        before = middle * (c1 + middle * (c2 + middle * c3)) < share
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    tau[bent] = high
    return tau


def _restricted(law: Floats, start: Floats, end: Floats) -> Floats:
    """The law on a part of its time, scaled to 0..1; constant speed where rounding rules."""
    c1, c2, c3 = law.T
    h = end - start
    way = c1 + c2 * (start + end) + c3 * (start * start + start * end + end * end)
    scale = np.divide(1.0, way, out=np.zeros_like(way), where=way > 0.0)
    first = (c1 + start * (2.0 * c2 + 3.0 * start * c3)) * scale
    third = c3 * h * h * scale
    part = np.stack([first, 1.0 - first - third, third], axis=1)
    final = first + 2.0 * part[:, 1] + 3.0 * third
    wrong = (first < 0.0) | (final < 0.0) | (scale == 0.0) | (first > 3.0)
    part[wrong] = (1.0, 0.0, 0.0)
    return np.where((h >= 1.0)[:, None], law, part)

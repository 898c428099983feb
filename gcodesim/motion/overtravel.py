"""Overtravel: where a path leaves the travel of a joint, exactly, inside lines and arcs too."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gcodesim.constants import LEAST_BEND_MM, PS_PER_S, SPIRAL_PART, TRAVEL_SLACK
from gcodesim.findings.codes import Finding
from gcodesim.machine.model import Joint
from gcodesim.motion.path import Path, path_fraction

AXES = "XYZABCUVW"
"""Order in which a control shows its axes."""

BISECTIONS = 60
"""Halvings that locate the instant of crossing: below 1e-17 of the piece."""

EXTREMES_PER_END = 3
"""Half turns looked at from either end of an arc: more turns repeat the same extremes, or lie
between these on a helix or spiral, which grows steadily."""

AT_ONCE = 50_000
"""Fractions that are found side by side: their arrays stay in the cache."""

SPIRAL_STEPS = 12
"""Stretches of a half turn that are searched for a change of sign each."""

NEWTON_STEPS_TO_EXTREME = 4
"""Steps to an extreme; they converge as squares, from no farther than SPIRAL_PART."""


def overtravels(path: Path, joints: tuple[Joint, ...]) -> list[Finding]:
    """Findings per joint and excursion (GC301 linear, GC302 rotary), in the order of time.

    An excursion is a run of consecutive pieces that exceed the same limit; it has a finding for
    each block. Its time is the first crossing, its value the farthest position there. The tolerance
    is TRAVEL_SLACK.
    """
    found: list[list[Finding]] = []
    for column, joint in enumerate(joints):
        if not len(path) or not np.isfinite([joint.lower, joint.upper]).any():
            continue
        low, high = position_ranges(path, column)
        for beyond, limit, sign in (
            (high - joint.upper, joint.upper, 1.0),
            (joint.lower - low, joint.lower, -1.0),
        ):
            for run in _runs(beyond > TRAVEL_SLACK):
                found.append(_excursion(path, joint, column, run, (limit, sign), beyond))
    found.sort(key=lambda blocks: (blocks[0].time_s or 0.0, blocks[0].message))
    return [finding for blocks in found for finding in blocks]


def _excursion(
    path: Path,
    joint: Joint,
    column: int,
    run: NDArray[np.intp],
    side: tuple[float, float],
    beyond: NDArray[np.float64],
) -> list[Finding]:
    """The findings of one excursion, one per block.

    Args:
        path: the path.
        joint: what leaves its travel.
        column: of the joint.
        run: its pieces.
        side: the limit, and 1 for the upper, -1 for the lower one.
        beyond: per piece of the path, how far beyond the limit.
    """
    limit, sign = side
    found: list[Finding] = []
    for block in np.split(run, np.flatnonzero(np.diff(path.line[run])) + 1):
        # The first one tells of all of them.
        told, depth = (block if found else run), float(beyond[block].max())
        value = limit + sign * float(beyond[told].max())
        finding = _finding(path, joint, column, told, limit, sign, value)
        found.append(replace(finding, depth=depth, continues=bool(found)))
    return found


def position_ranges(path: Path, column: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Lowest and highest position of one joint on every piece, shape (n,) each [mm or deg]."""
    q0, q1 = path.q0[:, column], path.q1[:, column]
    low, high = np.minimum(q0, q1), np.maximum(q0, q1)
    if column in path.xyz:
        pieces = np.flatnonzero(path.arc >= 0)
        for s in _arc_extremes(path, pieces, path.xyz.index(column)):
            q = path.positions_on(pieces, s)[:, column]
            low[pieces] = np.minimum(low[pieces], q)
            high[pieces] = np.maximum(high[pieces], q)
    return low, high


def _arc_extremes(path: Path, pieces: NDArray[np.intp], axis: int) -> Iterator[NDArray[np.float64]]:
    """Path fractions at which one coordinate of the arcs may be extreme, a few per arc.

    Angles where the circle's tangent is perpendicular to the axis, then Newton steps on the
    derivative, which shifts them where the radius grows or the arc climbs. Spirals whose radius
    changes much are searched for changes of sign instead.
    """
    arcs = path.arcs[path.arc[pieces]]
    if not len(arcs):
        return
    sweep, grown = np.radians(arcs["sweep"]), np.abs(arcs["r1"] - arcs["r0"])
    base = np.arctan2(arcs["v"][:, axis], arcs["u"][:, axis])
    half_turns = np.abs(sweep) / np.pi
    steps = np.arange(-1, EXTREMES_PER_END + 1)
    from_end = np.ceil(half_turns) + steps[:, None] - 2.0
    turns = np.concatenate([np.broadcast_to(steps[:, None], from_end.shape), from_end])
    at_once = max(1, AT_ONCE // len(arcs))
    for first in range(0, len(turns), at_once):
        s = (base + np.sign(sweep) * np.pi * turns[first : first + at_once]) / sweep
        for _ in range(NEWTON_STEPS_TO_EXTREME):
            slope, bend = _slopes(arcs, axis, s)
            s = s - np.divide(slope, bend, out=np.zeros_like(s), where=np.abs(bend) > LEAST_BEND_MM)
        yield from np.clip(s, 0.0, 1.0)
    spiral = np.flatnonzero(grown > SPIRAL_PART * np.maximum(arcs["r0"], arcs["r1"]))
    for found in _spiral_extremes(arcs[spiral], axis) if len(spiral) else ():
        s = np.zeros(len(arcs))
        s[spiral] = found
        yield s


def _spiral_extremes(arcs: NDArray[np.void], axis: int) -> Iterator[NDArray[np.float64]]:
    """Changes of sign of the derivative in the first and last turns, bisected."""
    steps = np.arange(2 * EXTREMES_PER_END * SPIRAL_STEPS) / (SPIRAL_STEPS * EXTREMES_PER_END)
    share = np.minimum(EXTREMES_PER_END * 180.0 / np.abs(arcs["sweep"]), 0.5)
    for step in steps:
        low = share * step if step < 1.0 else 1.0 - share * (2.0 - step)
        high = low + share / (SPIRAL_STEPS * EXTREMES_PER_END)
        rising = _slopes(arcs, axis, low)[0] > 0.0
        if ((_slopes(arcs, axis, high)[0] > 0.0) == rising).all():
            continue
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            same = (_slopes(arcs, axis, middle)[0] > 0.0) == rising
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        yield np.clip(high, 0.0, 1.0)


def _slopes(
    arcs: NDArray[np.void], axis: int, s: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """First and second derivative of a coordinate of the arcs at fractions `s`, (n,) or (m, n)."""
    u, v, lift = arcs["u"][:, axis], arcs["v"][:, axis], arcs["lift"][:, axis]
    sweep, grown = np.radians(arcs["sweep"]), arcs["r1"] - arcs["r0"]
    angle, radius = sweep * s, arcs["r0"] + grown * s
    c, d = np.cos(angle), np.sin(angle)
    slope = grown * (c * u + d * v) + radius * sweep * (c * v - d * u) + lift
    bend = 2.0 * grown * sweep * (c * v - d * u) - radius * sweep**2 * (c * u + d * v)
    return slope, bend


def _runs(flags: NDArray[np.bool_]) -> list[NDArray[np.intp]]:
    """Runs of consecutive true entries, as index arrays."""
    hits = np.flatnonzero(flags)
    return np.split(hits, np.flatnonzero(np.diff(hits) > 1) + 1) if len(hits) else []


def _finding(
    path: Path,
    joint: Joint,
    column: int,
    run: NDArray[np.intp],
    limit: float,
    sign: float,
    value: float,
) -> Finding:
    unit = "deg" if joint.rotary else "mm"
    first, last = int(path.line[run[0]]), int(path.line[run[-1]])
    until = f" (until line {last})" if last != first else ""
    time_ps = _crossing_ps(path, column, int(run[0]), limit, sign)
    positions = path.positions(np.array([time_ps]))[0]
    named = sorted(
        zip(path.joints, positions, strict=True), key=lambda item: (AXES + item[0]).index(item[0])
    )
    places = (f"{name} {q + 0.0:.4f}" for name, q in named)
    message = (
        f"{joint.name} reaches {value:.6g} {unit}, {abs(value - limit):.4g} {unit} beyond its "
        f"travel of {joint.lower:g} to {joint.upper:g}{until}; it leaves it at "
        f"{time_ps / PS_PER_S:.6f} s, at {' '.join(places)} (machine coordinates)"
    )
    return Finding(
        "GC302" if joint.rotary else "GC301",
        message,
        "overtravel",
        line=first,
        time_s=time_ps / PS_PER_S,
    )


def _crossing_ps(path: Path, column: int, piece: int, limit: float, sign: float) -> int:
    """First time at which the joint passes the limit inside a piece [ps].

    Between neighbouring extremes the position is monotone, so bisection finds the one crossing,
    under any time law.
    """
    start, end = int(path.bounds_ps[piece]), int(path.bounds_ps[piece + 1])
    fractions = [np.array([0.0, 1.0])]
    if path.arc[piece] >= 0 and column in path.xyz:
        fractions += _arc_extremes(path, np.array([piece]), path.xyz.index(column))

    def is_beyond(s: NDArray[np.float64]) -> NDArray[np.bool_]:
        position = path.positions_on(np.full(len(s), piece), s)[:, column]
        return np.asarray(sign * (position - limit) > TRAVEL_SLACK)

    ordered = np.unique(np.concatenate(fractions))
    beyond = is_beyond(ordered)
    if beyond[0] or not beyond.any():
        return start
    after = int(np.argmax(beyond))
    low, high = start, end
    for _ in range(BISECTIONS):
        middle = (low + high) // 2
        s = path_fraction(path.law[[piece]], np.array([(middle - start) / (end - start)]))
        if is_beyond(np.clip(s, ordered[after - 1], ordered[after]))[0]:
            high = middle
        else:
            low = middle
    return high

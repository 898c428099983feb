"""Knots: few instants between which the joints may be drawn as running straight in time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gcodesim.constants import PS_PER_S
from gcodesim.motion.path import Path

Floats = NDArray[np.float64]

STRETCH = 1024
"""Instants thinned out together: bounds the passes, and costs one knot in so many at most."""


@dataclass(frozen=True)
class Knots:
    """The joints over time, straight from knot to knot.

    Attributes:
        time_s: ascending from 0, shape (n,) [s].
        positions: shape (n, joints) [mm or deg].
        tolerance: no joint is farther than this from the path at any time [mm or deg].
    """

    time_s: Floats
    positions: Floats
    tolerance: float


def reduced(path: Path, tolerance: float, most: int) -> Knots:
    """Knots of a path that has at least one piece.

    Args:
        path: what is reduced.
        tolerance: largest deviation [mm or deg]; doubled until `most` is kept.
        most: largest number of knots.
    """
    while True:
        times = _instants(path, tolerance / 2.0)
        positions = path.positions(times)
        kept = _corners(times / PS_PER_S, positions, tolerance / 2.0)
        if len(kept) <= most:
            return Knots(times[kept] / PS_PER_S, positions[kept], tolerance)
        tolerance *= 2.0


def _instants(path: Path, tolerance: float) -> NDArray[np.int64]:
    """Ends of the pieces, and so many instants inside that chords stay within the tolerance.

    A chord over the part h of a piece leaves a curve q(tau) by h^2/8 max |q''| at most. With the
    time law s(tau), q'' = q_ss s'^2 + q_s s''.
    """
    c1, c2, c3 = np.abs(path.law.T)
    speed, change = c1 + 2.0 * c2 + 3.0 * c3, 2.0 * c2 + 6.0 * c3
    first = np.abs(path.q1 - path.q0).max(axis=1, initial=0.0)
    second = np.zeros(len(path))
    on_arc = np.flatnonzero(path.arc >= 0)
    arcs = path.arcs[path.arc[on_arc]]
    angle, grown = np.abs(np.radians(arcs["sweep"])), np.abs(arcs["r1"] - arcs["r0"])
    radius = np.maximum(arcs["r0"], arcs["r1"])
    rise = np.linalg.norm(arcs["lift"], axis=1)
    first[on_arc] = np.maximum(first[on_arc], radius * angle + grown + rise)
    second[on_arc] = radius * angle**2 + 2.0 * grown * angle
    bend = second * speed**2 + first * change
    steps = np.maximum(np.ceil(np.sqrt(bend / (8.0 * tolerance))), 1.0).astype(np.int64)
    piece = np.repeat(np.arange(len(path)), steps)
    number = np.arange(len(piece)) - np.repeat(np.cumsum(steps) - steps, steps)
    long = path.bounds_ps[piece + 1] - path.bounds_ps[piece]
    inside = path.bounds_ps[piece] + np.rint(long * (number / steps[piece])).astype(np.int64)
    return np.unique(np.append(inside, path.duration_ps))


def _corners(time: Floats, q: Floats, tolerance: float) -> NDArray[np.int64]:
    """Rows to keep so that straight lines between them pass all others within the tolerance.

    Douglas and Peucker, 1973, with the distance taken at equal times; all stretches that are still
    to be split are looked at in one pass.
    """
    kept = np.unique(np.append(np.arange(0, len(time), STRETCH), len(time) - 1))
    first, last = kept[:-1], kept[1:]
    while True:
        wide = last - first > 1
        first, last = first[wide], last[wide]
        if not len(first):
            return np.sort(kept)
        inner = last - first - 1
        stretch = np.repeat(np.arange(len(first)), inner)
        begin = np.cumsum(inner) - inner
        row = np.arange(len(stretch)) - begin[stretch] + first[stretch] + 1
        a, b = first[stretch], last[stretch]
        share = (time[row] - time[a]) / (time[b] - time[a])
        off = np.abs(q[row] - q[a] - share[:, None] * (q[b] - q[a])).max(axis=1)
        worst = np.maximum.reduceat(off, begin)
        split = np.flatnonzero(worst > tolerance)
        is_worst = np.flatnonzero(off == worst[stretch])
        _, place = np.unique(stretch[is_worst], return_index=True)
        middle = row[is_worst[place]][split]
        kept = np.append(kept, middle)
        first, last = (
            np.concatenate([first[split], middle]),
            np.concatenate([middle, last[split]]),
        )

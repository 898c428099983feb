"""Lag over time: how far every joint may stay behind its command at each time of the program.

The lag e of servo.py is e(t) = int_0^t h(t - x) u'(x) dx, h the lag after a step of the command.

Lemma. |h(t)| <= K exp(-a t), where, with w = 1/time constant and the damping z,

    order 1:           K = 1,            a = w                                  (equality)
    order 2, z < 1:    K = 1/sqrt(1 - z^2),   a = z w
    order 2, z > 1:    K = p/(p - q),    a = q,   p, q = w (z + sqrt(z^2 - 1)), w^2/p
    order 2:           K = exp(-g)/(1 - g),   a = g b,  b = z w for z < 1, q otherwise

with the golden section g = (sqrt(5) - 1)/2.

Proof. z < 1: h = exp(-z w t) (cos kt + z w sin(kt)/k), k = w sqrt(1 - z^2), whose bracket is a
cosine of amplitude 1/sqrt(1 - z^2), and at most 1 + z w t. z > 1: h = (p exp(-q t) - q exp(-p t))
/(p - q) > 0 drops its second term, and is exp(-q t) (1 + q (1 - exp(-(p - q) t))/(p - q)), at most
exp(-q t) (1 + q t); z = 1 is the limit of both. (1 + x) exp((g - 1) x) is largest where
1 + x = 1/(1 - g), where it is exp(-g)/(1 - g); g makes that over g least. Of the pairs (K, a) that
hold for a drive, the one with the smaller K/a is taken.  QED

Theorem. Let |u'| <= V(t), and E' = K V - a E with E(0) = 0. Then at every time |e| <= E, and on a
stretch [r, s] on which V <= V1 and whose way is W = int V,

    E <= E(r) + min(max(K V1/a - E(r), 0) (1 - exp(-a (s - r))), K W).

Proof. E(t) = int_0^t K exp(-a (t - x)) V(x) dx >= int |h(t - x)| |u'(x)| dx. With V1 for V, E would
go from E(r) towards K V1/a as exp(-a (t - r)) falls from 1, and E' <= K V.  QED

A piece has the speed V = V1 g(x) with the slope g of its time law, largest 1: E is carried over it
exactly, by the phi functions of servo.py, whose terms are all of one sign but for those of the law.
After the program E only falls. Both E and the bound of servo.py for the whole path hold, so their
minimum does. At a steady speed E is K/(a N) times what it must be: 1 for order 1, up to pi/2 for
order 2.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, sqrt

import numpy as np
from numpy.typing import NDArray

from gcodesim.constants import PS_PER_S
from gcodesim.machine.model import Machine, Servo
from gcodesim.motion.path import Path
from gcodesim.motion.servo import CHUNK, exponentials, lag_gain
from gcodesim.motion.speeds import largest_slope, piece_speeds

Floats = NDArray[np.float64]
Times = NDArray[np.int64]

GOLDEN = (sqrt(5.0) - 1.0) / 2.0
"""The golden section."""

LAG_ROUNDED_UP = 1.0 + 1e-9
"""Covers the rounding of E over 1e6 pieces, a few ulp each, at the cost of as much."""

COEFFICIENT_UP = 1e-12
"""Share by which each term of a time law is raised: terms of a law may cancel in the sum."""


@dataclass(frozen=True)
class Lag:
    """Bounds of the lag of the joints with a servo, over time.

    Attributes:
        bounds_ps: ends of the pieces of the path [ps], shape (n + 1,).
        slope: of the time laws in tau = 0..1, as fractions of the largest: coefficients of
            1, tau, tau^2, shape (n, 3).
        columns: k joints of the path that lag.
        envelopes: their K and a of the theorem.
        speed: largest speed of each joint on each piece, shape (n, k) [mm/s or deg/s].
        start: E at the ends of the pieces, shape (n + 1, k) [mm or deg].
        largest: bound of E on each piece, shape (n + 1, k); the last row, of no piece, is 0.
        whole: bound of the whole path, shape (k,).
    """

    bounds_ps: Times
    slope: Floats
    columns: NDArray[np.intp]
    envelopes: tuple[tuple[float, float], ...]
    speed: Floats
    start: Floats
    largest: Floats
    whole: Floats

    def over(self, start_ps: Times, end_ps: Times) -> Floats:
        """Bounds that hold all through some stretches of time, shape (m, k) [mm or deg].

        Of the piece in which a stretch begins its own part counts, of the later ones all.

        Args:
            start_ps: starts of the stretches, shape (m,), from 0.
            end_ps: their ends, shape (m,), later than the starts, to the end of the path.
        """
        first = np.searchsorted(self.bounds_ps, start_ps, side="right") - 1
        last = np.searchsorted(self.bounds_ps, end_ps, side="left") - 1
        bound = self._on_parts(first, start_ps, np.minimum(end_ps, self.bounds_ps[first + 1]))
        # Bounds of the pieces after the first; reduceat takes one row where there is none.
        lowest, cuts = int(first.min()), np.stack([first + 1, last + 1], axis=1).ravel()
        rows = self.largest[lowest : last.max() + 2]
        later = np.maximum.reduceat(rows, cuts - lowest)[::2]
        bound = np.where((last > first)[:, None], np.maximum(bound, later), bound)
        return np.minimum(bound * LAG_ROUNDED_UP, self.whole)

    def usual(self) -> Floats:
        """Bounds that are enough for half of the program time, shape (k,) [mm or deg]."""
        order = np.argsort(self.largest[:-1], axis=0)
        passed = np.cumsum(np.diff(self.bounds_ps)[order], axis=0)
        half = np.argmax(2 * passed >= self.bounds_ps[-1], axis=0)
        joints = np.arange(len(self.columns))
        return np.minimum(self.largest[order[half, joints], joints] * LAG_ROUNDED_UP, self.whole)

    def _on_parts(self, piece: NDArray[np.intp], start_ps: Times, end_ps: Times) -> Floats:
        """Bound of E on parts of single pieces, shape (m, k)."""
        begin, slope = self.bounds_ps[piece], self.slope[piece]
        ticks = self.bounds_ps[piece + 1] - begin
        r, s = ((time - begin) / ticks for time in (start_ps, end_ps))
        elapsed, lasting = r * (ticks / PS_PER_S), (s - r) * (ticks / PS_PER_S)
        steepest = _largest_between(slope, r, s)
        bound = np.empty((len(piece), len(self.columns)))
        for column, (k, a) in enumerate(self.envelopes):
            speed = self.speed[piece, column]
            # A law is cut at r by its coefficients there: tau = r sigma.
            kept, pushed = _carried(a, elapsed, slope * r[:, None] ** [0, 1, 2])
            here = kept * self.start[piece, column] + k * speed * pushed
            push = k * speed * steepest
            bound[:, column] = _most(here, push / a, a * lasting, push * lasting)
        return np.minimum(bound, self.largest[piece])


def lag_over_time(path: Path, machine: Machine) -> Lag | None:
    """The bounds of a path; None without motion, or where no joint has a servo."""
    servos = [(column, joint.servo) for column, joint in enumerate(machine.joints)]
    lagging = [(column, servo) for column, servo in servos if servo is not None]
    if not len(path) or not lagging:
        return None
    columns = np.array([column for column, _ in lagging])
    envelopes = tuple(envelope(servo) for _, servo in lagging)
    seconds, steepest = np.diff(path.bounds_ps) / PS_PER_S, largest_slope(path.law)
    slope = path.law * [1.0, 2.0, 3.0] / steepest[:, None]
    speed = piece_speeds(path)[:, columns]
    start = np.empty((len(path) + 1, len(columns)))
    largest = np.zeros_like(start)
    carried: dict[float, tuple[Floats, Floats]] = {}
    for column, (k, a) in enumerate(envelopes):
        kept, pushed = carried.setdefault(a, _carried(a, seconds, slope))
        start[:, column] = scanned(kept, k * speed[:, column] * pushed)
        push = k * speed[:, column]
        largest[:-1, column] = _most(
            start[:-1, column], push / a, a * seconds, push * seconds / steepest
        )
    whole = [lag_gain(servo) * v for (_, servo), v in zip(lagging, speed.max(axis=0), strict=True)]
    return Lag(path.bounds_ps, slope, columns, envelopes, speed, start, largest, np.array(whole))


def envelope(servo: Servo) -> tuple[float, float]:
    """K and a of the lemma for a drive."""
    w, z = 1.0 / servo.time_constant, servo.damping
    if servo.order == 1:
        return 1.0, w
    root = sqrt(abs((1.0 - z) * (1.0 + z)))
    slow = z * w if z < 1.0 else w / (z + root)
    choices = [(exp(-GOLDEN) / (1.0 - GOLDEN), GOLDEN * slow)]
    if root > 0.0:
        choices.append((1.0 / root if z < 1.0 else (z + root) / (2.0 * root), slow))
    return min(choices, key=lambda choice: choice[0] / choice[1])


def scanned(kept: Floats, pushed: Floats) -> Floats:
    """x[i + 1] = kept[i] x[i] + pushed[i] from x[0] = 0, shape (n + 1,); nothing is negative.

    In about sqrt(n) blocks side by side, then joined: what a block passes on is linear in what it
    is given.
    """
    n = len(kept)
    side = max(1, round(n**0.5))
    blocks = -(-n // side)
    padded = np.zeros((2, blocks * side))
    padded[:, :n] = kept, pushed
    keeps, pushes = padded.reshape(2, blocks, side).transpose(0, 2, 1).copy()
    for i in range(1, side):
        pushes[i] += keeps[i] * pushes[i - 1]
        keeps[i] *= keeps[i - 1]
    given = [0.0]
    for keep, push in zip(keeps[-1].tolist(), pushes[-1].tolist(), strict=True):
        given.append(keep * given[-1] + push)
    ends = (keeps * given[:-1] + pushes).T.ravel()
    return np.concatenate([[0.0], ends[:n]])


def _carried(a: float, seconds: Floats, slope: Floats) -> tuple[Floats, Floats]:
    """Of E after some times: the share kept, and what a speed of given slope adds; (n,) each.

    The speed at the fraction sigma of the time is slope . (1, sigma, sigma^2), and what it adds
    sum_i i! t phi_(i+1)(-a t) slope_i, every term rounded up.
    """
    weights = (slope + COEFFICIENT_UP * np.abs(slope)) * [1.0, 1.0, 2.0] * seconds[:, None]
    kept, pushed = np.empty_like(seconds), np.empty_like(seconds)
    for first in range(0, len(seconds), CHUNK):
        cut = slice(first, first + CHUNK)
        keeps, *phi = (of for of, _ in exponentials(a * seconds[cut], None))
        kept[cut] = keeps
        pushed[cut] = sum(weights[cut, i] * phi[i] for i in range(3))
    return kept, pushed


def _most(here: Floats, steady: Floats, decay: Floats, travelled: Floats) -> Floats:
    """The bound of the theorem on a stretch, from E(r), K V1/a, a (s - r) and K W."""
    grown = np.maximum(steady - here, 0.0) * -np.expm1(-decay)
    return np.asarray(here + np.minimum(grown, travelled))


def _largest_between(slope: Floats, r: Floats, s: Floats) -> Floats:
    """Largest value of slopes s0 + s1 tau + s2 tau^2 for tau from r to s, shape (n,)."""
    s0, s1, s2 = slope.T
    turn = np.clip(np.divide(-s1, 2.0 * s2, out=r.copy(), where=s2 != 0.0), r, s)
    return np.asarray(np.max([s0 + tau * (s1 + tau * s2) for tau in (r, s, turn)], axis=0))

"""Servo lag: how far the joints stay behind the path that the control commands, and where they are.

A drive follows its command u(t) with y(t), at rest together at the start. With w = 1/time constant,

    order 1:  y' = w (u - y)                    order 2:  y'' = w^2 (u - y) - 2 z w y'.

Theorem. The lag e = u - y of a command of speed |u'| <= V obeys |e| <= N V, where

    order 1:            N = 1/w
    order 2, z >= 1:    N = 2 z/w
    order 2, z < 1:     N = (2 z + 2 m/(1 - r))/w,   c = sqrt(1 - z^2),
                        r = exp(-pi z/c),  m = exp(-z (arcsin z + pi/2)/c),

and no smaller N holds for every command.

Proof. e is linear in u' and 0 at the start: e(t) = int_0^t h(t - x) u'(x) dx with h the lag after
a step of u, so |e| <= V int |h| = V N, reached in the limit by u' = V sign h(t - x). Order 1:
h = exp(-w t), whose integral is 1/w. Order 2: h'' + 2 z w h' + w^2 h = 0 with h(0) = 1, h'(0) = 0,
so that int_a^b h = (2 z w (h(a) - h(b)) + h'(a) - h'(b))/w^2. For z >= 1, h = (p exp(-q t)
- q exp(-p t))/(p - q) with p > q > 0 is never negative (for p = q in the limit), and the integral
from 0 on is 2 z/w. For z < 1, with k = c w, h' = -(w/c) exp(-z w t) sin(k t), and h vanishes where
k t = arcsin z + pi/2 + n pi, where |h'| = w m r^n. The first stretch contributes (2 z + m)/w, each
later one (m r^n + m r^(n+1))/w, n = 0, 1, ...: in all (2 z + m + m (1 + r)/(1 - r))/w.  QED

The response itself is exact: e is carried from piece to piece by the exponential of the piece and
the phi functions of a polynomial input, which keep their digits for every w dt. Arcs are taken as
cubics that leave them by less than SERVO_ARC_MM.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import asin, exp, factorial, pi, sqrt

import numpy as np
from numpy.typing import NDArray

from gcodesim.constants import PS_PER_S, SERVO_ARC_MM
from gcodesim.machine.model import Machine, Servo
from gcodesim.motion.path import Path, arc_displacement, path_fraction
from gcodesim.motion.speeds import joint_speeds, largest_slope

Floats = NDArray[np.float64]
FloatPair = tuple[Floats, Floats]

TAYLOR_TERMS = 13
"""Terms of the series of a matrix of norm 1/2 at most: the first left out is below 1e-17."""

CHUNK = 1 << 14
"""Times looked at at once: their arrays stay in the cache of a core."""


def servo_deviation(path: Path, machine: Machine) -> Floats:
    """Bound of the lag of every joint anywhere on the path, shape (joints,) [mm or deg]."""
    fastest = joint_speeds(path)
    gains = [lag_gain(joint.servo) for joint in machine.joints]
    return np.array(gains) * fastest


def lag_gain(servo: Servo | None) -> float:
    """N of the theorem: largest lag per speed of the command [s]; 0 without a lag."""
    if servo is None:
        return 0.0
    z = servo.damping
    if servo.order == 1:
        return servo.time_constant
    if z >= 1.0:
        return 2.0 * z * servo.time_constant
    c = sqrt((1.0 - z) * (1.0 + z))
    r, m = exp(-pi * z / c), exp(-z * (asin(z) + pi / 2.0) / c)
    return (2.0 * z + 2.0 * m / (1.0 - r)) * servo.time_constant


def lagged_positions(path: Path, machine: Machine, times: NDArray[np.int64]) -> Floats:
    """Where the joints really are, shape (m, joints) [mm or deg].

    Args:
        path: what the control commands.
        machine: whose joints follow it.
        times: instants [ps] from 0, shape (m,).
    """
    q = path.positions(times)
    if not len(path):
        return q
    for column, joint in enumerate(machine.joints):
        if joint.servo is not None:
            q[:, column] -= lags(commanded(path, column), joint.servo, np.asarray(times))
    return q


@dataclass(frozen=True)
class Command:
    """What one joint is commanded: n cubics one after the other, at rest before and after.

    Attributes:
        bounds_ps: their ends [ps], shape (n + 1,), ascending.
        speed: coefficients of the speed, p0 + p1 x + p2 x^2 at x seconds after the start of each,
            shape (n, 3).
    """

    bounds_ps: NDArray[np.int64]
    speed: Floats


def commanded(path: Path, column: int) -> Command:
    """The command of one joint; arcs cut into cubics that keep SERVO_ARC_MM."""
    ticks = np.diff(path.bounds_ps)
    parts = np.ones(len(path), np.int64)
    if column in path.xyz:
        on_arc = np.flatnonzero(path.arc >= 0)
        parts[on_arc] = np.minimum(_arc_parts(path, on_arc), ticks[on_arc])
    piece = np.repeat(np.arange(len(path)), parts)
    number = np.arange(len(piece)) - np.repeat(np.cumsum(parts) - parts, parts)
    begins = path.bounds_ps[piece] + np.rint(number / parts[piece] * ticks[piece]).astype(np.int64)
    bounds = np.append(begins, path.bounds_ps[-1])
    seconds = (ticks / PS_PER_S)[:, None]
    way = (path.q1 - path.q0)[:, column, None]
    speed = (way * path.law * [1.0, 2.0, 3.0] / seconds ** [1, 2, 3])[piece]
    if column in path.xyz:
        cut = np.flatnonzero(path.arc[piece] >= 0)
        axis = path.xyz.index(column)
        speed[cut] = _hermite(path, axis, piece[cut], bounds[cut], bounds[cut + 1])
    return Command(bounds, speed)


def _arc_parts(path: Path, on_arc: NDArray[np.intp]) -> NDArray[np.int64]:
    """Cubics that each arc needs: a Hermite cubic over 1/n of it errs by |d4u|/(384 n^4).

    With f(s) the arc and s(tau) its law, d4u = f4 s1^4 + 6 f3 s1^2 s2 + f2 (3 s2^2
    + 4 s1 s3), and |fk| <= r D^k + k g D^(k-1) for an angle D, radius r and its growth g.
    """
    arcs, (_, c2, c3) = path.arcs[path.arc[on_arc]], path.law[on_arc].T
    first, second, third = largest_slope(path.law[on_arc]), 2.0 * np.abs(c2), 6.0 * np.abs(c3)
    second = np.maximum(second, np.abs(2.0 * c2 + 6.0 * c3))
    angle = np.radians(np.abs(arcs["sweep"]))
    radius, grown = np.maximum(arcs["r0"], arcs["r1"]), np.abs(arcs["r1"] - arcs["r0"])
    f2, f3, f4 = (radius * angle**k + k * grown * angle ** (k - 1) for k in (2, 3, 4))
    bend = f4 * first**4 + 6.0 * f3 * first**2 * second
    bend += f2 * (3.0 * second**2 + 4.0 * first * third)
    return np.maximum(np.ceil((bend / (384.0 * SERVO_ARC_MM)) ** 0.25), 1.0).astype(np.int64)


def _hermite(
    path: Path,
    axis: int,
    piece: NDArray[np.intp],
    begin_ps: NDArray[np.int64],
    end_ps: NDArray[np.int64],
) -> Floats:
    """Speed coefficients of the cubics with the arcs' positions and speeds at both ends."""
    start, ticks = path.bounds_ps[piece], np.diff(path.bounds_ps)[piece]
    arcs, law = path.arcs[path.arc[piece]], path.law[piece]
    grown = arcs["r1"] - arcs["r0"]
    places, speeds = [], []
    for time in (begin_ps, end_ps):
        tau = (time - start) / ticks
        s = path_fraction(law, tau)
        slope = law[:, 0] + tau * (2.0 * law[:, 1] + 3.0 * tau * law[:, 2])
        angle = np.radians(arcs["sweep"] * s)
        sine, cosine = np.sin(angle), np.cos(angle)
        outward = cosine * arcs["u"][:, axis] + sine * arcs["v"][:, axis]
        across = cosine * arcs["v"][:, axis] - sine * arcs["u"][:, axis]
        turned = (arcs["r0"] + grown * s) * np.radians(arcs["sweep"])
        per_s = grown * outward + turned * across + arcs["lift"][:, axis]
        places.append(arc_displacement(arcs, s)[:, axis])
        speeds.append(per_s * slope * PS_PER_S / ticks)
    h = (end_ps - begin_ps) / PS_PER_S
    mean = (places[1] - places[0]) / h
    p1 = (6.0 * mean - 4.0 * speeds[0] - 2.0 * speeds[1]) / h
    p2 = (3.0 * (speeds[0] + speeds[1]) - 6.0 * mean) / (h * h)
    return np.stack([speeds[0], p1, p2], axis=1)


def lags(command: Command, servo: Servo, times: NDArray[np.int64]) -> Floats:
    """The lag e = u - y of one joint at some instants [ps], shape (m,) [mm or deg]."""
    # After the last cubic the command rests for as long as anybody asks.
    end = max(int(np.max(times, initial=0)), int(command.bounds_ps[-1])) + 1
    bounds = np.append(command.bounds_ps, end)
    speed = np.vstack([command.speed, np.zeros(3)])
    states = _carried(servo, np.diff(bounds) / PS_PER_S, speed)
    found = np.zeros(len(times))
    for first in range(0, len(times), CHUNK):
        some = times[first : first + CHUNK]
        k = np.clip(np.searchsorted(bounds, some, side="left") - 1, 0, len(speed) - 1)
        kept, push = response(servo, (some - bounds[k]) / PS_PER_S, speed[k])
        found[first : first + CHUNK] = kept[0] * states[k, 0] - kept[1] * states[k, 1] + push[0]
    return found


def _carried(servo: Servo, seconds: Floats, speed: Floats) -> Floats:
    """The state (e, f) at the start of every cubic, shape (n, 2): see `response`."""
    damped = 2.0 * servo.damping
    rows = [(0.0, 0.0)]
    e = f = 0.0
    for first in range(0, len(seconds), CHUNK):
        kept, push = response(servo, seconds[first : first + CHUNK], speed[first : first + CHUNK])
        for a, b, more_e, more_f in zip(*(x.tolist() for x in (*kept, *push)), strict=True):
            e, f = a * e - b * f + more_e, b * e + (a - damped * b) * f + more_f
            rows.append((e, f))
    return np.array(rows[:-1])


def response(servo: Servo, seconds: Floats, speed: Floats) -> tuple[FloatPair, FloatPair]:
    """How the state of a drive changes in a time under a command of polynomial speed.

    The state is e, with f = y'/w for order 2. It moves with x' = w B x + (u', 0), so that
    x(t) = exp(w B t) x(0) + sum_k k! t^(k+1) phi_(k+1)(w B t) (p_k, 0), where B = -1, or
    ((0, -1), (1, -2 z)). Every function of such a B is a + b B with two numbers a and b.

    Args:
        servo: the drive.
        seconds: times, shape (n,) [s].
        speed: coefficients of the command's speed, shape (n, 3); see Command.

    Returns:
        a and b of the exponential, shape (n,) each; what the command adds to e and f, likewise.
    """
    of = exponentials(seconds / servo.time_constant, servo.damping if servo.order == 2 else None)
    weights = (speed[:, 0] * seconds, speed[:, 1] * seconds**2, 2.0 * speed[:, 2] * seconds**3)
    e = sum(w * a for w, (a, _) in zip(weights, of[1:], strict=True))
    f = sum(w * b for w, (_, b) in zip(weights, of[1:], strict=True))
    return of[0], (np.asarray(e), np.asarray(f))


def exponentials(x: Floats, damping: float | None) -> list[FloatPair]:
    """exp(x B), phi_1, phi_2 and phi_3 as pairs; without damping B is -1 and b is 0.

    phi_k(M) = sum_i M^i / (i + k)!: phi_3 by its series for an x halved until it is small, the
    others by phi_(k-1)(M) = 1/(k-1)! + M phi_k(M). Then they are doubled:
    phi_k(2 M) = (exp(M) phi_k(M) + sum_(j = 1..k) phi_j(M) / (k - j)!) / 2^k. No inverse and no
    difference of large numbers: nothing is lost from x = 1e-16 to 1e16.
    """
    norm = 1.0 if damping is None else 1.0 + 2.0 * damping
    halvings = np.ceil(np.log2(np.maximum(x * norm, 0.5)) + 1.0).astype(np.int64)
    small = np.ldexp(x, -halvings)

    def through(value: FloatPair, plus: float) -> FloatPair:
        a, b = value
        if damping is None:
            return plus - small * a, b
        return plus - small * b, small * (a - 2.0 * damping * b)

    def times(one: FloatPair, other: FloatPair) -> FloatPair:
        (a, b), (c, d) = one, other
        if damping is None:
            return a * c, b
        return a * c - b * d, a * d + b * c - 2.0 * damping * b * d

    def mixed(value: FloatPair, share: float, *more: tuple[float, FloatPair]) -> FloatPair:
        a, b = value
        for weight, (c, d) in more:
            a, b = a + weight * c, b + weight * d
        return share * a, share * b

    zero = np.zeros_like(small)
    p3 = (zero + 1.0 / factorial(TAYLOR_TERMS + 3), zero)
    for i in range(TAYLOR_TERMS - 1, -1, -1):
        p3 = through(p3, 1.0 / factorial(i + 3))
    p2 = through(p3, 0.5)
    p1 = through(p2, 1.0)
    values = [through(p1, 1.0), p1, p2, p3]
    for step in range(int(halvings.max(initial=0))):
        e, p1, p2, p3 = values
        doubled = [
            times(e, e),
            mixed(times(e, p1), 0.5, (1.0, p1)),
            mixed(times(e, p2), 0.25, (1.0, p1), (1.0, p2)),
            mixed(times(e, p3), 0.125, (0.5, p1), (1.0, p2), (1.0, p3)),
        ]
        at = halvings > step
        values = [
            (np.where(at, c, a), np.where(at, d, b))
            for (a, b), (c, d) in zip(values, doubled, strict=True)
        ]
    return values

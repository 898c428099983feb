"""Ramps between two speeds in closed form, at limited acceleration and jerk.

With jerk j and acceleration a a ramp from speed u to w begins and ends without acceleration: it
eases in over a/j, holds a, and eases out; a small one, |w - u| < a^2/j, eases in and out only. It
takes |w - u|/a + a/j, or 2 sqrt(|w - u|/j), and its mean speed is (u + w)/2. Without a limit of
jerk (j infinite) the acceleration is held throughout.

Everything is written so that no difference of nearly equal numbers decides a time: a phase is
known by its two end speeds, their weighted mean is its mean speed, and a way divided by it its
time. So v^2/(a d) may be anything: 2 d/(u + w), not (w - u)/a.
"""

from __future__ import annotations

from math import asinh, cbrt, inf, sinh, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

EASE_IN, HOLD, EASE_OUT = 0, 1, 2
"""Shapes of a phase: the acceleration grows from 0, keeps its value (or is 0), falls to 0."""

NEWTON_STEPS = 60
"""Most steps to the top speed of a move too short to reach its feed. 8 are usual; limits apart by
twelve powers of ten take 27."""

NEARLY = 1e-9
"""After a step of this share of the rise, or less, the next one would be below a rounding."""

ROUNDING = 2.0**-53
"""Half the spacing of numbers at 1."""

ROUNDED_UP = 1.0 + 1e-9
"""Widens a bracket by far more than it can have been rounded."""

STEEPEST = 1e300
"""From here on the cube of x is all that counts."""

CHUNK = 1 << 14
"""Moves looked at together: their arrays stay in the cache of a core."""


class Phases(NamedTuple):
    """Phases of n moves, (n, k) each: shape, speeds at both ends [mm/s], length [mm], time [s]."""

    shape: NDArray[np.int8]
    u: Floats
    w: Floats
    length: Floats
    seconds: Floats


def reachable_speed(u: float, length: float, a: float, j: float) -> float:
    """The largest speed at the end of a ramp of this length that begins at speed u."""
    if j == inf:
        return sqrt(u * u + 2.0 * a * length)
    gain = a * a / j
    # Without holding a: rise = x^2 with x^3 + 2 u x = length sqrt(j), which only grows in x.
    half, twice = length * sqrt(j), 2.0 * u
    third = sqrt(twice / 3.0)
    cube = twice * third
    steep = 1.5 * half / cube if cube > 0.0 else inf
    x = 2.0 * third * sinh(asinh(steep) / 3.0) if steep < inf else cbrt(half)
    rise = x * x
    x -= (x * (rise + twice) - half) / (3.0 * rise + twice) if x > 0.0 else 0.0
    rise = x * x
    if rise <= gain:
        return u + rise
    # Holding a: rise^2 + (2 u + gain) rise = 2 (a length - u gain).
    c = 4.0 * (a * length - u * gain)
    root = sqrt((twice - gain) ** 2 + 8.0 * a * length)
    return u + max(c / (twice + gain + root), gain)


def reachable_speeds(u: Floats, length: Floats, a: Floats, j: Floats) -> Floats:
    """The same of many ramps at once, shape (n,); j infinite everywhere or nowhere."""
    if np.isinf(j).all():
        return np.sqrt(u * u + 2.0 * a * length)
    gain = a * a / j
    half, twice = length * np.sqrt(j), 2.0 * u
    third = np.sqrt(twice / 3.0)
    with np.errstate(divide="ignore", over="ignore"):
        steep = np.minimum(1.5 * half / (twice * third), STEEPEST)
    x = np.where(steep < STEEPEST, 2.0 * third * np.sinh(np.arcsinh(steep) / 3.0), np.cbrt(half))
    x -= (x * (x * x + twice) - half) / (3.0 * x * x + twice)
    rise = x * x
    hold = np.flatnonzero(rise > gain)
    if len(hold):
        u_, way, gain = u[hold], a[hold] * length[hold], gain[hold]
        root = np.sqrt((2.0 * u_ - gain) ** 2 + 8.0 * way)
        rise[hold] = np.maximum(4.0 * (way - u_ * gain) / (2.0 * u_ + gain + root), gain)
    return np.asarray(u + rise)


def ramp_time(u: Floats, w: Floats, a: Floats, j: Floats) -> Floats:
    """Time of a ramp from speed u to w [s]."""
    rise = np.abs(w - u)
    return np.where(rise > a * a / j, rise / a + a / j, 2.0 * np.sqrt(rise / j))


def top_speed(u: Floats, w: Floats, cap: Floats, length: Floats, a: Floats, j: Floats) -> Floats:
    """Largest speed within a move from speed u to w, at most `cap`."""
    most = np.maximum(u, w)
    if np.isinf(j).all():
        mean = 0.5 * (u * u + w * w)
        return np.clip(np.sqrt(mean + a * length), most, np.maximum(cap, most))
    # A rise of r from the faster end takes 2 sqrt(r/j) and r/a at least, at a mean speed of r/2 and
    # of that end at least, in the length: a bracket that far feeds do not widen.
    with np.errstate(divide="ignore"):
        rise = np.minimum(np.cbrt(j * length * length), j * (0.5 * length / most) ** 2)
        rise = np.minimum(rise, np.minimum(np.sqrt(2.0 * a * length), a * length / most))
    top = np.maximum(np.minimum(cap, most + rise * ROUNDED_UP), most)
    short = np.flatnonzero(_ramps(u, top, w, a, j) > length)
    for first in range(0, len(short), CHUNK):
        at = short[first : first + CHUNK]
        ends = u[at], w[at], a[at], j[at]
        top[at] = _fitting(_meeting(top[at], length[at], ends), length[at], ends)
    return top


def _meeting(top: Floats, length: Floats, ends: tuple[Floats, ...]) -> Floats:
    """Top speeds, lower than `top`, whose ramps are as long as the moves but for rounding.

    The way of both ramps is convex in the root of the rise from the faster end, and smooth: from
    too fast a top on Newton's steps only fall, and soon converge.
    """
    u, w, a, j = ends
    most = np.maximum(u, w)
    root = np.sqrt(top - most)
    for _ in range(NEWTON_STEPS):
        way, slope = -length, np.zeros_like(root)
        for end in (most, np.minimum(u, w)):
            rise = root * root + (most - end)
            ease, mean = np.sqrt(rise / j), end + 0.5 * rise
            held = rise > a * a / j
            time = np.where(held, rise / a + a / j, 2.0 * ease)
            # d(time)/d(rise) is 1/a, or 1/(j ease); d(rise)/d(root) is 2 root.
            eased = np.divide(root, j * ease, out=np.sqrt(1.0 / j), where=ease > 0.0)
            way += mean * time
            slope += root * time + 2.0 * mean * np.where(held, root / a, eased)
        step = way / slope
        root = np.maximum(root - step, 0.0)
        if (np.abs(step) * root <= np.maximum(ROUNDING * most, NEARLY * root * root)).all():
            break
    return np.asarray(np.minimum(most + root * root, top))


def _fitting(top: Floats, length: Floats, ends: tuple[Floats, ...]) -> Floats:
    """Top speeds lowered by a few roundings, or to the faster end, so that their ramps fit."""
    u, w, a, j = ends
    most, by = np.maximum(u, w), np.spacing(top)
    while (over := (_ramps(u, top, w, a, j) > length) & (top > most)).any():
        top = np.where(over, np.maximum(top - by, most), top)
        by *= 2.0
    return top


def _ramps(u: Floats, top: Floats, w: Floats, a: Floats, j: Floats) -> Floats:
    """Way of the ramps from speed u to the top speed and from there to w."""
    up = 0.5 * (u + top) * ramp_time(u, top, a, j)
    return up + 0.5 * (w + top) * ramp_time(top, w, a, j)


def phases(u: Floats, w: Floats, cap: Floats, length: Floats, a: Floats, j: Floats) -> Phases:
    """The phases of moves from speed u to w [mm/s], as fast as they may: 3, or 7 with jerk.

    Args:
        u: speeds at the start.
        w: speeds at the end, reachable from u.
        cap: largest speed allowed.
        length: [mm], above 0.
        a: limits of acceleration along the way.
        j: limits of jerk along the way, infinite everywhere or nowhere.
    """
    top = top_speed(u, w, cap, length, a, j)
    if np.isinf(j).all():
        return _held(u, w, top, length, a)
    shape, speed, seconds = [], [u], []
    for first, last in ((u, top), (top, w)):
        rise = np.abs(last - first)
        eased = np.minimum(rise, a * a / j)
        step = 0.5 * eased * np.sign(last - first)
        ease = np.sqrt(eased / j)
        shape += [EASE_IN, HOLD, EASE_OUT]
        seconds += [ease, np.maximum(rise - eased, 0.0) / a, ease]
        speed += [first + step, last - step, last]
        if last is top:
            shape.append(HOLD)
            seconds.append(np.zeros_like(u))
            speed.append(top)
    begins, ends = np.stack(speed[:-1], axis=1), np.stack(speed[1:], axis=1)
    shapes = np.broadcast_to(np.array(shape, np.int8), begins.shape)
    time = np.stack(seconds, axis=1)
    way = time * mean_speed(shapes, begins, ends)
    return _filled(Phases(shapes, begins, ends, way, time), 3, top, length)


def _held(u: Floats, w: Floats, top: Floats, length: Floats, a: Floats) -> Phases:
    """Speed up, keep the top speed, slow down."""
    up = np.clip((top - u) * (top + u) / (2.0 * a), 0.0, length)
    down = np.clip((top - w) * (top + w) / (2.0 * a), 0.0, length - up)
    begins, ends = np.stack([u, top, top], axis=1), np.stack([top, top, w], axis=1)
    way = np.stack([up, np.zeros_like(u), down], axis=1)
    sums = begins + ends
    time = np.divide(2.0 * way, sums, out=np.zeros_like(way), where=way > 0.0)
    shapes = np.full(begins.shape, HOLD, np.int8)
    return _filled(Phases(shapes, begins, ends, way, time), 1, top, length)


def _filled(ramps: Phases, cruise: int, top: Floats, length: Floats) -> Phases:
    """The phases with what is left of the length run at top speed, in column `cruise`."""
    total = ramps.length.sum(axis=1)
    # Ramps longer than the move by a rounding are shortened alike.
    fit = np.minimum(1.0, length / np.where(total > 0.0, total, length))[:, None]
    way, time = ramps.length * fit, ramps.seconds * fit
    way[:, cruise] = np.maximum(length - way.sum(axis=1), 0.0)
    time[:, cruise] = way[:, cruise] / top
    return ramps._replace(length=way, seconds=time)


def mean_speed(shape: NDArray[np.int8], u: Floats, w: Floats) -> Floats:
    """Mean speed of phases: their end speeds weighted by shape."""
    weight = np.choose(shape, [2.0 / 3.0, 0.5, 1.0 / 3.0])
    return np.asarray(weight * u + (1.0 - weight) * w)


def time_law(shape: NDArray[np.int8], u: Floats, w: Floats) -> Floats:
    """Coefficients (c1, c2, c3) of phases, shape (n, 3); see Ways.law.

    Eased in the speed runs as u + (w - u) tau^2, held as u + (w - u) tau, eased out as
    w + (u - w) (1 - tau)^2: the integral is divided by the mean, so that the sum is 1.
    """
    mean = mean_speed(shape, u, w)
    c1 = np.divide(u, mean, out=np.ones_like(mean), where=mean > 0.0)
    rest = 1.0 - c1
    c3 = np.choose(shape, [rest, 0.0 * rest, -0.5 * rest])
    return np.stack([c1, rest - c3, c3], axis=1)

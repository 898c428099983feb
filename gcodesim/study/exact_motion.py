"""Angles, arcs, ramps and drives to 28 digits and more: the truth of studies and tests."""

from __future__ import annotations

from decimal import Decimal, localcontext
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

PI = Decimal("3.14159265358979323846264338327950288419716939937510582")


def decimal(x: float | Fraction) -> Decimal:
    """A number to the digits of the context."""
    exact = Fraction(x)
    return Decimal(exact.numerator) / Decimal(exact.denominator)


def exact_sincosd(degrees: float | Fraction) -> tuple[Decimal, Decimal]:
    """Sine and cosine to 40 digits: the angle is reduced exactly, then Taylor's series."""
    turned = Fraction(degrees) % 360
    quarter = round(turned / 90)
    rest = turned - 90 * quarter
    with localcontext(prec=50):
        x = decimal(rest) * PI / 180
        terms = [Decimal(1)]
        for k in range(1, 36):
            terms.append(terms[-1] * x / k)
        s = sum(((-1) ** (k // 2) * terms[k] for k in range(1, 36, 2)), Decimal(0))
        c = sum(((-1) ** (k // 2) * terms[k] for k in range(0, 36, 2)), Decimal(0))
        return [(s, c), (c, -s), (-s, -c), (-c, s)][quarter % 4]


def exact_displacement(arc: NDArray[np.void], s: float) -> NDArray[np.float64]:
    """r(s) (cos a u + sin a v) - r0 u + s lift of an ARC_PIECE as stored, to 28 digits, (3,)."""
    sine, cosine = exact_sincosd(Fraction(float(arc["sweep"])) * Fraction(s))
    r0, r1 = Fraction(float(arc["r0"])), Fraction(float(arc["r1"]))
    radius = decimal(r0 + (r1 - r0) * Fraction(s))
    along_u, along_v = radius * cosine - decimal(r0), radius * sine
    axes = [[decimal(float(x)) for x in arc[name]] for name in ("u", "v", "lift")]
    return np.array(
        [
            float(along_u * u + along_v * v + decimal(s) * lift)
            for u, v, lift in zip(*axes, strict=True)
        ]
    )


def exact_ramp_time(speed: float, acceleration: float, way: float) -> Decimal:
    """Time to cover a way from a speed at constant acceleration [s], to 60 digits."""
    with localcontext(prec=60):
        v, a, d = map(Decimal, (speed, acceleration, way))
        return 2 * d / (v + (v * v + 2 * a * d).sqrt())


def exact_hop_time(speed: float, jerk: float, way: float) -> Decimal:
    """Time of the fastest move from a speed back to it at limited jerk alone [s], to 60 digits.

    Two ramps of rise r take 2 sqrt(r/j) each at the mean speed v + r/2; bisected for the way.
    """
    with localcontext(prec=60):
        v, j, d = map(Decimal, (speed, jerk, way))
        low, high = Decimal(0), (d * d * j).sqrt() + d * j / max(v, Decimal("1e-30")) + 1
        for _ in range(240):
            rise = (low + high) / 2
            fits = (2 * v + rise) * 2 * (rise / j).sqrt() <= d
            low, high = (rise, high) if fits else (low, rise)
        return 4 * (low / j).sqrt()


def exact_functions(theta: float, z: float) -> list[list[float]]:
    """Exponential and phi_1..phi_3 of theta ((0, -1), (1, -2 z)) by their series: rows (4, 4).

    As many digits as the largest term has before the point, and 100 more.
    """
    with localcontext(prec=100 + int(theta * (1 + 2 * z))):
        zero = Decimal(0)
        b = [[zero, -Decimal(theta)], [Decimal(theta), -2 * Decimal(z) * Decimal(theta)]]
        found = []
        for k in range(4):
            term = [[Decimal(1), zero], [zero, Decimal(1)]]
            for i in range(1, k + 1):
                term = [[v / i for v in row] for row in term]
            total, i = [row[:] for row in term], k
            while max(abs(v) for row in term for v in row) > Decimal(10) ** -60 or i < 10:
                i += 1
                term = [
                    [sum((term[r][m] * b[m][c] for m in (0, 1)), zero) / i for c in (0, 1)]
                    for r in (0, 1)
                ]
                total = [
                    [x + y for x, y in zip(*rows, strict=True)]
                    for rows in zip(total, term, strict=True)
                ]
            found.append([float(v) for row in total for v in row])
        return found

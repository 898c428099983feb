"""Sine and cosine of an angle in degrees to 40 digits: the truth of the tests."""

from __future__ import annotations

from decimal import Decimal, localcontext
from fractions import Fraction

PI = Decimal("3.14159265358979323846264338327950288419716939937510582")


def exact_sincosd(degrees: float | Fraction) -> tuple[Decimal, Decimal]:
    """Sine and cosine to 40 digits: the angle is reduced exactly, then Taylor's series."""
    turned = Fraction(degrees) % 360
    quarter = round(turned / 90)
    rest = turned - 90 * quarter
    with localcontext(prec=50):
        x = Decimal(rest.numerator) / Decimal(rest.denominator) * PI / 180
        terms = [Decimal(1)]
        for k in range(1, 36):
            terms.append(terms[-1] * x / k)
        s = sum((-1) ** (k // 2) * terms[k] for k in range(1, 36, 2))
        c = sum((-1) ** (k // 2) * terms[k] for k in range(0, 36, 2))
        return [(s, c), (c, -s), (-s, -c), (-c, s)][quarter % 4]

"""How a rotary word is read on an axis that turns without end: the unwound angle it means."""

from __future__ import annotations

import math

from gcodesim.constants import SAME_ANGLE_DEG


def unwound(value: float, current: float, wrap: str, lower: float, upper: float) -> float:
    """Return the angle [deg], not reduced to one turn, that an absolute rotary word goes to.

    Args:
        value: the word.
        current: where the axis stands, unwound.
        wrap: none (the word is the unwound angle), shortest (modulo 360, the nearer way inside
            the travel, +180 on a tie) or sign (modulo 360, the sign is the direction).
        lower: travel in the same frame as value and current.
        upper: see lower.
    """
    if wrap == "shortest":
        return _shortest(value, current, lower, upper)
    if wrap == "sign":
        return _by_sign(value, current)
    return value


def _shortest(value: float, current: float, lower: float, upper: float) -> float:
    ahead = (value - current) % 360.0
    ahead = ahead - 360.0 if ahead > 180.0 else ahead
    # Whole turns are added to the word itself, so that its decimals stay as written.
    nearest = value + 360.0 * round((current + ahead - value) / 360.0)
    other = nearest - 360.0 if ahead > 0 else nearest + 360.0
    inside = [angle for angle in (nearest, other) if lower <= angle <= upper]
    return inside[0] if inside else nearest


def _by_sign(value: float, current: float) -> float:
    angle = abs(value)
    forward = math.copysign(1.0, value) > 0
    way = (angle - current) % 360.0 if forward else (current - angle) % 360.0
    way = 0.0 if 360.0 - way < SAME_ANGLE_DEG else way
    reached = current + way if forward else current - way
    return angle + 360.0 * round((reached - angle) / 360.0)

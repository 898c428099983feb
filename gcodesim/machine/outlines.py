"""Outlines of turned shapes: lines and arcs from the tip up, drawn around or inside as points.

Points are (r, z) [mm], z upwards from the tip. Drawn around, an outline is never smaller than the
true shape, which collisions need; drawn inside, it is never larger, which cutting needs.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gcodesim.machine.kinematics import sincosd

OutlinePoint = tuple[float, float]
OutlinePoints = tuple[OutlinePoint, ...]

AROUND_STEP = 15.0
"""Largest turn [deg] between two tangents that replace an arc outside the true shape."""

INSIDE_STEP = 5.0
"""Largest turn [deg] of a chord that replaces an arc inside the true shape."""

STRAIGHT = 1e-12
"""A corner bent by less than this, as a part of its edges, is none."""


@dataclass(frozen=True)
class Arc:
    """An arc about a centre (r, z) [mm]; growing angles [deg] bulge, shrinking ones are hollow.

    Attributes:
        start, end: from the r axis towards z, so that -90 is below the centre.
    """

    centre: OutlinePoint
    radius: float
    start: float
    end: float


Outline = Sequence[OutlinePoint | Arc]
"""From the tip up: a point ends a line, an arc is joined to what lies before it by a line."""


def around(outline: Outline) -> OutlinePoints:
    """Corners of the outline, nowhere inside the true one."""
    return _drawn(outline, outside=True, step=AROUND_STEP)


def inside(outline: Outline) -> OutlinePoints:
    """Corners of the outline, nowhere outside the true one."""
    return _drawn(outline, outside=False, step=INSIDE_STEP)


def _drawn(outline: Outline, outside: bool, step: float) -> OutlinePoints:
    points: list[OutlinePoint] = []
    for element in outline:
        if not isinstance(element, Arc):
            points.append((float(element[0]), float(element[1])))
        elif (element.end > element.start) == outside:
            points += _tangents(element, step)
        else:
            points += _chords(element, step)
    floor = points[0][1]
    # The first tangent of a corner is the plane of the tip: rounding must not lift it.
    points = [(r, floor if abs(z - floor) <= STRAIGHT else z) for r, z in points]
    # Seen from beyond the axis, so that a point on it stays unless the tip is flat.
    return tuple(_without_straight((-1.0, floor), points))


def _tangents(arc: Arc, step: float) -> list[OutlinePoint]:
    """Ends of the arc, and between them the corners of the tangents at equal turns."""
    sweep = arc.end - arc.start
    steps = math.ceil(abs(sweep) / step)
    angles = arc.start + sweep * (np.arange(steps) + 0.5) / steps
    reach = arc.radius / math.cos(math.radians(sweep / steps / 2.0))
    ends = _at(arc, np.array([arc.start, arc.end]), arc.radius)
    return [ends[0], *_at(arc, angles, reach), ends[1]]


def _chords(arc: Arc, step: float) -> list[OutlinePoint]:
    steps = math.ceil(abs(arc.end - arc.start) / step)
    return _at(arc, np.linspace(arc.start, arc.end, steps + 1), arc.radius)


def _at(arc: Arc, angles: NDArray[np.float64], reach: float) -> list[OutlinePoint]:
    sines, cosines = sincosd(angles)
    r, z = arc.centre
    return [
        (max(float(r + reach * c), 0.0), float(z + reach * s))
        for c, s in zip(cosines, sines, strict=True)
    ]


def _without_straight(start: OutlinePoint, points: list[OutlinePoint]) -> list[OutlinePoint]:
    """The points less those on a line with their neighbours, or equal to the one before.

    Args:
        start: what lies before the first point.
        points: of which the last one stays.
    """
    kept: list[OutlinePoint] = []
    for i, point in enumerate(points):
        before = kept[-1] if kept else start
        after = points[i + 1] if i + 1 < len(points) else None
        straight = after is not None and _is_straight(before, point, after)
        if point != before and not straight:
            kept.append(point)
    return kept


def _is_straight(a: OutlinePoint, b: OutlinePoint, c: OutlinePoint) -> bool:
    """Whether b lies between a and c, to rounding."""
    first, second = (b[0] - a[0], b[1] - a[1]), (c[0] - b[0], c[1] - b[1])
    length = math.hypot(*first) * math.hypot(*second)
    cross = first[0] * second[1] - first[1] * second[0]
    along = first[0] * second[0] + first[1] * second[1]
    return abs(cross) <= STRAIGHT * length and along >= 0.0

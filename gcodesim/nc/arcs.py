"""The geometry of an arc in its plane: centre and radius formats, and when an arc closes.

Plane coordinates (u, v), counter-clockwise about the plane normal; nc-language section 6.
"""

from __future__ import annotations

import math

from gcodesim.constants import FULL_CIRCLE_MM
from gcodesim.nc.control import ArcTolerance

Point = tuple[float, float]


class ArcError(Exception):
    """An arc that cannot be traced.

    Attributes:
        meaning: key of MEANINGS.
    """

    def __init__(self, meaning: str, what: str) -> None:
        self.meaning = meaning
        super().__init__(what)


def check_centre(start: Point, end: Point, centre: Point, tol: ArcTolerance, inch: bool) -> None:
    """Check that start and end lie on one circle about the centre; all in mm.

    Raises:
        ArcError: the centre is the start, or the radii differ beyond the tolerance.
    """
    radius, last = math.dist(start, centre), math.dist(end, centre)
    if radius < tol.r_tol_mm:
        raise ArcError("arc_zero_radius", f"radius {radius:.6g} mm")
    # The anchor's tolerance is 0.02828 mm, but 0.002828 inch under G20.
    widen = 2.54 if inch else 1.0
    gap = abs(last - radius)
    loose = gap > tol.tol_mm * widen and gap > tol.tol_rel * max(radius, last)
    if loose or gap > tol.tol_max_mm * widen:
        what = f"radius {radius:.6g} mm at the start, {last:.6g} mm at the end"
        raise ArcError("arc_radius_mismatch", what)


def centre_from_radius(
    start: Point, end: Point, radius: float, clockwise: bool, tol: ArcTolerance
) -> Point:
    """Return the centre of an R arc; a negative radius takes the way beyond 180 degrees.

    Raises:
        ArcError: the end is the start, or the radius cannot reach.
    """
    chord = math.dist(start, end)
    if chord < FULL_CIRCLE_MM:
        raise ArcError("arc_end_equals_start", "the R arc ends where it starts")
    if abs(radius) < tol.r_tol_mm:
        raise ArcError("arc_zero_radius", f"R {radius:.6g} mm")
    if chord / 2 - abs(radius) > tol.r_tol_mm:
        what = f"R {abs(radius):.6g} mm, half the distance is {chord / 2:.6g} mm"
        raise ArcError("arc_radius_too_small", what)
    height = math.sqrt(max(0.0, radius * radius - chord * chord / 4))
    side = 1.0 if (radius > 0) != clockwise else -1.0
    du, dv = (end[0] - start[0]) / chord, (end[1] - start[1]) / chord
    return (
        (start[0] + end[0]) / 2 - side * height * dv,
        (start[1] + end[1]) / 2 + side * height * du,
    )

"""The geometry of an arc in its plane: centre and radius formats, and when an arc closes.

Plane coordinates (u, v), counter-clockwise about the plane normal. What takes
columns does to each row, bit for bit, what its neighbour does to one arc.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gcodesim.constants import FULL_CIRCLE_MM
from gcodesim.errors import GcodesimError
from gcodesim.nc.control.readings import ArcTolerance

Point = tuple[float, float]
Pairs = tuple[NDArray[np.float64], NDArray[np.float64]]
Bools = NDArray[np.bool_]


class ArcError(GcodesimError):
    """An arc that cannot be traced.

    Attributes:
        meaning: key of MEANINGS.
    """

    def __init__(self, meaning: str, what: str) -> None:
        self.meaning = meaning
        super().__init__(what)


def _distance(a: Any, b: Any) -> float:
    u, v = a[0] - b[0], a[1] - b[1]
    return math.sqrt(u * u + v * v)


def _distances(a: Pairs, b: Pairs) -> NDArray[np.float64]:
    u, v = a[0] - b[0], a[1] - b[1]
    return np.asarray(np.sqrt(u * u + v * v))


def check_centre(start: Point, end: Point, centre: Point, tol: ArcTolerance, inch: bool) -> None:
    """Check that start and end lie on one circle about the centre; all in mm.

    Raises:
        ArcError: the centre is the start, or the radii differ beyond the tolerance.
    """
    radius, last = _distance(start, centre), _distance(end, centre)
    if radius < tol.r_tol_mm:
        raise ArcError("arc_zero_radius", f"radius {radius:.6g} mm")
    # LinuxCNC's tolerance is 0.02828 mm, but 0.002828 inch under G20.
    widen = 2.54 if inch else 1.0
    gap = abs(last - radius)
    loose = gap > tol.tol_mm * widen and gap > tol.tol_rel * max(radius, last)
    if loose or gap > tol.tol_max_mm * widen:
        what = f"radius {radius:.6g} mm at the start, {last:.6g} mm at the end"
        raise ArcError("arc_radius_mismatch", what)


def broken(start: Pairs, end: Pairs, centre: Pairs, tol: ArcTolerance, inch: bool) -> Bools:
    """Tell which arcs `check_centre` refuses; columns in mm."""
    radius, last = _distances(start, centre), _distances(end, centre)
    widen = 2.54 if inch else 1.0
    gap = np.abs(last - radius)
    loose = (gap > tol.tol_mm * widen) & (gap > tol.tol_rel * np.maximum(radius, last))
    return np.asarray((radius < tol.r_tol_mm) | loose | (gap > tol.tol_max_mm * widen))


def centre_from_radius(
    start: Point, end: Point, radius: float, clockwise: bool, tol: ArcTolerance
) -> Point:
    """Return the centre of an R arc; a negative radius takes the way beyond 180 degrees.

    Raises:
        ArcError: the end is the start, or the radius cannot reach.
    """
    chord = _distance(start, end)
    if chord < FULL_CIRCLE_MM:
        raise ArcError("arc_end_equals_start", "the R arc ends where it starts")
    if abs(radius) < tol.r_tol_mm:
        raise ArcError("arc_zero_radius", f"R {radius:.6g} mm")
    if chord / 2 - abs(radius) > tol.r_tol_mm:
        what = f"R {abs(radius):.6g} mm, half the distance is {chord / 2:.6g} mm"
        raise ArcError("arc_radius_too_small", what)
    # As a product: near half a circle the difference of the squares has lost its digits.
    height = math.sqrt(max(0.0, (abs(radius) - chord / 2) * (abs(radius) + chord / 2)))
    side = 1.0 if (radius > 0) != clockwise else -1.0
    du, dv = (end[0] - start[0]) / chord, (end[1] - start[1]) / chord
    return (
        (start[0] + end[0]) / 2 - side * height * dv,
        (start[1] + end[1]) / 2 + side * height * du,
    )


def centres_from_radii(
    start: Pairs, end: Pairs, radius: NDArray[np.float64], clockwise: Bools, tol: ArcTolerance
) -> tuple[Pairs, Bools]:
    """Return what `centre_from_radius` returns, and which arcs it refuses; columns in mm."""
    chord = _distances(start, end)
    refused = (chord < FULL_CIRCLE_MM) | (np.abs(radius) < tol.r_tol_mm)
    refused |= chord / 2 - np.abs(radius) > tol.r_tol_mm
    height = np.sqrt(np.maximum(0.0, (np.abs(radius) - chord / 2) * (np.abs(radius) + chord / 2)))
    side = np.where((radius > 0) != clockwise, 1.0, -1.0)
    # A refused arc may have no chord to divide by.
    chord = np.where(refused, 1.0, chord)
    du, dv = (end[0] - start[0]) / chord, (end[1] - start[1]) / chord
    return (
        (start[0] + end[0]) / 2 - side * height * dv,
        (start[1] + end[1]) / 2 + side * height * du,
    ), refused

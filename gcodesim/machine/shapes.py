"""Primitive shapes as closed, outward oriented triangles; round ones are never smaller than ideal.

A round shape becomes a prism or frustum of SIDES sides drawn around the circle: its corners lie at
radius / cos(pi / SIDES), its flats touch the ideal surface.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations, pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gcodesim.machine.kinematics import rotation_from_z, sincosd

Array = NDArray[np.float64]
Profile = Sequence[tuple[float, float]]

SIDES = 48
"""Sides of a full circle. More sides: nearer to the ideal shape, more triangles to test."""


def excess(radius: float) -> float:
    """Largest distance [mm] by which a round shape of this radius stands out of the ideal one."""
    return float(radius / np.cos(np.pi / SIDES) - radius)


def place(triangles: Array, turn: ArrayLike, shift: ArrayLike) -> Array:
    """Triangles (n, 3, 3) turned by a rotation (3, 3) and then shifted [mm]."""
    return triangles @ np.asarray(turn, dtype=np.float64).T + np.asarray(shift, dtype=np.float64)


def box(size: ArrayLike, center: ArrayLike = (0.0, 0.0, 0.0)) -> Array:
    """Axis-parallel box, 12 triangles."""
    x, y, z = np.asarray(size, dtype=np.float64) / 2.0
    standing = extrude([(-x, -y), (x, -y), (x, y), (-x, y)], 2.0 * z)
    return place(standing, np.eye(3), np.asarray(center, dtype=np.float64) - [0.0, 0.0, z])


def cylinder(radius: float, height: float, center: ArrayLike, axis: ArrayLike) -> Array:
    """Cylinder about a unit vector; `center` is its middle."""
    return cone(radius, radius, height, center, axis)


def cone(
    radius: float, top_radius: float, height: float, center: ArrayLike, axis: ArrayLike
) -> Array:
    """Cone or frustum: `radius` at the low end of the unit vector `axis`, `center` half way up."""
    half = height / 2.0
    return place(revolve([(radius, -half), (top_radius, half)]), rotation_from_z(axis), center)


def revolve(profile: Profile, sides: int = SIDES) -> Array:
    """Solid of revolution about Z under a profile of (r, z) points, (n, 3, 3).

    z may not turn back along the profile, so that every section is a full disc: only then is the
    shape around the circle never smaller than the ideal solid. ValueError says what is wrong.
    """
    points = _open_profile(profile)
    rings = [_ring(r, z, sides) for r, z in points]
    triangles = []
    for lower, upper in pairwise(rings):
        a, b = lower, np.roll(lower, -1, axis=0)
        d, c = upper, np.roll(upper, -1, axis=0)
        if lower[0, :2].any():
            triangles.append(np.stack([a, b, c], axis=1))
        if upper[0, :2].any():
            triangles.append(np.stack([a, c, d], axis=1))
    return np.concatenate(triangles)


def shell_corners(triangles: Array) -> tuple[Array, NDArray[np.intp], NDArray[np.intp]]:
    """Corners of triangles by shell: surfaces that share no corner are shells of their own.

    Returns:
        The different corners (m, 3), their numbers in every triangle (n, 3), and the shell of each
        corner: the lowest number of a corner in it, (m,).
    """
    points, corner = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)
    faces = corner.reshape(-1, 3)
    label = np.arange(len(points))
    while True:
        lowest = label[faces].min(axis=1)
        lower = label.copy()
        for k in range(3):
            np.minimum.at(lower, faces[:, k], lowest)
        lower = lower[lower]
        if np.array_equal(lower, label):
            return points, faces, label
        label = lower


def shells(triangles: Array) -> list[Array]:
    """The triangles of every shell."""
    _, faces, label = shell_corners(triangles)
    of_face = label[faces[:, 0]]
    return [triangles[of_face == shell] for shell in np.unique(of_face)]


def _ring(radius: float, z: float, sides: int) -> Array:
    """Corners (sides, 3) of the polygon around a circle."""
    sine, cosine = sincosd(np.arange(sides) * (360.0 / sides))
    corner = radius / np.cos(np.pi / sides)
    return np.stack([corner * cosine, corner * sine, np.full(sides, z)], axis=1)


def _open_profile(profile: Profile) -> list[tuple[float, float]]:
    """The profile upwards from axis to axis, without points that make no surface."""
    points = [(float(r), float(z)) for r, z in profile]
    if points[0][1] > points[-1][1]:
        points.reverse()
    if any(r < 0 for r, _ in points):
        raise ValueError("a radius is negative")
    if any(after[1] < before[1] for before, after in pairwise(points)):
        raise ValueError("z turns back along the profile: make the hollow shape a mesh")
    points = [(0.0, points[0][1]), *points, (0.0, points[-1][1])]
    points = [p for i, p in enumerate(points) if i == 0 or p != points[i - 1]]
    while len(points) > 1 and points[1][0] == 0.0:
        points.pop(0)
    while len(points) > 1 and points[-2][0] == 0.0:
        points.pop()
    if len(points) < 3 or points[0][1] == points[-1][1]:
        raise ValueError("the profile encloses no volume")
    if any(r == 0.0 for r, _ in points[1:-1]):
        raise ValueError("the radius is 0 between two solid stretches: make them two parts")
    return points


def extrude(polygon: Sequence[tuple[float, float]], height: float) -> Array:
    """Prism over a simple polygon in the XY plane, from z = 0 to z = height; ValueError if not."""
    corners = np.asarray(polygon, dtype=np.float64)
    following = np.roll(corners, -1, axis=0)
    area = float(np.sum(corners[:, 0] * following[:, 1] - corners[:, 1] * following[:, 0]))
    if area < 0.0:
        corners = corners[::-1]
    if area == 0.0 or _crosses_itself(corners):
        raise ValueError("the polygon has no area or crosses itself")
    low = np.column_stack([corners, np.zeros(len(corners))])
    high = np.column_stack([corners, np.full(len(corners), height)])
    caps = _ears(corners)
    a, b = low, np.roll(low, -1, axis=0)
    d, c = high, np.roll(high, -1, axis=0)
    walls = [np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)]
    return np.concatenate([low[caps[:, ::-1]], *walls, high[caps]])


def _turn(a: Array, b: Array, c: Array) -> float:
    """Twice the signed area of a plane triangle; positive when it runs counter-clockwise."""
    return float((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))


def _crosses_itself(corners: Array) -> bool:
    """Whether two edges that are not neighbours touch or two corners coincide."""
    count = len(corners)
    if len({tuple(corner) for corner in corners}) < count:
        return True
    edges = [(corners[i], corners[(i + 1) % count]) for i in range(count)]
    for i, j in combinations(range(count), 2):
        if (j - i) % count in (1, count - 1):
            continue
        (a, b), (c, d) = edges[i], edges[j]
        splits = _turn(a, b, c) * _turn(a, b, d) <= 0 and _turn(c, d, a) * _turn(c, d, b) <= 0
        boxes = (np.minimum(a, b) <= np.maximum(c, d)) & (np.minimum(c, d) <= np.maximum(a, b))
        if splits and boxes.all():
            return True
    return False


def _ears(corners: Array) -> NDArray[np.int64]:
    """Triangulate a counter-clockwise simple polygon by cutting ears, (n - 2, 3) corner numbers."""
    left = list(range(len(corners)))
    triangles = []
    while len(left) > 3:
        for k in range(len(left)):
            i, j, m = left[k - 1], left[k], left[(k + 1) % len(left)]
            others = [corners[n] for n in left if n not in (i, j, m)]
            if _is_ear(corners[i], corners[j], corners[m], others):
                triangles.append((i, j, m))
                left.pop(k)
                break
        else:
            raise ValueError("the polygon cannot be filled: two of its edges touch")
    triangles.append((left[0], left[1], left[2]))
    return np.array(triangles, dtype=np.int64)


def _is_ear(a: Array, b: Array, c: Array, others: list[Array]) -> bool:
    """Whether a counter-clockwise triangle holds none of the other corners, not even on its rim."""
    if _turn(a, b, c) <= 0.0:
        return False
    return not any(
        _turn(a, b, p) >= 0.0 and _turn(b, c, p) >= 0.0 and _turn(c, a, p) >= 0.0 for p in others
    )

"""Exact intersection, distance and depth of triangles in Python integers: the truth of the study.

A float64 is an integer times a power of two, so one common power of two makes all 18 coordinates
of a pair integers; from there every sign is exact. Triangles are closed (touching counts) and may
be degenerate: three vertices on a line are a segment, three equal ones a point.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

IntVector = tuple[int, int, int]
Triangle = tuple[IntVector, IntVector, IntVector]
Corners = Sequence[Sequence[float]]

ZERO: IntVector = (0, 0, 0)
EDGES = ((0, 1), (1, 2), (2, 0))


def label(a: ArrayLike, b: ArrayLike) -> NDArray[np.bool_]:
    """Tell for n pairs of triangles, (n, 3, 3) each, which of them share a point; (n,).

    Raises:
        ValueError: a coordinate is NaN (OverflowError where it is infinite).
    """
    pairs = zip(_as_lists(a), _as_lists(b), strict=True)
    return np.fromiter((_corners_meet(p, q) for p, q in pairs), dtype=np.bool_)


def squared_clearance(a: ArrayLike, b: ArrayLike) -> Fraction:
    """Return the exact squared distance of two triangles, (3, 3) each; 0 where they touch.

    Closest points lie inside a vertex, an edge or a face on either side, so their difference is
    parallel to one of `_directions`. Along that one the gap between the projections is the
    distance, along every other it is at most the distance. Independent of the test by edges above.
    """
    p, q, unit = _integers(_as_lists(a), _as_lists(b))
    best = Fraction(0)
    for d in _directions(p, q):
        along_p, along_q = [_dot(d, v) for v in p], [_dot(d, v) for v in q]
        gap = max(min(along_q) - max(along_p), min(along_p) - max(along_q))
        if gap > 0:
            best = max(best, Fraction(gap * gap, _dot(d, d)))
    return best / (unit * unit)


def squared_depth(a: ArrayLike, b: ArrayLike) -> Fraction:
    """Return the exact square of the shortest way that takes two touching triangles apart.

    The differences of their points fill a convex body, whose faces have the normals of the two
    triangles or of two edges; the way leads to its nearest face. 0 where they only touch, lie in
    one plane, or have no such normal.
    """
    p, q, unit = _integers(_as_lists(a), _as_lists(b))
    edges_p, edges_q = ([_sub(t[j], t[i]) for i, j in EDGES] for t in (p, q))
    normals = [_cross(edges_p[0], edges_p[1]), _cross(edges_q[0], edges_q[1])]
    normals += [_cross(e, f) for e, f in product(edges_p, edges_q)]
    overlaps = []
    for n in (n for n in normals if n != ZERO):
        along_p, along_q = [_dot(n, v) for v in p], [_dot(n, v) for v in q]
        way = max(0, min(max(along_p) - min(along_q), max(along_q) - min(along_p)))
        overlaps.append(Fraction(way * way, _dot(n, n)))
    return min(overlaps, default=Fraction(0)) / (unit * unit)


def _as_lists(triangles: ArrayLike) -> Any:
    return np.asarray(triangles, dtype=np.float64).tolist()


def _corners_meet(a: Corners, b: Corners) -> bool:
    for k in range(3):
        a0, a1, a2, b0, b1, b2 = a[0][k], a[1][k], a[2][k], b[0][k], b[1][k], b[2][k]
        if max(a0, a1, a2) < min(b0, b1, b2) or max(b0, b1, b2) < min(a0, a1, a2):
            return False
    p, q, _ = _integers(a, b)
    return _meet(p, q)


def _integers(a: Corners, b: Corners) -> tuple[Triangle, Triangle, int]:
    """Return both triangles times one common power of two that makes them integer, and it."""
    ratios = [x.as_integer_ratio() for triangle in (a, b) for vertex in triangle for x in vertex]
    unit = max(denominator for _, denominator in ratios)
    n = [numerator * (unit // denominator) for numerator, denominator in ratios]
    v = [(n[i], n[i + 1], n[i + 2]) for i in range(0, 18, 3)]
    return (v[0], v[1], v[2]), (v[3], v[4], v[5]), unit


def _meet(a: Triangle, b: Triangle) -> bool:
    """Tell whether two integer triangles share a point.

    An extreme point of the common part lies on the outline of one of the two, so it is enough to
    ask each edge of one against the face of the other. A degenerate triangle is its own outline.
    """
    plates = []
    for outline, face in ((a, b), (b, a)):
        normal = _cross(_sub(face[1], face[0]), _sub(face[2], face[0]))
        if normal == ZERO:
            continue
        heights = [_dot(normal, _sub(v, face[0])) for v in outline]
        if min(heights) > 0 or max(heights) < 0:
            return False
        plates.append((outline, face, normal, heights))
    if not plates:
        return any(
            _segments_meet(a[i], a[j], b[k], b[m]) for (i, j), (k, m) in product(EDGES, EDGES)
        )
    return any(_outline_meets_face(*plate) for plate in plates)


def _outline_meets_face(
    outline: Triangle, face: Triangle, normal: IntVector, heights: Sequence[int]
) -> bool:
    for i, j in EDGES:
        p, q = outline[i], outline[j]
        if heights[i] == 0 == heights[j]:
            meets = _flat_edge_meets_face(p, q, face, normal)
        else:
            crosses = min(heights[i], heights[j]) <= 0 <= max(heights[i], heights[j])
            meets = crosses and _crossing_edge_meets_face(p, q, face)
        if meets:
            return True
    return False


def _crossing_edge_meets_face(p: IntVector, q: IntVector, face: Triangle) -> bool:
    """Tell whether segment pq, which crosses the plane of the face in one point, hits the face.

    The line pq passes the three edges all on the same side, or through them.
    """
    d = _sub(q, p)
    r = [_sub(v, p) for v in face]
    sides = [_dot(d, _cross(r[i], r[j])) for i, j in EDGES]
    return min(sides) >= 0 or max(sides) <= 0


def _flat_edge_meets_face(p: IntVector, q: IntVector, face: Triangle, normal: IntVector) -> bool:
    """Tell whether segment pq, which lies in the plane of the face, meets the face."""
    inside = all(
        _dot(normal, _cross(_sub(face[j], face[i]), _sub(p, face[i]))) >= 0 for i, j in EDGES
    )
    return inside or any(_segments_meet(p, q, face[i], face[j]) for i, j in EDGES)


def _segments_meet(p: IntVector, q: IntVector, r: IntVector, s: IntVector) -> bool:
    """Tell whether segments pq and rs share a point; either may be a single point."""
    d, e, w = _sub(q, p), _sub(s, r), _sub(r, p)
    c = _cross(d, e)
    if c != ZERO:
        # p + t d = r + u e with t = t_scaled / c.c and u = u_scaled / c.c, if the lines meet.
        t_scaled, u_scaled, scale = _dot(_cross(w, e), c), _dot(_cross(w, d), c), _dot(c, c)
        return _dot(c, w) == 0 and 0 <= t_scaled <= scale and 0 <= u_scaled <= scale
    if _cross(w, d) != ZERO or _cross(w, e) != ZERO:
        return False
    # All on one line, where boxes overlap exactly when the segments do.
    return all(
        max(p[k], q[k]) >= min(r[k], s[k]) and max(r[k], s[k]) >= min(p[k], q[k]) for k in range(3)
    )


def _directions(a: Triangle, b: Triangle) -> Iterator[IntVector]:
    """Yield every direction in which the closest points of two disjoint triangles can differ."""
    edges_a = [_sub(a[j], a[i]) for i, j in EDGES]
    edges_b = [_sub(b[j], b[i]) for i, j in EDGES]
    candidates = [_cross(edges_a[0], edges_a[1]), _cross(edges_b[0], edges_b[1])]
    candidates += [_cross(e, f) for e, f in product(edges_a, edges_b)]
    for i, j in product(range(3), range(3)):
        w, e, f = _sub(b[j], a[i]), edges_a[i], edges_b[j]
        candidates.append(w)
        # From the line of edge e of a to vertex j of b, and from the line of f to vertex i of a.
        candidates += [_cross(e, _cross(w, e)), _cross(f, _cross(w, f))]
    yield from (d for d in candidates if d != ZERO)


def _sub(u: IntVector, v: IntVector) -> IntVector:
    return (u[0] - v[0], u[1] - v[1], u[2] - v[2])


def _dot(u: IntVector, v: IntVector) -> int:
    return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]


def _cross(u: IntVector, v: IntVector) -> IntVector:
    u0, u1, u2 = u
    v0, v1, v2 = v
    return (u1 * v2 - u2 * v1, u2 * v0 - u0 * v2, u0 * v1 - u1 * v0)

"""Which triangles touch, and where, once the first contact is known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gcodesim.collision.bodies.scene import Scene
from gcodesim.collision.geometry.poses import PathArrays
from gcodesim.collision.instants.posed_pair import pose_pair
from gcodesim.motion.samples import Instants

EDGE_PART = 1e-9
"""A piercing point this part outside a triangle still counts: rounding must not lose it."""


@dataclass(frozen=True)
class TouchingTriangles:
    """The first touching triangles of a pair at one instant.

    Attributes:
        time_ps: the instant.
        numbers: triangle numbers in the whole shapes of a and b.
        point: a point both triangles share [mm], in the frame of body a's link, shape (3,).
    """

    time_ps: int
    numbers: tuple[int, int]
    point: NDArray[np.float64]


def touching_triangles(
    scene: Scene, path: PathArrays, instants: Instants, pair: int
) -> TouchingTriangles:
    """First instant, in the order of time, at which the pair touches, with its lowest triangles.

    Raises:
        ValueError: the pair touches at none of the instants.
    """
    for time_ps, piece in zip(instants.time_ps.tolist(), instants.piece.tolist(), strict=True):
        posed = pose_pair(scene, path, pair, piece, time_ps)
        rows = posed.touching()
        if rows:
            point = common_point(*posed.triangles(*rows))
            return TouchingTriangles(time_ps, posed.numbers(*rows), point)
    raise ValueError("the pair touches at none of the instants")


def halfway(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Point halfway between two triangles, shape (3,)."""
    return np.asarray(nearest_points(a, b).mean(axis=0))


def nearest_points(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Nearest points of two triangles that do not pierce each other, of a and of b, shape (2, 3).

    A corner of one and a point of the other, or points of two edges.
    """
    corners = [(p, _project(b, p)) for p in a] + [(_project(a, q), q) for q in b]
    candidates = np.concatenate([corners, _between_edges(a, b)])
    apart = candidates[:, 1] - candidates[:, 0]
    return np.asarray(candidates[np.argmin(np.einsum("ij,ij->i", apart, apart))])


def _between_edges(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Nearest points of every edge of a and every edge of b, shape (9, 2, 3).

    Ericson, Real-Time Collision Detection, 5.1.9.
    """
    p, d = np.repeat(a, 3, axis=0), np.repeat(np.roll(a, -1, axis=0) - a, 3, axis=0)
    q, e = np.tile(b, (3, 1)), np.tile(np.roll(b, -1, axis=0) - b, (3, 1))
    dd, de, ee = (np.einsum("ij,ij->i", x, y) for x, y in ((d, d), (d, e), (e, e)))
    dr, er = (np.einsum("ij,ij->i", x, p - q) for x in (d, e))
    s = _share(de * er - dr * ee, dd * ee - de * de)
    t = _share(de * s + er, ee)
    s = _share(de * t - dr, dd)
    return np.stack([p + s[:, None] * d, q + t[:, None] * e], axis=1)


def _share(part: NDArray[np.float64], whole: NDArray[np.float64]) -> NDArray[np.float64]:
    """How far along an edge, 0..1; 0 where the edge is a point or parallel to the other."""
    return np.clip(np.divide(part, whole, out=np.zeros_like(part), where=whole > 0.0), 0.0, 1.0)


def _project(t: NDArray[np.float64], x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Point of a triangle nearest to x: the foot of x if it lies inside, else on an edge."""
    normal = np.cross(t[1] - t[0], t[2] - t[0])
    area = float(normal @ normal)
    candidates = []
    if area > 0.0:
        foot = x - ((x - t[0]) @ normal) / area * normal
        sides = [np.cross(t[(k + 1) % 3] - t[k], foot - t[k]) @ normal for k in range(3)]
        if min(sides) >= 0.0:
            return np.asarray(foot)
    for k in range(3):
        edge = t[(k + 1) % 3] - t[k]
        length = float(edge @ edge)
        part = np.clip((x - t[k]) @ edge / length, 0.0, 1.0) if length > 0.0 else 0.0
        candidates.append(t[k] + part * edge)
    return np.asarray(min(candidates, key=lambda c: float((c - x) @ (c - x))))


def common_point(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """A point common to two touching triangles, shape (3,): for people, good to rounding.

    The mean of the points where edges of one pierce the other; for coplanar triangles, the mean of
    the two centres.
    """
    points = [*_piercings(a, b), *_piercings(b, a)]
    return np.asarray(np.mean(points if points else [a.mean(axis=0), b.mean(axis=0)], axis=0))


def _piercings(a: NDArray[np.float64], b: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """Points where the edges of `a` pass through triangle `b`, with a little tolerance."""
    normal = np.cross(b[1] - b[0], b[2] - b[0])
    heights = (a - b[0]) @ normal
    found = []
    for i, j in ((0, 1), (1, 2), (2, 0)):
        if heights[i] * heights[j] > 0.0 or heights[i] == heights[j]:
            continue
        point = a[i] + heights[i] / (heights[i] - heights[j]) * (a[j] - a[i])
        sides = [np.cross(b[(k + 1) % 3] - b[k], point - b[k]) @ normal for k in range(3)]
        if min(sides) >= -EDGE_PART * float(normal @ normal):
            found.append(point)
    return found

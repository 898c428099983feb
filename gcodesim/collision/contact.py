"""Which triangles touch, and where, once the first contact is known."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from gcodesim.collision.boxes import aabbs_overlap, posed_triangle, triangle_box
from gcodesim.collision.device import BIT_EQUAL
from gcodesim.collision.exhaustive import NO_CONTACT
from gcodesim.collision.poses import ChainArrays, PathArrays, pair_pose
from gcodesim.collision.predicates import triangles_touch
from gcodesim.collision.scene import Scene
from gcodesim.motion.samples import Instants

wp.set_module_options(BIT_EQUAL)

PROJECTIONS = 100
"""Alternating projections towards the nearest points of two triangles."""

NUMBER_BITS = wp.constant(wp.int64(32))


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


@wp.kernel
def find_touching_triangles(
    path: PathArrays,
    chains: ChainArrays,
    pair: wp.int32,
    piece: wp.int32,
    time_ps: wp.int64,
    triangles_a: wp.array[wp.mat33d],
    triangles_b: wp.array[wp.mat33d],
    lowest_out: wp.array[wp.int64],
):
    """One thread per triangle of a: lowest (number in a, number in b) that touches."""
    i = wp.tid()
    pose = pair_pose(path, chains, pair, piece, time_ps)
    own = triangle_box(triangles_a[i])
    for j in range(triangles_b.shape[0]):
        posed = posed_triangle(pose, triangles_b[j])
        near = aabbs_overlap(triangle_box(posed), own.low, own.high)
        if near and triangles_touch(triangles_a[i], posed):
            key = (wp.int64(i) << NUMBER_BITS) + wp.int64(j)
            wp.atomic_min(lowest_out, 0, key)
            return


@wp.kernel
def pose_one_triangle(
    path: PathArrays,
    chains: ChainArrays,
    pair: wp.int32,
    piece: wp.int32,
    time_ps: wp.int64,
    triangles: wp.array[wp.mat33d],
    posed_out: wp.array[wp.mat33d],
):
    """One thread per triangle of b."""
    i = wp.tid()
    pose = pair_pose(path, chains, pair, piece, time_ps)
    posed_out[i] = posed_triangle(pose, triangles[i])


def touching_triangles(
    scene: Scene, path: PathArrays, instants: Instants, pair: int
) -> TouchingTriangles:
    """First instant, in the order of time, at which the pair touches, with its lowest triangles.

    Raises:
        ValueError: the pair touches at none of the instants.
    """
    device = scene.device
    shapes = [shape.regions for shape in scene.shapes[pair]]
    ranks = [np.argsort(regions.order) for regions in shapes]
    ordered = [regions.triangles[rank] for regions, rank in zip(shapes, ranks, strict=True)]
    on_device = [wp.array(t, dtype=wp.mat33d, device=device) for t in ordered]
    for time_ps, piece in zip(instants.time_ps.tolist(), instants.piece.tolist(), strict=True):
        lowest = wp.full(1, NO_CONTACT, dtype=wp.int64, device=device)
        pose_inputs = [path, scene.chains, pair, piece, time_ps]
        wp.launch(
            find_touching_triangles,
            dim=len(ordered[0]),
            inputs=[*pose_inputs, *on_device],
            outputs=[lowest],
            device=device,
        )
        key = int(lowest.numpy()[0])
        if key == NO_CONTACT:
            continue
        i, j = key >> 32, key & 0xFFFFFFFF
        posed = posed_row(scene, path, pair, piece, time_ps, on_device[1][j : j + 1])
        point = common_point(ordered[0][i], posed)
        numbers = [int(s.order[r[k]]) for s, r, k in zip(shapes, ranks, (i, j), strict=True)]
        return TouchingTriangles(time_ps, (numbers[0], numbers[1]), point)
    raise ValueError("the pair touches at none of the instants")


def posed_row(
    scene: Scene, path: PathArrays, pair: int, piece: int, time_ps: int, triangle: Any
) -> NDArray[np.float64]:
    """One triangle of b, given as a device array of one row, in the frame of a, shape (3, 3)."""
    posed = wp.zeros(1, dtype=wp.mat33d, device=scene.device)
    wp.launch(
        pose_one_triangle,
        dim=1,
        inputs=[path, scene.chains, pair, piece, time_ps, triangle],
        outputs=[posed],
        device=scene.device,
    )
    return np.asarray(posed.numpy()[0])


def halfway(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Point halfway between two triangles, by alternating projections: for people, not exact."""
    p = a.mean(axis=0)
    q = p
    for _ in range(PROJECTIONS):
        q = _project(b, p)
        p = _project(a, q)
    return np.asarray((p + q) / 2.0)


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
        if min(sides) >= -1e-9 * float(normal @ normal):
            found.append(point)
    return found

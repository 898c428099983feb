"""How far two bodies may move before they can touch: the directed second-order bound, at one pose.

Along a unit vector n that separates two triangles by a gap g, a point that
moves with velocity v now and accelerates along n by at most K closes the gap no sooner than after
h, where  s h + K h^2 / 2 = g  and s is the largest -n.v. The search proves stretches by chords
instead (motion_bounds.py), which needs no velocities; the study compares the two.
"""

from __future__ import annotations

import numpy as np
import warp as wp
from numpy.typing import NDArray

from gcodesim.collision.geometry.closest import TINY, between_triangles
from gcodesim.collision.geometry.device import BIT_EQUAL

# Loops stay loops: unrolled, the kernel takes long to compile and gains nothing.
wp.set_module_options({**BIT_EQUAL, "max_unroll": 2})

ROUNDED_DOWN = wp.constant(wp.float64(1.0 - 1.0e-12))
"""Steps are shortened by this factor: more than the rounding of the formula."""


@wp.func
def time_to_close(gap: wp.float64, speed: wp.float64, curvature: wp.float64):
    """Least time in which a gap can close; no digits are lost for bodies that part."""
    root = wp.sqrt(speed * speed + wp.float64(2.0) * curvature * gap)
    if speed >= wp.float64(0.0):
        if speed + root <= wp.float64(0.0):
            return wp.float64(1.0e9)
        return wp.float64(2.0) * gap / (speed + root)
    if curvature <= wp.float64(0.0):
        return wp.float64(1.0e9)
    return (root - speed) / curvature


@wp.func
def gap_along(a: wp.mat33d, b: wp.mat33d, n: wp.vec3d):
    """Gap of two triangles along a unit vector from a to b."""
    low = wp.min(wp.dot(n, b[0]), wp.min(wp.dot(n, b[1]), wp.dot(n, b[2])))
    high = wp.max(wp.dot(n, a[0]), wp.max(wp.dot(n, a[1]), wp.dot(n, a[2])))
    return low - high


@wp.func
def wider(a: wp.mat33d, b: wp.mat33d, n: wp.vec3d, other: wp.vec3d):
    """The direction with the larger gap: n, or another vector either way round."""
    length = wp.length(other)
    if length <= TINY:
        return n
    along = other / length
    forwards = gap_along(a, b, along)
    backwards = gap_along(a, b, -along)
    if wp.max(forwards, backwards) <= gap_along(a, b, n):
        return n
    return wp.where(forwards >= backwards, along, -along)


@wp.func
def widest_direction(a: wp.mat33d, b: wp.mat33d):
    """Unit vector along which two triangles are farthest apart.

    The way between the nearest points; where that is so short that its direction is lost in
    rounding, a normal of a face or of two edges.
    """
    v = between_triangles(a, b)
    n = v / wp.max(wp.length(v), TINY)
    n = wider(a, b, n, wp.cross(a[1] - a[0], a[2] - a[0]))
    n = wider(a, b, n, wp.cross(b[1] - b[0], b[2] - b[0]))
    for k in range(3):
        for m in range(3):
            n = wider(a, b, n, wp.cross(a[(k + 1) % 3] - a[k], b[(m + 1) % 3] - b[m]))
    return n


@wp.kernel
def step_pairs(
    a: wp.array[wp.mat33d],
    b: wp.array[wp.mat33d],
    velocity: wp.array[wp.mat33d],
    curvature: wp.array[wp.float64],
    across: wp.mat33d,
    margin: wp.float64,
    least_out: wp.array[wp.float64],
):
    """One thread per pair of triangles, of which those of a stand still.

    least_out: the time in which no gap falls below `margin` [s], and the smallest gap [mm].
    """
    i, j = wp.tid()
    n = widest_direction(a[i], b[j])
    gap = gap_along(a[i], b[j], n)
    wp.atomic_min(least_out, 1, gap)
    if gap <= margin:
        wp.atomic_min(least_out, 0, wp.float64(0.0))
        return
    speed = -wp.dot(n, velocity[j][0])
    speed = wp.max(speed, -wp.dot(n, velocity[j][1]))
    speed = wp.max(speed, -wp.dot(n, velocity[j][2]))
    bend = curvature[j] * wp.length(across * n)
    wp.atomic_min(least_out, 0, time_to_close(gap - margin, speed, bend) * ROUNDED_DOWN)


def free_time(
    a: NDArray[np.float64],
    b: NDArray[np.float64],
    velocity: NDArray[np.float64],
    curvature: NDArray[np.float64],
    across: NDArray[np.float64],
    margin_mm: float,
) -> tuple[float, float]:
    """Time in which no gap falls below a margin [s], and the smallest gap now [mm]; on the CPU.

    Args:
        a: triangles that stand still, (n, 3, 3) [mm].
        b: triangles that move, posed, (m, 3, 3) [mm].
        velocity: of their vertices, (m, 3, 3) [mm/s].
        curvature: largest acceleration of a point of each from now on, (m,) [mm/s^2].
        across: projection onto the space in which points accelerate, (3, 3).
        margin_mm: what must be left [mm].
    """
    least = wp.array([1.0e9, 1.0e9], dtype=wp.float64, device="cpu")
    on_device = [wp.array(t, dtype=wp.mat33d, device="cpu") for t in (a, b, velocity)]
    bends = wp.array(curvature, dtype=wp.float64, device="cpu")
    wp.launch(
        step_pairs,
        dim=(len(a), len(b)),
        inputs=[*on_device, bends, wp.mat33d(*across.ravel()), margin_mm],
        outputs=[least],
        device="cpu",
    )
    step, gap = least.numpy().tolist()
    return step, gap

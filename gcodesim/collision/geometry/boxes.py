"""Axis-aligned boxes on the device: posing one conservatively, and the overlap test."""

import warp as wp

from gcodesim.collision.geometry.device import BIT_EQUAL
from gcodesim.collision.geometry.poses import Pose
from gcodesim.collision.geometry.predicates import abs_vec, snap
from gcodesim.constants import BOX_SLACK_MM

wp.set_module_options(BIT_EQUAL)

SLACK = wp.constant(wp.float64(BOX_SLACK_MM))
PLANE_ERROR = wp.constant(wp.float64(32.0 * 2.0**-53))


@wp.struct
class AlignedBox:
    """Lowest and highest corner [mm]."""

    low: wp.vec3d
    high: wp.vec3d


@wp.func
def abs_rotation(R: wp.mat33d):
    """Absolute values of a rotation: turns half extents into the half extents of the posed box."""
    return wp.matrix_from_rows(abs_vec(R[0]), abs_vec(R[1]), abs_vec(R[2]))


@wp.func
def posed_box(pose: Pose, size: wp.mat33d, low: wp.vec3d, high: wp.vec3d):
    """Box around a posed box (`size` = abs_rotation), widened so that rounding cannot shrink it."""
    half = wp.float64(0.5)
    centre = pose.R * (half * (low + high)) + pose.t
    extent = size * (half * (high - low)) + wp.vec3d(SLACK, SLACK, SLACK)
    box = AlignedBox()
    box.low = centre - extent
    box.high = centre + extent
    return box


@wp.func
def aabbs_overlap(a: AlignedBox, low: wp.vec3d, high: wp.vec3d):
    """Overlap or touch of a box with the box (low, high)."""
    if a.low[0] > high[0] or low[0] > a.high[0]:
        return False
    if a.low[1] > high[1] or low[1] > a.high[1]:
        return False
    return a.low[2] <= high[2] and low[2] <= a.high[2]


@wp.func
def posed_triangle(pose: Pose, t: wp.mat33d):
    """Vertices of a triangle of body b in the frame of body a, on the vertex grid."""
    return wp.matrix_from_rows(
        snap(pose.R * t[0] + pose.t),
        snap(pose.R * t[1] + pose.t),
        snap(pose.R * t[2] + pose.t),
    )


@wp.func
def plane_clears_box(t: wp.mat33d, box: AlignedBox):
    """Certify that a box lies on one side of the plane of a triangle.

    Like predicates.separates: the normal may be rounded in any way, the gap must exceed a bound of
    the error of the projections (at most 8 roundings each, 32 u of their magnitude sum taken).
    """
    half = wp.float64(0.5)
    normal = wp.cross(t[1] - t[0], t[2] - t[0])
    size = abs_vec(normal)
    extent = half * (box.high - box.low)
    centre = wp.dot(normal, half * (box.low + box.high))
    reach = wp.dot(size, extent)
    s0 = wp.dot(normal, t[0])
    s1 = wp.dot(normal, t[1])
    s2 = wp.dot(normal, t[2])
    low = wp.min(s0, wp.min(s1, s2))
    high = wp.max(s0, wp.max(s1, s2))
    gap = wp.max(low - centre, centre - high) - reach
    magnitude = wp.dot(size, wp.max(abs_vec(box.low), abs_vec(box.high)) + abs_vec(t[0]))
    magnitude += wp.dot(size, abs_vec(t[1]) + abs_vec(t[2]))
    return gap > PLANE_ERROR * magnitude + SLACK * (size[0] + size[1] + size[2])


@wp.func
def inverse(pose: Pose):
    """The opposite rigid motion."""
    back = Pose()
    back.R = wp.transpose(pose.R)
    back.t = -(back.R * pose.t)
    return back


@wp.func
def triangle_box(t: wp.mat33d):
    """Exact box of a triangle."""
    box = AlignedBox()
    box.low = wp.min(t[0], wp.min(t[1], t[2]))
    box.high = wp.max(t[0], wp.max(t[1], t[2]))
    return box

"""Chord bounds on the device: poses at the ends of a stretch, and how far a node leaves the chord.

The device side of motion_bounds.py, where the theorem stands.
"""

import warp as wp

from gcodesim.collision.geometry.boxes import inverse
from gcodesim.collision.geometry.closest import ForestArrays
from gcodesim.collision.geometry.device import BIT_EQUAL
from gcodesim.collision.geometry.poses import ChainArrays, PathArrays, Pose, pair_pose

wp.set_module_options(BIT_EQUAL)

RADIAN = wp.constant(wp.float64(0.017453292519943295))
CHORD_ROUNDED_UP = wp.constant(wp.float64(1.0 + 1.0e-12))


@wp.struct
class MotionArrays:
    """Dyadic runs of pieces and the poses at their ends; see motion_bounds.MotionTables.

    Row of level l, run i: level_first[l] + i. Pieces count from `first`.
    """

    first: wp.int32
    end: wp.int32
    level_first: wp.array[wp.int32]
    moved: wp.array2d[wp.float64]
    deviation: wp.array2d[wp.float64]
    knot: wp.array2d[Pose]  # distinct chain, knot
    row: wp.array[wp.int32]  # side -> its row in `knot`


@wp.struct
class Stretch:
    """A run of pieces (part = 1) or a part of one piece; `row` is its row in the motion tables."""

    piece: wp.int32
    row: wp.int32
    part: wp.float64


@wp.kernel
def pose_knots(
    path: PathArrays,
    sides: ChainArrays,
    first: wp.int32,
    count: wp.int32,
    knot_out: wp.array2d[Pose],
):
    """One thread per (side, knot): poses at the ends of pieces; padding repeats the last."""
    side, k = wp.tid()
    piece = first + wp.min(k, count - 1)
    time = path.bounds_ps[piece]
    if k >= count:
        time = path.bounds_ps[piece + 1]
    knot_out[side, k] = pair_pose(path, sides, side, piece, time)


@wp.func
def side_pose(
    path: PathArrays,
    sides: ChainArrays,
    motion: MotionArrays,
    side: wp.int32,
    piece: wp.int32,
    time_ps: wp.int64,
):
    """Pose of one side at a time within a piece, from the table where it lies on a knot."""
    if time_ps == path.bounds_ps[piece]:
        return motion.knot[motion.row[side], piece - motion.first]
    if time_ps == path.bounds_ps[piece + 1]:
        return motion.knot[motion.row[side], piece - motion.first + 1]
    return pair_pose(path, sides, side, piece, time_ps)


@wp.func
def sagitta(path: PathArrays, arc: wp.int32, part: wp.float64):
    """Largest distance from its chord of a part (in path fraction) of an arc: see arc_sagitta."""
    size = path.arc_size[arc]
    angle = wp.abs(size[2]) * RADIAN * part
    radius = wp.max(size[0], size[1])
    grown = wp.abs(size[1] - size[0]) * part
    bent = (radius * angle * angle + wp.float64(2.0) * grown * angle) * wp.float64(0.125)
    return wp.min(bent, wp.float64(2.0) * radius)


@wp.func
def joint_motion(path: PathArrays, motion: MotionArrays, stretch: Stretch, joint: wp.int32):
    """(displacement, deviation from the chord) of a joint over a stretch, bounded from above."""
    moved = motion.moved[stretch.row, joint]
    deviation = motion.deviation[stretch.row, joint]
    if stretch.part < wp.float64(1.0):
        moved = moved * stretch.part
        if deviation > wp.float64(0.0):
            # Not from the chord of the whole arc, in which turn and lift may cancel.
            arc = path.arc[stretch.piece]
            deviation = sagitta(path, arc, stretch.part)
            size = path.arc_size[arc]
            swept = wp.max(size[0], size[1]) * wp.abs(size[2]) * RADIAN
            along = swept + wp.abs(size[1] - size[0]) + wp.length(path.arc_lift[arc])
            moved = along * stretch.part
    return wp.vec2d(moved, deviation)


@wp.func
def side_leaves_chord(
    path: PathArrays,
    sides: ChainArrays,
    forest: ForestArrays,
    motion: MotionArrays,
    side: wp.int32,
    node: wp.int32,
    stretch: Stretch,
):
    """How far any point of a node can leave the chord between the ends of a stretch [mm]."""
    curvature = wp.float64(0.0)
    leaving = wp.float64(0.0)
    turned = wp.float64(0.0)
    lever = forest.lever_first[side] + node * forest.lever_count[side]
    for step in range(sides.first[side], sides.first[side + 1]):
        joint = sides.joint[step]
        m = joint_motion(path, motion, stretch, joint)
        if sides.rotary[joint] == 1:
            rho = forest.lever[lever]
            lever += 1
            curvature += rho * m[0] * (m[0] + wp.float64(2.0) * turned)
            turned += m[0]
            leaving += rho * m[1]
        else:
            curvature += wp.float64(2.0) * turned * m[0]
            leaving += m[1]
    return (curvature * wp.float64(0.125) + leaving) * CHORD_ROUNDED_UP


@wp.func
def relative(a: Pose, b: Pose):
    """Pose of body b in the frame of body a, from their poses in a common frame."""
    back = inverse(a)
    pose = Pose()
    pose.R = back.R * b.R
    pose.t = back.R * b.t + back.t
    return pose

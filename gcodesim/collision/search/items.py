"""Items of the search: two tree nodes over a stretch of time, and what is seen of the stretch."""

import warp as wp

from gcodesim.collision.bodies.keys import pack_contact
from gcodesim.collision.bounds.chords import MotionArrays, Stretch, side_pose
from gcodesim.collision.geometry.closest import ForestArrays, child_nodes
from gcodesim.collision.geometry.device import BIT_EQUAL
from gcodesim.collision.geometry.poses import ChainArrays, PathArrays, Pose, path_fraction_at

wp.set_module_options(BIT_EQUAL)

INSIDE_PIECE = wp.constant(-1)
BETWEEN_SAMPLES = wp.constant(-2)
SETTLED = wp.constant(-3)
"""Levels of an item that is a part of one piece, of one between two samples, and of one of which
nothing is left to look at."""


@wp.struct
class Item:
    """Two nodes over a stretch of time: a run of 2^level pieces, or a part of one piece."""

    a: wp.int32
    b: wp.int32
    piece: wp.int32
    level: wp.int32
    start_ps: wp.int64
    end_ps: wp.int64


@wp.struct
class ItemView:
    """An item's stretch with its halves, and the poses of both sides at start, middle and end.

    `cut` is the sample at which the stretch would be cut, start_ps when there is none inside.
    """

    whole: Stretch
    earlier: Stretch
    later: Stretch
    a0: Pose
    b0: Pose
    a_middle: Pose
    b_middle: Pose
    a1: Pose
    b1: Pose
    middle_ps: wp.int64
    cut_ps: wp.int64


@wp.func
def sample_between(t0: wp.int64, t1: wp.int64, period: wp.int64):
    """A sample strictly between two times, near their middle; t0 when there is none."""
    k = ((t0 + (t1 - t0) / wp.int64(2)) / period) * period
    if k > t0:
        return k
    if k + period < t1:
        return k + period
    return t0


@wp.func
def sample_key(time_ps: wp.int64, period: wp.int64, pair: wp.int32):
    """Key of a contact: the sample a time counts for, ceil(time / period), then the pair."""
    sample = (time_ps + period - wp.int64(1)) / period
    return pack_contact(sample, pair)


@wp.func
def view_run(motion: MotionArrays, pair: wp.int32, item: Item):
    """The view of a run of pieces: poses from the table of knots."""
    view = ItemView()
    knot = item.piece - motion.first
    half = 1 << (item.level - 1)
    view.whole.piece = item.piece
    view.whole.part = wp.float64(1.0)
    view.earlier = view.whole
    view.later = view.whole
    view.whole.row = motion.level_first[item.level] + (knot >> item.level)
    view.earlier.row = motion.level_first[item.level - 1] + (knot >> (item.level - 1))
    view.later.row = view.earlier.row + 1
    view.a0 = motion.knot[motion.row[2 * pair], knot]
    view.b0 = motion.knot[motion.row[2 * pair + 1], knot]
    view.a_middle = motion.knot[motion.row[2 * pair], knot + half]
    view.b_middle = motion.knot[motion.row[2 * pair + 1], knot + half]
    view.a1 = motion.knot[motion.row[2 * pair], knot + 2 * half]
    view.b1 = motion.knot[motion.row[2 * pair + 1], knot + 2 * half]
    return view


@wp.func
def view_part(
    path: PathArrays,
    sides: ChainArrays,
    motion: MotionArrays,
    pair: wp.int32,
    item: Item,
    period: wp.int64,
):
    """The view of a part of one piece; its middle is a sample where one lies inside."""
    view = ItemView()
    piece = item.piece
    t0 = item.start_ps
    t1 = item.end_ps
    view.cut_ps = sample_between(t0, t1, period)
    view.middle_ps = view.cut_ps
    if item.level == BETWEEN_SAMPLES or view.cut_ps == t0:
        view.middle_ps = t0 + (t1 - t0) / wp.int64(2)
    s0 = path_fraction_at(path, piece, t0)
    s_middle = path_fraction_at(path, piece, view.middle_ps)
    s1 = path_fraction_at(path, piece, t1)
    view.whole.piece = piece
    view.whole.row = motion.level_first[0] + piece - motion.first
    view.earlier = view.whole
    view.later = view.whole
    view.whole.part = s1 - s0
    view.earlier.part = s_middle - s0
    view.later.part = s1 - s_middle
    poses = wp.int32(6)
    for k in range(poses):
        # One call in a loop: six copies of it would double the kernel.
        time = wp.where(k < 2, t0, wp.where(k < 4, view.middle_ps, t1))
        pose = side_pose(path, sides, motion, 2 * pair + k % 2, piece, time)
        if k == 0:
            view.a0 = pose
        elif k == 1:
            view.b0 = pose
        elif k == 2:
            view.a_middle = pose
        elif k == 3:
            view.b_middle = pose
        elif k == 4:
            view.a1 = pose
        else:
            view.b1 = pose
    return view


@wp.func
def view_of(
    path: PathArrays,
    sides: ChainArrays,
    motion: MotionArrays,
    pair: wp.int32,
    item: Item,
    period: wp.int64,
):
    """The view of any item."""
    if item.level > 0:
        return view_run(motion, pair, item)
    return view_part(path, sides, motion, pair, item, period)


@wp.func
def half_of(item: Item, second: wp.bool, middle_ps: wp.int64):
    """One half of an item in time."""
    half = item
    if item.level > 0:
        half.level = item.level - 1
        if second:
            half.piece = item.piece + (1 << (item.level - 1))
    elif second:
        half.start_ps = middle_ps
    else:
        half.end_ps = middle_ps
    return half


@wp.func
def child_of(forest: ForestArrays, item: Item, second: wp.bool):
    """One of the two items that the larger node of an item splits into."""
    nodes = child_nodes(forest, item.a, item.b, second)
    child = item
    child.a = nodes[0]
    child.b = nodes[1]
    return child


@wp.func
def is_leaf(forest: ForestArrays, item: Item):
    """Whether both nodes are single triangles."""
    return forest.triangle[item.a] >= 0 and forest.triangle[item.b] >= 0


@wp.func
def is_one_step(item: Item, view: ItemView):
    """Whether an item has no sample inside its stretch."""
    return item.level < 0 and view.cut_ps == item.start_ps


@wp.func
def settled(item: Item):
    """The item with nothing left to look at."""
    result = item
    result.level = SETTLED
    return result


@wp.func
def timed(path: PathArrays, motion: MotionArrays, item: Item):
    """An item with the times of its stretch filled in; a run of one piece becomes that piece."""
    result = item
    if item.level >= 0:
        result.start_ps = path.bounds_ps[item.piece]
        result.end_ps = path.bounds_ps[wp.min(item.piece + (1 << item.level), motion.end)]
        result.level = wp.where(item.level == 0, INSIDE_PIECE, item.level)
    return result

"""The search kernel: proves stretches of time free by chord certificates, tests only what is left.

An item is two tree nodes and a stretch of time. A direction is aimed at the pose in the middle; the
gaps along it at both ends and the bound of motion_bounds.py prove the whole stretch free, or the
stretch is halved while the nodes are apart in the middle, or the larger node is split. Two
triangles over one sample step are left: they are tested exactly at both ends, as the exhaustive
method does, and then halved further to prove the time between the samples. Nothing depends on the
order of items: the first contact is a minimum over (sample, pair), and items after it are dropped.
"""

import warp as wp

from gcodesim.collision.bodies.keys import NO_KEY
from gcodesim.collision.bounds.chords import (
    MotionArrays,
    Stretch,
    relative,
    side_leaves_chord,
)
from gcodesim.collision.geometry.boxes import posed_triangle
from gcodesim.collision.geometry.closest import (
    ForestArrays,
    aim_at_node,
    between_triangles,
    highest,
    node_gap,
)
from gcodesim.collision.geometry.device import BIT_EQUAL
from gcodesim.collision.geometry.poses import ChainArrays, PathArrays, Pose, pair_pose
from gcodesim.collision.geometry.predicates import triangles_touch
from gcodesim.collision.search.items import (
    BETWEEN_SAMPLES,
    INSIDE_PIECE,
    SETTLED,
    Item,
    ItemView,
    child_of,
    half_of,
    is_leaf,
    is_one_step,
    sample_between,
    sample_key,
    settled,
    timed,
    view_of,
)
from gcodesim.constants import DISTANCE_GOOD_TO_MM

# Loops stay loops: unrolled, the kernel is twice as large and no faster.
wp.set_module_options({**BIT_EQUAL, "max_unroll": 2})

STACK_SIZE = 160
STACK = wp.constant(STACK_SIZE)
LEAST_LENGTH = wp.constant(wp.float64(1.0e-12))

MODE_AT_SAMPLES, MODE_AT_ALL_TIMES, MODE_MINIMUM, MODE_APPROACH = 0, 1, 2, 3
AT_SAMPLES = wp.constant(MODE_AT_SAMPLES)
AT_ALL_TIMES = wp.constant(MODE_AT_ALL_TIMES)
MINIMUM = wp.constant(MODE_MINIMUM)
APPROACH = wp.constant(MODE_APPROACH)
"""Prove samples only; prove the time between them too; or, contacts apart, find the smallest
distance, or the first sample step in which the distance falls to free_mm."""

MINIMUM_GOOD_TO = wp.constant(wp.float64(DISTANCE_GOOD_TO_MM))

RESULT_SIZE = 4
BEST = wp.constant(0)
ITEMS = wp.constant(1)
TRIANGLE_TESTS = wp.constant(2)
OVERFLOWS = wp.constant(3)


@wp.struct
class RootArrays:
    """Where the search starts: runs of pieces (level >= 0), or stretches of one piece (-1)."""

    piece: wp.array[wp.int32]
    level: wp.array[wp.int32]
    start_ps: wp.array[wp.int64]
    end_ps: wp.array[wp.int64]
    period_ps: wp.int64
    free_mm: wp.array[wp.float64]  # slot -> a proof must leave more than this; < 0: left out
    touching_mm: wp.float64  # the same where only touches at samples count
    part: wp.float64  # of the smallest distance, which need not be known better
    together: wp.int32  # slot of the smallest distance of all pairs, where only that is wanted
    mode: wp.int32  # see MODE_AT_SAMPLES and its neighbours
    first_pair: wp.int32  # pair of the first column of threads
    stack_limit: wp.int32  # at most STACK_SIZE
    per_root: wp.int32  # 1: a slot of free_mm, near_out and distance_out per root, else per pair


@wp.struct
class Chains:
    """Chains of each pair from body a to b, and of its two sides from their common frame."""

    pairs: ChainArrays
    sides: ChainArrays  # 2 pair: to body a, 2 pair + 1: to body b


@wp.struct
class Proof:
    """Gaps of an item along its direction at start, middle and end, and what they prove.

    `apart` = the middle is free; `free` = the whole stretch is; `distance` = of two leaves.
    """

    gap0: wp.float64
    gap: wp.float64
    gap1: wp.float64
    distance: wp.float64
    apart: wp.bool
    free: wp.bool


@wp.struct
class Aim:
    """A unit direction in the frame of body a, the gap along it, and the distance of two leaves."""

    n: wp.vec3d
    gap: wp.float64
    distance: wp.float64


@wp.func
def leaves_chord(
    path: PathArrays,
    sides: ChainArrays,
    forest: ForestArrays,
    motion: MotionArrays,
    pair: wp.int32,
    item: Item,
    stretch: Stretch,
):
    """How much the gap of an item can fall below what it is at the ends of a stretch [mm]."""
    total = wp.float64(0.0)
    both = wp.int32(2)
    for k in range(both):
        node = wp.where(k == 0, item.a, item.b)
        total += side_leaves_chord(path, sides, forest, motion, 2 * pair + k, node, stretch)
    return total


@wp.func
def side_gap(forest: ForestArrays, a: wp.int32, b: wp.int32, of_a: Pose, of_b: Pose, n: wp.vec3d):
    """Gap of two nodes along n (common frame)."""
    low = wp.dot(n, of_b.t) - highest(forest, b, -(wp.transpose(of_b.R) * n))
    return low - wp.dot(n, of_a.t) - highest(forest, a, wp.transpose(of_a.R) * n)


@wp.func
def aim_item(forest: ForestArrays, item: Item, view: ItemView, wanted: wp.float64):
    """A direction for an item's middle; two leaves with less than `wanted` get their nearest."""
    aim = Aim()
    pose = relative(view.a_middle, view.b_middle)
    aim.n = aim_at_node(forest, item.a, item.b, pose)
    aim.gap = node_gap(forest, item.a, item.b, pose, aim.n)
    aim.distance = wp.float64(1.0e30)
    if forest.triangle[item.a] >= 0 and forest.triangle[item.b] >= 0 and aim.gap <= wanted:
        own = forest.triangles[forest.triangle[item.a]]
        posed = posed_triangle(pose, forest.triangles[forest.triangle[item.b]])
        v = between_triangles(own, posed)
        aim.distance = wp.length(v)
        if aim.distance > LEAST_LENGTH:
            n = v / aim.distance
            gap = node_gap(forest, item.a, item.b, pose, n)
            if gap > aim.gap:
                aim.n = n
                aim.gap = gap
    return aim


@wp.func
def touch_at(
    path: PathArrays,
    pairs: ChainArrays,
    forest: ForestArrays,
    pair: wp.int32,
    item: Item,
    time_ps: wp.int64,
):
    """The exact test of two leaves at one instant, posed as the exhaustive method poses them."""
    owner = item.piece
    if time_ps == path.bounds_ps[owner] and owner > 0:
        owner = owner - 1
    pose = pair_pose(path, pairs, pair, owner, time_ps)
    other = posed_triangle(pose, forest.triangles[forest.triangle[item.b]])
    return triangles_touch(forest.triangles[forest.triangle[item.a]], other)


@wp.func
def root_item(forest: ForestArrays, roots: RootArrays, root: wp.int32, pair: wp.int32):
    """The item of a root and a pair."""
    item = Item()
    item.a = forest.root[2 * pair]
    item.b = forest.root[2 * pair + 1]
    item.piece = roots.piece[root]
    item.level = roots.level[root]
    item.start_ps = roots.start_ps[root]
    item.end_ps = roots.end_ps[root]
    return item


@wp.func
def prove(
    path: PathArrays,
    chains: Chains,
    forest: ForestArrays,
    motion: MotionArrays,
    pair: wp.int32,
    item: Item,
    view: ItemView,
    free: wp.float64,
):
    """Aim at an item and try to prove its whole stretch free."""
    proof = Proof()
    leaving = leaves_chord(path, chains.sides, forest, motion, pair, item, view.whole)
    aim = aim_item(forest, item, view, free + wp.float64(2.0) * leaving)
    proof.distance = aim.distance
    proof.gap = aim.gap
    proof.apart = aim.gap > free
    if proof.apart:
        n = view.a_middle.R * aim.n
        proof.gap0 = side_gap(forest, item.a, item.b, view.a0, view.b0, n)
        proof.gap1 = side_gap(forest, item.a, item.b, view.a1, view.b1, n)
        proof.free = wp.min(proof.gap0, proof.gap1) > leaving + free
    return proof


@wp.func
def push_halves(
    path: PathArrays,
    chains: Chains,
    forest: ForestArrays,
    motion: MotionArrays,
    pair: wp.int32,
    item: Item,
    view: ItemView,
    proof: Proof,
    free: wp.float64,
    stack: wp.array[Item],
    top: wp.int32,
):
    """Push the halves in time that the gaps at hand leave unproved; the new top of the stack.

    The later half lies lower, so that time runs forwards.
    """
    later = leaves_chord(path, chains.sides, forest, motion, pair, item, view.later)
    earlier = leaves_chord(path, chains.sides, forest, motion, pair, item, view.earlier)
    if not proof.apart or wp.min(proof.gap, proof.gap1) <= later + free:
        stack[top] = half_of(item, True, view.middle_ps)
        top += 1
    if not proof.apart or wp.min(proof.gap0, proof.gap) <= earlier + free:
        stack[top] = half_of(item, False, view.middle_ps)
        top += 1
    return top


@wp.func
def clipped(
    path: PathArrays,
    motion: MotionArrays,
    item: Item,
    best: wp.int64,
    period: wp.int64,
    pair: wp.int32,
):
    """The item with its times, without later halves that begin after the first contact known.

    SETTLED where nothing of it is left.
    """
    if item.piece >= motion.end:
        return settled(item)
    cut = timed(path, motion, item)
    if sample_key(cut.start_ps, period, pair) >= best:
        return settled(cut)
    while cut.level > 0:
        middle = path.bounds_ps[wp.min(cut.piece + (1 << (cut.level - 1)), motion.end)]
        if sample_key(middle, period, pair) < best:
            break
        cut.level -= 1
        cut.end_ps = middle
    if cut.level == 0:
        cut.level = INSIDE_PIECE
    while cut.level == INSIDE_PIECE:
        middle = sample_between(cut.start_ps, cut.end_ps, period)
        if middle == cut.start_ps or sample_key(middle, period, pair) < best:
            break
        cut.end_ps = middle
    return cut


@wp.func
def centre_gap(forest: ForestArrays, item: Item, view: ItemView):
    """Distance of the centres of two nodes in the middle, less their sizes [mm]."""
    at_a = view.a_middle.R * forest.centre[item.a] + view.a_middle.t
    at_b = view.b_middle.R * forest.centre[item.b] + view.b_middle.t
    return wp.length(at_a - at_b) - forest.size[item.a] - forest.size[item.b]


@wp.func
def push_children(
    forest: ForestArrays, item: Item, view: ItemView, stack: wp.array[Item], top: wp.int32
):
    """Push the two halves in space, the nearer on top: a contact found early drops the rest."""
    first = centre_gap(forest, child_of(forest, item, False), view)
    nearer = first <= centre_gap(forest, child_of(forest, item, True), view)
    stack[top] = child_of(forest, item, nearer)
    stack[top + 1] = child_of(forest, item, not nearer)
    return top + 2


@wp.func
def push_parts(
    path: PathArrays,
    chains: Chains,
    forest: ForestArrays,
    motion: MotionArrays,
    pair: wp.int32,
    item: Item,
    view: ItemView,
    proof: Proof,
    free: wp.float64,
    stack: wp.array[Item],
    top: wp.int32,
):
    """Push what is left of an item, halved in time or in space; the new top of the stack."""
    if is_leaf(forest, item) or (proof.apart and not is_one_step(item, view)):
        return push_halves(path, chains, forest, motion, pair, item, view, proof, free, stack, top)
    return push_children(forest, item, view, stack, top)


@wp.func
def touch_middle(
    path: PathArrays,
    pairs: ChainArrays,
    forest: ForestArrays,
    motion: MotionArrays,
    pair: wp.int32,
    item: Item,
    view: ItemView,
    period: wp.int64,
):
    """Key of a touch of two leaves at the sample or block end in the middle of a long stretch.

    They would be tested there in the end; tested now, a touch drops everything after it.
    """
    middle = half_of(item, True, view.middle_ps)
    if middle.piece >= motion.end:
        return NO_KEY
    if item.level > 0:
        middle.start_ps = path.bounds_ps[middle.piece]
    if touch_at(path, pairs, forest, pair, middle, middle.start_ps):
        return sample_key(middle.start_ps, period, pair)
    return NO_KEY


@wp.func
def touch_ends(
    path: PathArrays,
    pairs: ChainArrays,
    forest: ForestArrays,
    pair: wp.int32,
    item: Item,
    period: wp.int64,
):
    """Key of the first touch of two leaves at the ends of one sample step."""
    ends = wp.int32(2)
    for k in range(ends):
        time = wp.where(k == 0, item.start_ps, item.end_ps)
        if touch_at(path, pairs, forest, pair, item, time):
            return sample_key(time, period, pair)
    return NO_KEY


@wp.func
def level_after_tests(
    path: PathArrays,
    pairs: ChainArrays,
    forest: ForestArrays,
    motion: MotionArrays,
    roots: RootArrays,
    pair: wp.int32,
    item: Item,
    view: ItemView,
    apart: wp.bool,
    result_out: wp.array[wp.int64],
):
    """Test two leaves exactly where they may touch at a sample; the level at which to go on.

    Over one sample step that is its two ends, and then the time between them; SETTLED where that
    need not be looked at.
    """
    at_samples = roots.mode <= AT_ALL_TIMES
    if not is_one_step(item, view):
        if at_samples and not apart:
            key = touch_middle(path, pairs, forest, motion, pair, item, view, roots.period_ps)
            wp.atomic_min(result_out, BEST, key)
        return item.level
    if item.level != INSIDE_PIECE or roots.mode == MINIMUM:
        return item.level
    if at_samples:
        wp.atomic_add(result_out, TRIANGLE_TESTS, wp.int64(2))
        key = touch_ends(path, pairs, forest, pair, item, roots.period_ps)
        wp.atomic_min(result_out, BEST, key)
        if key < NO_KEY or roots.mode == AT_SAMPLES:
            return SETTLED
    return BETWEEN_SAMPLES


@wp.func
def distance_to_prove(
    roots: RootArrays, slot: wp.int32, after_near: wp.bool, distance: wp.array[wp.float64]
):
    """What a proof must leave: less than the smallest distance known, when that is looked for.

    After the first near step only a touch at a sample counts.
    """
    if roots.mode == MINIMUM:
        smallest = distance[slot]
        if roots.together >= 0:
            smallest = wp.min(smallest, distance[roots.together])
        return smallest - wp.max(MINIMUM_GOOD_TO, roots.part * smallest)
    if roots.mode == AT_ALL_TIMES and after_near:
        return roots.touching_mm
    return roots.free_mm[slot]


@wp.func
def keep_smallest(
    roots: RootArrays, slot: wp.int32, distance: wp.float64, distance_out: wp.array[wp.float64]
):
    """Enter a distance in its slot, and in the one of all pairs."""
    wp.atomic_min(distance_out, slot, distance)
    if roots.together >= 0:
        wp.atomic_min(distance_out, roots.together, distance)


@wp.kernel
def search_roots(
    path: PathArrays,
    chains: Chains,
    forest: ForestArrays,
    motion: MotionArrays,
    roots: RootArrays,
    near_out: wp.array[wp.int64],
    distance_out: wp.array[wp.float64],
    result_out: wp.array[wp.int64],
):
    """One thread per (root, pair), with a short stack of items of its own.

    near_out: start of the first sample step in which the distance falls to free_mm [ps];
    distance_out: smallest distance (mode MINIMUM) [mm]; result_out: see BEST and the others.
    """
    root, column = wp.tid()
    pair = roots.first_pair + column
    slot = wp.where(roots.per_root == 1, root, pair)
    period = roots.period_ps
    if roots.free_mm[slot] < wp.float64(0.0):
        return
    stack = wp.zeros(shape=(STACK,), dtype=Item)
    stack[0] = root_item(forest, roots, root, pair)
    top = wp.int32(1)
    items = wp.int64(0)
    while top > 0:
        top -= 1
        item = clipped(path, motion, stack[top], result_out[BEST], period, pair)
        if item.level == SETTLED:
            continue
        step = wp.max(path.bounds_ps[item.piece], (item.start_ps / period) * period)
        after_near = near_out[slot] <= step
        if after_near and (item.level == BETWEEN_SAMPLES or roots.mode == APPROACH):
            continue
        items += wp.int64(1)
        free = distance_to_prove(roots, slot, after_near, distance_out)
        view = view_of(path, chains.sides, motion, pair, item, period)
        proof = prove(path, chains, forest, motion, pair, item, view, free)
        if roots.mode == MINIMUM:
            keep_smallest(roots, slot, proof.distance, distance_out)
        if proof.free:
            continue
        leaf = is_leaf(forest, item)
        if leaf:
            item.level = level_after_tests(
                path, chains.pairs, forest, motion, roots, pair, item, view, proof.apart, result_out
            )
        instant = item.end_ps - item.start_ps <= wp.int64(1)
        if item.level == BETWEEN_SAMPLES and (instant or not proof.apart):
            wp.atomic_min(near_out, slot, step)
            continue
        if item.level == SETTLED or (leaf and instant):
            continue
        if top + 2 > roots.stack_limit:
            wp.atomic_add(result_out, OVERFLOWS, wp.int64(1))
            break
        top = push_parts(path, chains, forest, motion, pair, item, view, proof, free, stack, top)
    wp.atomic_add(result_out, ITEMS, items)

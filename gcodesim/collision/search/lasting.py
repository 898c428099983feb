"""Lasting contacts: at which of many instants a pair touches, by crossings that outlast a motion.

Theorem (lasting crossing). An edge p q crosses a triangle at x; h_p and h_q are the heights of its
ends above the plane of the triangle, of opposite signs, m is the distance of x from the border of
the triangle and s = (|h_p| + |h_q|) / |p q| the sine of the edge with the plane. If then no point
of the edge moves by more than d relative to the triangle and d < min(|h_p|, |h_q|, m s), the edge
still crosses it. (The ends keep their sides. The point of the moved edge in the plane comes from a
point z of the edge by a step w, |w| <= d, and z lies at the height -h(w): it is x - w' with
w' = w - (h(w) / s) u, u along the edge, and |w'| <= d / s < m.)

How far the bodies move from instant to instant is bounded by what the joints between them travel,
times the levers of the two triangles, which reach as far as the edge is long.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import warp as wp
from numpy.typing import NDArray

from gcodesim.collision.bodies.scene import SceneArrays
from gcodesim.collision.bounds.chords import MotionArrays, Stretch, joint_motion
from gcodesim.collision.geometry.boxes import posed_triangle
from gcodesim.collision.geometry.closest import ForestArrays, aim_at_node, child_nodes, node_gap
from gcodesim.collision.geometry.device import BIT_EQUAL, lent
from gcodesim.collision.geometry.poses import (
    ChainArrays,
    PathArrays,
    Pose,
    pair_pose,
    path_fraction_at,
)
from gcodesim.collision.instants.touches import InstantArrays, bodies_touch, instant_arrays
from gcodesim.collision.search.search import Searcher
from gcodesim.collision.search.search_kernel import Chains
from gcodesim.constants import CROSSING_SLACK_MM
from gcodesim.motion.samples import Instants

wp.set_module_options({**BIT_EQUAL, "max_unroll": 2})

RUN = 512
"""Instants that one thread follows in the order of time."""

RUN_LENGTH = wp.constant(RUN)

STACK = wp.constant(160)
LOOKS = wp.constant(300)
"""Pairs of nodes looked at for a crossing; where none is found the exact test decides."""

FLAT = wp.constant(wp.float64(1.0e-6))
"""Triangles with a height below this part of their longest edge have no normal to rely on."""

SLACK = wp.constant(wp.float64(CROSSING_SLACK_MM))


@wp.struct
class Crossing:
    """Two leaves whose triangles cross.

    `margin`: how far the bodies may move against each other [mm], 0 = nothing is known; `reach`:
    the longest edge of both [mm].
    """

    nodes: wp.vec2i
    margin: wp.float64
    reach: wp.float64


@wp.func
def edge_margin(p: wp.vec3d, q: wp.vec3d, t: wp.mat33d):
    """How far the ends of an edge may move while it goes on to cross a triangle; 0 or less: none.

    The theorem at the top.
    """
    normal = wp.cross(t[1] - t[0], t[2] - t[0])
    area = wp.length(normal)
    longest = wp.max(wp.length(t[1] - t[0]), wp.max(wp.length(t[2] - t[1]), wp.length(t[0] - t[2])))
    if area <= FLAT * longest * longest:
        return wp.float64(0.0)
    normal = normal / area
    above = wp.dot(normal, p - t[0])
    below = wp.dot(normal, q - t[0])
    if above * below >= wp.float64(0.0):
        return wp.float64(0.0)
    x = p + (above / (above - below)) * (q - p)
    inside = longest
    for k in range(3):
        side = t[(k + 1) % 3] - t[k]
        inside = wp.min(inside, wp.dot(wp.cross(normal, side), x - t[k]) / wp.length(side))
    steep = wp.abs(above - below) / wp.length(q - p)
    return wp.min(inside * steep, wp.min(wp.abs(above), wp.abs(below)))


@wp.func
def leaf_crossing(forest: ForestArrays, nodes: wp.vec2i, pose: Pose):
    """The crossing of two leaves."""
    own = forest.triangles[forest.triangle[nodes[0]]]
    other = posed_triangle(pose, forest.triangles[forest.triangle[nodes[1]]])
    crossing = Crossing()
    crossing.nodes = nodes
    for k in range(3):
        p = own[k]
        q = own[(k + 1) % 3]
        u = other[k]
        v = other[(k + 1) % 3]
        margin = wp.max(edge_margin(p, q, other), edge_margin(u, v, own))
        crossing.margin = wp.max(crossing.margin, margin)
        crossing.reach = wp.max(crossing.reach, wp.max(wp.length(q - p), wp.length(v - u)))
    return crossing


@wp.func
def overlap(forest: ForestArrays, nodes: wp.vec2i, pose: Pose):
    """Sizes of two nodes, less the distance of their centres [mm]; below 0 they are apart."""
    way = pose.R * forest.centre[nodes[1]] + pose.t - forest.centre[nodes[0]]
    return forest.size[nodes[0]] + forest.size[nodes[1]] - wp.length(way)


@wp.func
def are_apart(forest: ForestArrays, nodes: wp.vec2i, pose: Pose):
    """Tell whether the direction aimed at them separates two nodes."""
    n = aim_at_node(forest, nodes[0], nodes[1], pose)
    return node_gap(forest, nodes[0], nodes[1], pose, n) > wp.float64(0.0)


@wp.func
def best_crossing(forest: ForestArrays, pair: wp.int32, pose: Pose):
    """The crossing with the largest margin among the first that are met."""
    stack = wp.zeros(shape=(STACK,), dtype=wp.vec2i)
    stack[0] = wp.vec2i(forest.root[2 * pair], forest.root[2 * pair + 1])
    top = wp.int32(1)
    best = Crossing()
    looks = wp.int32(0)
    while top > 0 and looks < LOOKS:
        top -= 1
        looks += 1
        nodes = stack[top]
        if are_apart(forest, nodes, pose):
            continue
        if forest.triangle[nodes[0]] >= 0 and forest.triangle[nodes[1]] >= 0:
            crossing = leaf_crossing(forest, nodes, pose)
            if crossing.margin > best.margin:
                best = crossing
            continue
        if top + 2 > STACK:
            continue
        first = child_nodes(forest, nodes[0], nodes[1], False)
        second = child_nodes(forest, nodes[0], nodes[1], True)
        deeper = overlap(forest, first, pose) >= overlap(forest, second, pose)
        stack[top] = wp.where(deeper, second, first)
        stack[top + 1] = wp.where(deeper, first, second)
        top += 2
    return best


@wp.func
def side_moves(
    path: PathArrays,
    sides: ChainArrays,
    forest: ForestArrays,
    motion: MotionArrays,
    side: wp.int32,
    node: wp.int32,
    stretch: Stretch,
    reach: wp.float64,
):
    """Way of any point within `reach` of a node along a stretch, bounded from above [mm]."""
    way = wp.float64(0.0)
    lever = forest.lever_first[side] + node * forest.lever_count[side]
    for step in range(sides.first[side], sides.first[side + 1]):
        joint = sides.joint[step]
        moved = joint_motion(path, motion, stretch, joint)[0]
        if sides.rotary[joint] == 1:
            way += (forest.lever[lever] + reach) * moved
            lever += 1
        else:
            way += moved
    return way


@wp.func
def moves_between(
    path: PathArrays,
    chains: Chains,
    forest: ForestArrays,
    motion: MotionArrays,
    pair: wp.int32,
    crossing: Crossing,
    instants: InstantArrays,
    i: wp.int32,
):
    """How far two leaves move against each other from an instant to the next, i [mm]."""
    piece = instants.piece[i]
    before = wp.max(instants.time_ps[i - 1], path.bounds_ps[piece])
    stretch = Stretch()
    stretch.piece = piece
    stretch.row = motion.level_first[0] + piece - motion.first
    stretch.part = path_fraction_at(path, piece, instants.time_ps[i])
    stretch.part -= path_fraction_at(path, piece, before)
    way = wp.float64(0.0)
    for k in range(2):
        way += side_moves(
            path,
            chains.sides,
            forest,
            motion,
            2 * pair + k,
            crossing.nodes[k],
            stretch,
            crossing.reach,
        )
    return way


@wp.struct
class Followed:
    """What of the instants is looked at: of one pair, `count` instants, RUN to a thread."""

    pair: wp.int32
    count: wp.int32
    first_run: wp.int32


@wp.kernel
def follow_touches(
    path: PathArrays,
    chains: Chains,
    forest: ForestArrays,
    motion: MotionArrays,
    scene: SceneArrays,
    instants: InstantArrays,
    followed: Followed,
    touch_out: wp.array[wp.int8],
):
    """One thread per run of instants: 1 where the pair touches."""
    run = followed.first_run + wp.tid()
    pair = followed.pair
    crossing = Crossing()
    for i in range(run * RUN_LENGTH, wp.min((run + 1) * RUN_LENGTH, followed.count)):
        if crossing.margin > SLACK:
            crossing.margin -= moves_between(
                path, chains, forest, motion, pair, crossing, instants, i
            )
        if crossing.margin <= SLACK:
            pose = pair_pose(path, chains.pairs, pair, instants.piece[i], instants.time_ps[i])
            crossing = best_crossing(forest, pair, pose)
            if crossing.margin <= SLACK and not bodies_touch(scene, pair, pose).touch:
                continue
        touch_out[i] = wp.int8(1)


def touches_at(searcher: Searcher, instants: Instants, pair: int) -> NDArray[np.bool_]:
    """Tell at which instants a pair touches, shape (m,).

    Args:
        searcher: of the scene and the path.
        instants: samples and ends of pieces in the order of time, none left out between the first
            and the last but where nothing moves.
        pair: number of the pair.
    """
    scene = searcher.scene
    flags = np.zeros(len(instants), np.int8)
    motion = searcher.motion(int(instants.piece[0]), int(instants.piece[-1]) + 1)
    chains = Chains()
    chains.pairs, chains.sides = scene.chains, searcher.forest.sides
    arrays, out = instant_arrays(instants, scene.device), lent(flags, wp.int8, scene.device)
    runs = -(-len(instants) // RUN)

    def follow(first: int, end: int) -> None:
        followed = Followed()
        followed.pair, followed.count, followed.first_run = pair, len(instants), first
        wp.launch(
            follow_touches,
            dim=end - first,
            inputs=[
                searcher.arrays,
                chains,
                searcher.forest.arrays,
                motion,
                scene.arrays,
                arrays,
                followed,
            ],
            outputs=[out],
            device=scene.device,
        )

    threads = min(searcher.settings.threads, runs) if scene.device == "cpu" else 1
    cuts = np.linspace(0, runs, threads + 1).astype(int).tolist()
    if threads > 1:
        with ThreadPoolExecutor(threads) as pool:
            list(pool.map(follow, cuts[:-1], cuts[1:]))
    else:
        follow(0, runs)
    return np.asarray(out.numpy() != 0)

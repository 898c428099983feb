"""The nearest triangles of every pair at single instants, by a walk down both trees."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import warp as wp
from numpy.typing import NDArray

from gcodesim.collision.bodies.scene import Scene
from gcodesim.collision.geometry.boxes import posed_triangle
from gcodesim.collision.geometry.closest import (
    ForestArrays,
    aim_at_node,
    between_triangles,
    child_nodes,
    node_gap,
)
from gcodesim.collision.geometry.device import BIT_EQUAL, lent
from gcodesim.collision.geometry.poses import ChainArrays, PathArrays, Pose, pair_pose
from gcodesim.collision.geometry.predicates import triangles_touch
from gcodesim.collision.instants.posed_pair import FARTHEST
from gcodesim.constants import DISTANCE_GOOD_TO_MM

wp.set_module_options({**BIT_EQUAL, "max_unroll": 2})

GOOD_TO = wp.constant(wp.float64(DISTANCE_GOOD_TO_MM))
STACK = wp.constant(160)
UNDECIDED = wp.constant(wp.float64(-1.0))


@wp.func
def apart(forest: ForestArrays, nodes: wp.vec2i, pose: Pose):
    """Distance of the centres of two nodes, less their sizes [mm]."""
    a, b = nodes[0], nodes[1]
    at_b = pose.R * forest.centre[b] + pose.t
    return wp.length(forest.centre[a] - at_b) - forest.size[a] - forest.size[b]


@wp.kernel
def find_nearest_triangles(
    path: PathArrays,
    chains: ChainArrays,
    forest: ForestArrays,
    piece: wp.array[wp.int32],
    time_ps: wp.array[wp.int64],
    distance_out: wp.array2d[wp.float64],
    triangles_out: wp.array2d[wp.vec2i],
    steps_out: wp.array2d[wp.int32],
):
    """One thread per (instant, pair): smallest distance, 0 for a touch, and of which triangles."""
    instant, pair = wp.tid()
    pose = pair_pose(path, chains, pair, piece[instant], time_ps[instant])
    stack = wp.zeros(shape=(STACK,), dtype=wp.vec2i)
    stack[0] = wp.vec2i(forest.root[2 * pair], forest.root[2 * pair + 1])
    top = wp.int32(1)
    steps = wp.int32(0)
    best = FARTHEST
    chosen = wp.vec2i()
    while top > 0:
        top -= 1
        steps += 1
        nodes = stack[top]
        n = aim_at_node(forest, nodes[0], nodes[1], pose)
        # Along no direction at all the gap is 0: what overlaps is always looked into.
        enough = wp.max(best - GOOD_TO, wp.float64(0.0))
        if node_gap(forest, nodes[0], nodes[1], pose, n) > enough:
            continue
        rows = wp.vec2i(forest.triangle[nodes[0]], forest.triangle[nodes[1]])
        if rows[0] >= 0 and rows[1] >= 0:
            own = forest.triangles[rows[0]]
            other = posed_triangle(pose, forest.triangles[rows[1]])
            distance = wp.length(between_triangles(own, other))
            if triangles_touch(own, other):
                distance = wp.float64(0.0)
                top = wp.int32(0)
            if distance < best:
                best = distance
                chosen = rows
            continue
        if top + 2 > STACK:
            best = UNDECIDED
            break
        first = child_nodes(forest, nodes[0], nodes[1], False)
        second = child_nodes(forest, nodes[0], nodes[1], True)
        nearer = apart(forest, first, pose) <= apart(forest, second, pose)
        stack[top] = wp.where(nearer, second, first)
        stack[top + 1] = wp.where(nearer, first, second)
        top += 2
    distance_out[instant, pair] = best
    triangles_out[instant, pair] = chosen
    steps_out[instant, pair] = steps


@dataclass(frozen=True)
class NearestTriangles:
    """What is nearest at m instants, of p pairs.

    Attributes:
        distance: [mm], at most DISTANCE_GOOD_TO_MM too large; 0 for a touch, NaN where the stack
            of the walk was full; shape (m, p).
        triangles: rows of both triangles in `forest.triangles`, shape (m, p, 2).
        steps: of all walks together.
    """

    distance: NDArray[np.float64]
    triangles: NDArray[np.int32]
    steps: int


def nearest_triangles(
    scene: Scene,
    forest: ForestArrays,
    path: PathArrays,
    piece: NDArray[np.int32],
    time_ps: NDArray[np.int64],
) -> NearestTriangles:
    """Walk down the trees of every pair of a scene at some times, each within its piece."""
    shape = (len(time_ps), len(scene.pairs))
    distance = wp.empty(shape, dtype=wp.float64, device=scene.device)
    triangles = wp.empty(shape, dtype=wp.vec2i, device=scene.device)
    steps = wp.empty(shape, dtype=wp.int32, device=scene.device)
    wp.launch(
        find_nearest_triangles,
        dim=shape,
        inputs=[
            path,
            scene.chains,
            forest,
            lent(piece, wp.int32, scene.device),
            lent(time_ps, wp.int64, scene.device),
        ],
        outputs=[distance, triangles, steps],
        device=scene.device,
    )
    found = distance.numpy()
    known = np.where(found < 0.0, np.nan, found)
    return NearestTriangles(known, triangles.numpy(), int(steps.numpy().sum()))

"""Depths: how far a point of one body lies inside the other, and how much deeper it may be.

The points are all vertices, and some along every edge that pierces the other body more than once:
a plate that a tool goes through has no vertex inside it, and the tool none inside the plate.
At an instant the depth is found by a walk down the tree of a body: no vertex below a node lies
deeper than the centre of the node does, plus the size of the node. Between two instants it cannot
grow by more than the bodies move against each other: where d and e are the depths at two instants
between which they move by w, it stays below (d + e + w) / 2. Instants are added where that leaves
most, until it leaves little or they are many; what it leaves is stated. Nothing is deeper inside a
body than half the least width of its box: the ball around it would not fit.
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
import warp as wp
from numpy.typing import NDArray

from gcodesim.collision.bodies.scene import Scene, whole_scene
from gcodesim.collision.bounds.forest import Forest, build_forest
from gcodesim.collision.bounds.motion_bounds import piece_ways
from gcodesim.collision.geometry.boxes import inverse
from gcodesim.collision.geometry.closest import ForestArrays, clamp_to_box, nearest_on_triangle
from gcodesim.collision.geometry.device import BIT_EQUAL, lent
from gcodesim.collision.geometry.poses import ChainArrays, PathArrays, pair_pose
from gcodesim.machine.model import Joint
from gcodesim.motion.path import Path, path_fraction

wp.set_module_options({**BIT_EQUAL, "max_unroll": 2})

Floats = NDArray[np.float64]
Times = NDArray[np.int64]

FIRST_INSTANTS, ROUNDS, ADDED = 5, 4, 4
"""Instants of an interval looked at in the beginning, how often more are, and how many at once."""

GOOD_TO_MM = 0.01
"""[mm] Depths are not told apart further, neither at an instant nor between two."""

STACK = wp.constant(96)
GOOD_TO = wp.constant(wp.float64(GOOD_TO_MM))
FAR = wp.constant(wp.float64(1.0e30))
TINY = wp.constant(wp.float64(1.0e-300))
POINTS_BETWEEN = wp.constant(3)
RAY = wp.constant(wp.vec3d(9.0 / 25.0, 12.0 / 25.0, 20.0 / 25.0))
"""Way along which surfaces are counted: along none that a model's edges are likely to have."""


@wp.struct
class Asked:
    """Instants at which the depth is asked for, and the roots of both trees."""

    piece: wp.array[wp.int32]
    time_ps: wp.array[wp.int64]
    pair: wp.int32


@wp.func
def box_distance(forest: ForestArrays, node: wp.int32, p: wp.vec3d):
    """Distance of a point from the box of a node [mm]."""
    q = forest.frame[node] * (p - forest.centre[node])
    return wp.length(q - clamp_to_box(q, forest.extent[node]))


@wp.func
def surface_distance(forest: ForestArrays, root: wp.int32, p: wp.vec3d):
    """Distance of a point from the triangles of a tree [mm]."""
    stack = wp.zeros(shape=(STACK,), dtype=wp.int32)
    stack[0] = root
    top = wp.int32(1)
    best = FAR
    while top > 0:
        top -= 1
        node = stack[top]
        if box_distance(forest, node, p) >= best:
            continue
        if forest.triangle[node] >= 0:
            t = forest.triangles[forest.triangle[node]]
            best = wp.min(best, wp.length(nearest_on_triangle(t[0] - p, t[1] - p, t[2] - p)))
            continue
        left = forest.left[node]
        right = forest.right[node]
        nearer = box_distance(forest, left, p) <= box_distance(forest, right, p)
        if top + 2 <= STACK:
            stack[top] = wp.where(nearer, right, left)
            stack[top + 1] = wp.where(nearer, left, right)
            top += 2
    return best


@wp.func
def ray_crossing(t: wp.mat33d, p: wp.vec3d):
    """+1 or -1 where the ray from a point leaves or enters through a triangle, else 0."""
    a = t[0] - p
    b = t[1] - p
    c = t[2] - p
    u = wp.dot(RAY, wp.cross(a, b))
    v = wp.dot(RAY, wp.cross(b, c))
    w = wp.dot(RAY, wp.cross(c, a))
    zero = wp.float64(0.0)
    all_up = u >= zero and v >= zero and w >= zero
    all_down = u <= zero and v <= zero and w <= zero
    if all_up == all_down:
        return 0
    normal = wp.cross(b - a, c - a)
    along = wp.dot(normal, RAY)
    if along * wp.dot(normal, a) <= zero:
        return 0
    return wp.where(along > zero, 1, -1)


@wp.func
def is_inside(forest: ForestArrays, root: wp.int32, p: wp.vec3d):
    """Tell whether the closed surfaces of a tree wrap around a point."""
    stack = wp.zeros(shape=(STACK,), dtype=wp.int32)
    stack[0] = root
    top = wp.int32(1)
    winding = wp.int32(0)
    while top > 0:
        top -= 1
        node = stack[top]
        way = forest.centre[node] - p
        along = wp.dot(way, RAY)
        size = forest.size[node]
        if along < -size or wp.length(way - along * RAY) > size:
            continue
        if forest.triangle[node] >= 0:
            winding += ray_crossing(forest.triangles[forest.triangle[node]], p)
            continue
        if top + 2 <= STACK:
            stack[top] = forest.left[node]
            stack[top + 1] = forest.right[node]
            top += 2
    return winding != 0


@wp.func
def signed_depth(forest: ForestArrays, root: wp.int32, p: wp.vec3d):
    """Distance of a point from a body's surface, below 0 outside [mm]."""
    outside = box_distance(forest, root, p)
    if outside > wp.float64(0.0):
        return -outside
    distance = surface_distance(forest, root, p)
    return wp.where(is_inside(forest, root, p), distance, -distance)


@wp.kernel
def measure_depths(
    path: PathArrays,
    chains: ChainArrays,
    forest: ForestArrays,
    asked: Asked,
    depth_out: wp.array2d[wp.float64],
):
    """One thread per (instant, side): depth of the side's deepest vertex inside the other body."""
    instant, side = wp.tid()
    pose = pair_pose(path, chains, asked.pair, asked.piece[instant], asked.time_ps[instant])
    if side == 0:
        pose = inverse(pose)
    other = forest.root[2 * asked.pair + 1 - side]
    stack = wp.zeros(shape=(STACK,), dtype=wp.int32)
    stack[0] = forest.root[2 * asked.pair + side]
    top = wp.int32(1)
    best = wp.float64(0.0)
    while top > 0:
        top -= 1
        node = stack[top]
        if forest.triangle[node] >= 0:
            t = forest.triangles[forest.triangle[node]]
            for k in range(3):
                best = wp.max(best, signed_depth(forest, other, pose.R * t[k] + pose.t))
            continue
        centre = pose.R * forest.centre[node] + pose.t
        if signed_depth(forest, other, centre) + forest.size[node] <= best + GOOD_TO:
            continue
        if top + 2 <= STACK:
            stack[top] = forest.left[node]
            stack[top + 1] = forest.right[node]
            top += 2
    depth_out[instant, side] = best


@wp.func
def pierced_at(p: wp.vec3d, along: wp.vec3d, t: wp.mat33d):
    """How far along an edge it pierces a triangle, 0..1; -1 where it does not."""
    u = t[1] - t[0]
    v = t[2] - t[0]
    across = wp.cross(along, v)
    size = wp.dot(u, across)
    none = wp.float64(0.0)
    one = wp.float64(1.0)
    if size == none:
        return wp.float64(-1.0)
    corner = p - t[0]
    turned = wp.cross(corner, u)
    first = wp.dot(corner, across) / size
    second = wp.dot(along, turned) / size
    place = wp.dot(v, turned) / size
    if first < none or second < none or first + second > one or place < none or place > one:
        return wp.float64(-1.0)
    return place


@wp.func
def between_piercings(
    forest: ForestArrays, root: wp.int32, p: wp.vec3d, along: wp.vec3d, known: wp.float64
):
    """The deepest of some points between the first and last place where an edge pierces a body.

    Not looked at where it cannot exceed the depth that is known: the ball around a point as deep as
    that would hold both places.
    """
    stack = wp.zeros(shape=(STACK,), dtype=wp.int32)
    stack[0] = root
    top = wp.int32(1)
    first = wp.float64(2.0)
    last = wp.float64(-1.0)
    length = wp.max(wp.dot(along, along), TINY)
    while top > 0:
        top -= 1
        node = stack[top]
        way = forest.centre[node] - p
        share = wp.clamp(wp.dot(way, along) / length, wp.float64(0.0), wp.float64(1.0))
        if wp.length(way - share * along) > forest.size[node]:
            continue
        if forest.triangle[node] >= 0:
            place = pierced_at(p, along, forest.triangles[forest.triangle[node]])
            if place >= wp.float64(0.0):
                first = wp.min(first, place)
                last = wp.max(last, place)
            continue
        if top + 2 <= STACK:
            stack[top] = forest.left[node]
            stack[top + 1] = forest.right[node]
            top += 2
    best = wp.float64(0.0)
    half = wp.float64(0.5) * (last - first) * wp.sqrt(length)
    if last > first and half > known + GOOD_TO:
        for k in range(POINTS_BETWEEN):
            share = wp.float64(k + 1) / wp.float64(POINTS_BETWEEN + 1)
            point = p + (first + share * (last - first)) * along
            best = wp.max(best, signed_depth(forest, root, point))
    return best


@wp.kernel
def measure_edges(
    path: PathArrays,
    chains: ChainArrays,
    forest: ForestArrays,
    asked: Asked,
    depth_out: wp.array2d[wp.float64],
):
    """One thread per (instant, side): what the side's edges add where they go through the other."""
    instant, side = wp.tid()
    pose = pair_pose(path, chains, asked.pair, asked.piece[instant], asked.time_ps[instant])
    if side == 0:
        pose = inverse(pose)
    other = forest.root[2 * asked.pair + 1 - side]
    stack = wp.zeros(shape=(STACK,), dtype=wp.int32)
    stack[0] = forest.root[2 * asked.pair + side]
    top = wp.int32(1)
    best = depth_out[instant, side]
    while top > 0:
        top -= 1
        node = stack[top]
        centre = pose.R * forest.centre[node] + pose.t
        depth = signed_depth(forest, other, centre)
        # Nothing below pierces a surface that is farther away, or lies deeper than known.
        if wp.abs(depth) > forest.size[node] or depth + forest.size[node] <= best + GOOD_TO:
            continue
        if forest.triangle[node] >= 0:
            t = forest.triangles[forest.triangle[node]]
            for k in range(3):
                p = pose.R * t[k] + pose.t
                along = pose.R * t[(k + 1) % 3] + pose.t - p
                best = wp.max(best, between_piercings(forest, other, p, along, best))
            continue
        if top + 2 <= STACK:
            stack[top] = forest.left[node]
            stack[top + 1] = forest.right[node]
            top += 2
    depth_out[instant, side] = best


@dataclass(frozen=True)
class Depth:
    """The deepest that a pair was found to be in an interval.

    Attributes:
        deepest: of a point of one body inside the other [mm].
        time_ps: when.
        within: it may be deeper by this much between the instants looked at [mm].
    """

    deepest: float
    time_ps: int
    within: float


@dataclass
class _Profile:
    """Depths of one interval at the instants looked at so far, in the order of time."""

    times: Times
    depths: Floats = field(default_factory=lambda: np.zeros(0))

    def bounds(self, way: Floats) -> Floats:
        """What the depth stays below between neighbours, given the way up to every instant."""
        return np.asarray((self.depths[:-1] + self.depths[1:] + np.diff(way)) / 2.0)


class DepthGauge:
    """Measures depths of some pairs of a scene, of their whole bodies."""

    def __init__(
        self,
        scene: Scene,
        path: Path,
        arrays: PathArrays,
        joints: tuple[Joint, ...],
        pairs: list[int],
    ) -> None:
        self.path, self.arrays, self.joints = path, arrays, joints
        self.scene: Scene = whole_scene(scene, pairs, joints)
        self.forest: Forest = build_forest(self.scene, joints)

    def deepest(self, pair: int, stretches: list[tuple[int, int]]) -> list[Depth]:
        """The deepest of a pair in each of some stretches of time [ps]; `pair` counts ours."""
        profiles = [
            _Profile(np.unique(np.linspace(start, end, FIRST_INSTANTS).astype(np.int64)))
            for start, end in stretches
        ]
        self._measure(pair, [(p, p.times) for p in profiles])
        ways = piece_ways(self.path, self.joints, self._levers(pair))
        most = self._most(pair)
        for _ in range(ROUNDS):
            open_yet = [p for p in profiles if p.depths.max() + GOOD_TO_MM < most]
            wanted = [(p, times) for p in open_yet if len(times := self._more(p, ways))]
            if not wanted:
                break
            self._measure(pair, wanted)
        return [self._result(p, ways, most) for p in profiles]

    def depths(self, pair: int, times: Times) -> Floats:
        """Depths of a pair at some instants, in the order of time, shape (m,) [mm]."""
        profile = _Profile(times)
        self._measure(pair, [(profile, times)])
        return profile.depths

    def _most(self, pair: int) -> float:
        """What no depth of a pair exceeds [mm]."""
        arrays = self.forest.arrays
        roots = arrays.root.numpy()[2 * pair : 2 * pair + 2]
        return float(arrays.extent.numpy()[roots].min(axis=1).max())

    def _more(self, profile: _Profile, ways: Floats) -> Times:
        """Instants to be looked at next: between those that leave most."""
        bounds = profile.bounds(self._way_at(profile.times, ways))
        gaps = np.diff(profile.times)
        open_gaps = (bounds > profile.depths.max() + GOOD_TO_MM) & (gaps > 1)
        chosen = np.argsort(-np.where(open_gaps, bounds, -np.inf), kind="stable")[:ADDED]
        chosen = chosen[open_gaps[chosen]]
        return np.asarray(profile.times[chosen] + gaps[chosen] // 2)

    def _result(self, profile: _Profile, ways: Floats, most: float) -> Depth:
        best = int(np.argmax(profile.depths))
        deepest = float(profile.depths[best])
        bounds = profile.bounds(self._way_at(profile.times, ways))
        highest = min(float(bounds.max(initial=deepest)) + GOOD_TO_MM, most)
        within = max(highest - deepest, 0.0)
        return Depth(deepest, int(profile.times[best]), within)

    def _way_at(self, times: Times, ways: Floats) -> Floats:
        """How far the bodies have moved against each other since the start, at most [mm]."""
        path = self.path
        piece = path.piece_at(times)
        start, end = path.bounds_ps[piece], path.bounds_ps[piece + 1]
        done = path_fraction(path.law[piece], (times - start) / np.maximum(end - start, 1))
        return np.asarray(ways[piece] + np.clip(done, 0.0, 1.0) * (ways[piece + 1] - ways[piece]))

    def _levers(self, pair: int) -> list[tuple[int, float]]:
        """Joint and lever of every step of both chains: 1 for a linear joint, else [mm]."""
        arrays, sides = self.forest.arrays, self.forest.sides
        first, count = arrays.lever_first.numpy(), arrays.lever_count.numpy()
        levers, roots = arrays.lever.numpy(), arrays.root.numpy()
        steps, joint, rotary = sides.first.numpy(), sides.joint.numpy(), sides.rotary.numpy()
        found: list[tuple[int, float]] = []
        for side in (2 * pair, 2 * pair + 1):
            lever = first[side] + roots[side] * count[side]
            for step in range(steps[side], steps[side + 1]):
                turns = bool(rotary[joint[step]])
                found.append((int(joint[step]), float(levers[lever]) if turns else 1.0))
                lever += turns
        return found

    def _measure(self, pair: int, wanted: list[tuple[_Profile, Times]]) -> None:
        """Add the depths at some instants to their profiles."""
        times = np.concatenate([times for _, times in wanted])
        device = self.scene.device
        threads = min(os.cpu_count() or 1, len(times)) if device == "cpu" else 1
        cuts = np.linspace(0, len(times), threads + 1).astype(int).tolist()
        parts = [slice(*ends) for ends in pairwise(cuts)]
        if threads > 1:
            with ThreadPoolExecutor(threads) as pool:
                found = list(pool.map(lambda part: self._depths_at(pair, times[part]), parts))
            depth = np.concatenate(found)
        else:
            depth = self._depths_at(pair, times)
        found, at = depth.max(axis=1), 0
        for profile, added in wanted:
            new = found[at : at + len(added)]
            at += len(added)
            known = profile.times if len(profile.depths) else profile.times[:0]
            every = np.concatenate([known, added])
            order = np.argsort(every, kind="stable")
            profile.times = every[order]
            profile.depths = np.concatenate([profile.depths, new])[order]

    def _depths_at(self, pair: int, times: Times) -> Floats:
        """Depths of both sides at some instants, shape (m, 2) [mm]."""
        device = self.scene.device
        asked = Asked()
        asked.pair = pair
        asked.piece = lent(self.path.piece_at(times), wp.int32, device)
        asked.time_ps = lent(times, wp.int64, device)
        depth = wp.zeros((len(times), 2), dtype=wp.float64, device=device)
        wp.launch(
            measure_depths,
            dim=depth.shape,
            inputs=[self.arrays, self.scene.chains, self.forest.arrays, asked],
            outputs=[depth],
            device=device,
        )
        wp.launch(
            measure_edges,
            dim=depth.shape,
            inputs=[self.arrays, self.scene.chains, self.forest.arrays, asked, depth],
            device=device,
        )
        return np.asarray(depth.numpy())

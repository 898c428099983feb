"""Random chains with random chords, their bounds by the search's own code, and what is true."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import warp as wp
from collision.scenes import random_joints, random_path, unit

from gcodesim.collision.bodies.scene import Scene, build_scene
from gcodesim.collision.bounds.chords import Stretch, joint_motion, side_leaves_chord
from gcodesim.collision.bounds.forest import Forest, build_forest
from gcodesim.collision.bounds.motion_bounds import travelled
from gcodesim.collision.geometry.closest import ForestArrays
from gcodesim.collision.geometry.device import BIT_EQUAL
from gcodesim.collision.geometry.poses import ChainArrays, PathArrays, path_arrays
from gcodesim.collision.search.search import LEVEL, Searcher, SearchSettings
from gcodesim.collision.search.search_kernel import MODE_AT_SAMPLES, MotionArrays
from gcodesim.machine.kinematics import world_from_link
from gcodesim.machine.model import Machine
from gcodesim.motion.path import Path, path_fraction
from gcodesim.study.scenes import Array, machine

wp.set_module_options(BIT_EQUAL)

PIECES, RUN_LEVELS, PARTS, INSTANTS = 16, 5, 10, 20
TRIANGLES = 3
SLACK_MM = 1e-9


@wp.kernel
def bound_stretches(
    path: PathArrays,
    sides: ChainArrays,
    forest: ForestArrays,
    motion: MotionArrays,
    stretches: wp.array[Stretch],
    leaves_out: wp.array2d[wp.float64],
    moved_out: wp.array2d[wp.vec2d],
):
    """One thread per (stretch, side): the bound of the side's root, and of every joint."""
    i, side = wp.tid()
    stretch = stretches[i]
    leaves_out[i, side] = side_leaves_chord(
        path, sides, forest, motion, side, forest.root[side], stretch
    )
    if side == 0:
        for joint in range(moved_out.shape[1]):
            moved_out[i, joint] = joint_motion(path, motion, stretch, joint)


@dataclass(frozen=True)
class Chords:
    """A random machine and path, and m stretches of it.

    Attributes:
        times: instants of every stretch, its ends first and last, shape (m, INSTANTS) [ps].
        leaves: how far the bodies of each pair may leave the chord, shape (m, pairs) [mm].
        moved, deviation: of every joint, shape (m, joints) [mm, rad].
    """

    machine: Machine
    path: Path
    scene: Scene
    forest: Forest
    times: np.ndarray
    leaves: Array
    moved: Array
    deviation: Array


def random_chords(rng: np.random.Generator) -> Chords:
    """A random tree of 3 to 6 joints with a few triangles on every link, and every pair of them."""
    joints = random_joints(rng, int(rng.integers(3, 7)), reach=rng.choice([1.0, 100.0, 800.0]))
    links = ["bed", *(j.child for j in joints)]
    shapes = {
        link: rng.uniform(-60, 60, (TRIANGLES, 3, 3)) + rng.uniform(-200, 200, 3) for link in links
    }
    pairs = [(a, b) for i, a in enumerate(links) for b in links[i + 1 :]]
    m = machine(joints, shapes, pairs)
    size = 10.0 ** rng.uniform(-3, 0)
    path = random_path(rng, joints, PIECES, linear=500 * size, rotary=2000 * size)
    scene = build_scene(m.pairs, dict(m.bodies), m.joints, "cpu")
    arrays = path_arrays(path, "cpu")
    forest = build_forest(scene, travelled(m.joints, path))
    settings = SearchSettings(10**8, MODE_AT_SAMPLES, (0.0,) * len(pairs), 1)
    motion = Searcher(scene, forest, path, arrays, m.joints, settings).motion(0, PIECES, LEVEL)
    rows, times = _stretches(rng, path)
    leaves = wp.zeros((len(rows), 2 * len(pairs)), dtype=wp.float64, device="cpu")
    moved = wp.zeros((len(rows), len(joints)), dtype=wp.vec2d, device="cpu")
    wp.launch(
        bound_stretches,
        dim=leaves.shape,
        inputs=[
            arrays,
            forest.sides,
            forest.arrays,
            motion,
            wp.array(rows, dtype=Stretch, device="cpu"),
        ],
        outputs=[leaves, moved],
        device="cpu",
    )
    both = leaves.numpy().reshape(len(rows), len(pairs), 2).sum(axis=2)
    return Chords(m, path, scene, forest, times, both, *np.moveaxis(moved.numpy(), 2, 0))


def _stretches(rng: np.random.Generator, path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Runs of pieces of every level, and random parts of pieces, some of them tiny."""
    rows, times = [], []
    level_first = np.cumsum([0, *(1 << (LEVEL - level) for level in range(LEVEL))])
    for level in range(RUN_LEVELS):
        for run in range(PIECES >> level):
            rows.append((run << level, level_first[level] + run, 1.0))
            ends = path.bounds_ps[[run << level, (run + 1) << level]]
            inner = path.bounds_ps[(path.bounds_ps > ends[0]) & (path.bounds_ps < ends[1])]
            some = rng.integers(ends[0], ends[1], INSTANTS - 2 - len(inner))
            times.append(np.concatenate([ends[:1], np.sort([*inner, *some]), ends[1:]]))
    for piece in rng.integers(0, PIECES, PARTS):
        start, end = path.bounds_ps[[piece, piece + 1]]
        middle = rng.uniform()
        half = 10.0 ** rng.uniform(-5, 0)
        part = np.clip([middle - half, middle + half], 0, 1)
        ends = (start + part * (end - start)).astype(np.int64)
        s0, s1 = (path_fraction(path.law[[piece]], (t - start) / (end - start))[0] for t in ends)
        rows.append((piece, piece, s1 - s0))
        times.append(np.linspace(*ends, INSTANTS).astype(np.int64))
    return np.array(rows, Stretch.numpy_dtype()), np.array(times)


@dataclass(frozen=True)
class Comparison:
    """Bounds against what is true, for every stretch and pair.

    Attributes:
        excess: how far the gap fell below what is proved, positive = a violation [mm].
        sharpness: how far it fell, as a part of what is allowed.
    """

    excess: Array
    sharpness: Array


def compare(chords: Chords, rng: np.random.Generator, frames: list[str]) -> Comparison:
    """The gap along a random direction of a frame per pair, at all instants of every stretch."""
    world = world_from_link(chords.machine, chords.path.positions(chords.times.ravel()))
    fall = np.zeros(chords.leaves.shape)
    for k, ((a, b), frame) in enumerate(zip(chords.scene.links, frames, strict=True)):
        back = np.linalg.inv(world[frame])
        n = unit(rng)
        heights = []
        for link, shape in zip((a, b), chords.scene.shapes[k], strict=True):
            pose = back @ world[link]
            points = shape.regions.triangles.reshape(-1, 3)
            heights.append(np.einsum("i,tij,pj->tp", n, pose[:, :3, :3], points))
            heights[-1] += (pose[:, :3, 3] @ n)[:, None]
        gap = (heights[1].min(axis=1) - heights[0].max(axis=1)).reshape(chords.times.shape)
        fall[:, k] = np.minimum(gap[:, 0], gap[:, -1]) - gap.min(axis=1)
    allowed = chords.leaves
    sharpness = np.divide(fall, allowed, out=np.zeros_like(fall), where=allowed > 1e-6)
    return Comparison(fall - allowed, sharpness)

"""Reach: what is removed beforehand never meets the other body within the travels."""

from __future__ import annotations

import numpy as np
import pytest
from collision.scenes import random_joints, random_mesh

from gcodesim.collision.bodies.reach import reachable, sweep, triangle_boxes
from gcodesim.collision.geometry.poses import joints_between
from gcodesim.machine.kinematics import world_from_link
from gcodesim.machine.model import Joint, Machine
from gcodesim.study.scenes import Array, joint, machine

ROUNDING_MM = 1e-9  # of poses here; far below the slack with which boxes are compared


def limited(joints: list[Joint], rng: np.random.Generator) -> list[Joint]:
    """The joints with random travels; some fixed, some turning without end."""
    made = []
    for j in joints:
        ends = np.sort(rng.uniform(-150, 150, 2))
        kind = rng.integers(6)
        if j.rotary and kind == 0:
            ends = np.array([-np.inf, np.inf])
        elif kind == 1:
            ends = ends[[0, 0]]
        made.append(
            joint(j.name, j.axis, j.parent, j.child, j.point, (float(ends[0]), float(ends[1])))
        )
    return made


def random_positions(joints: list[Joint], count: int, rng: np.random.Generator) -> Array:
    ends = np.array([[max(j.lower, -1e4), min(j.upper, 1e4)] for j in joints])
    q = rng.uniform(ends[:, 0], ends[:, 1], (count, len(joints)))
    # Corners of the travel are where a sweep is tight.
    at_end = rng.random(q.shape) < 0.3
    return np.where(at_end, ends[np.arange(len(joints)), rng.integers(0, 2, q.shape)], q)


def posed(m: Machine, q: Array, a: str, b: str, triangles: Array) -> Array:
    """Triangles of link b in the frame of link a at positions q: (count, n, 3, 3)."""
    world = world_from_link(m, q)
    pose = np.linalg.inv(world[a]) @ world[b]
    return np.einsum("kij,nvj->knvi", pose[:, :3, :3], triangles) + pose[:, None, None, :3, 3]


@pytest.mark.parametrize("seed", range(10))
def test_removed_triangles_stay_out_of_the_other_box(seed: int) -> None:
    rng = np.random.default_rng(seed)
    joints = limited(random_joints(rng, 4, reach=60.0), rng)
    m = machine(joints, {}, [])
    q = random_positions(joints, 150, rng)
    removed = 0
    for a in m.links:
        for b in m.links:
            if a == b:
                continue
            mesh_a, mesh_b = (random_mesh(rng, 40.0, rng.uniform(-150, 150, 3)) for _ in "ab")
            near_a, near_b = reachable(tuple(joints), (a, b), mesh_a, mesh_b)
            for near, own, other, frame in (
                (near_b, mesh_b, mesh_a, (a, b)),
                (near_a, mesh_a, mesh_b, (b, a)),
            ):
                moved = posed(m, q, *frame, own[~near])
                low, high = other.min(axis=(0, 1)), other.max(axis=(0, 1))
                meets = (moved.min(axis=2) <= high) & (moved.max(axis=2) >= low)
                assert not meets.all(axis=2).any()
                removed += int((~near).sum())
    assert removed > 0


@pytest.mark.parametrize("seed", range(10))
def test_sweeps_hold_every_pose(seed: int) -> None:
    rng = np.random.default_rng(100 + seed)
    joints = limited(random_joints(rng, 3, reach=60.0), rng)
    m = machine(joints, {}, [])
    mesh = random_mesh(rng, 30.0, rng.uniform(-100, 100, 3))
    q = random_positions(joints, 500, rng)
    for a in m.links:
        for b in m.links:
            swept = sweep(triangle_boxes(mesh), tuple(joints), joints_between(tuple(joints), a, b))
            moved = posed(m, q, a, b, mesh)
            assert (moved.min(axis=(0, 2)) >= swept[:, 0] - ROUNDING_MM).all()
            assert (moved.max(axis=(0, 2)) <= swept[:, 1] + ROUNDING_MM).all()


def test_a_straight_sweep_is_exact_and_a_quarter_turn_nearly() -> None:
    cube = np.array([[[0.0, 0, 0], [1, 0, 0], [1, 2, 3]]])
    slide = joint("X", [0, 1, 0], travel=(-2, 5))
    swept = sweep(triangle_boxes(cube), (slide,), [(0, 1)])
    np.testing.assert_allclose(swept[0], [[0, -2, 0], [1, 7, 3]], atol=1e-9)
    turn = joint("C", [0, 0, 1], travel=(0, 90))
    point = np.array([[[10.0, 0, 0]] * 3])
    swept = sweep(triangle_boxes(point), (turn,), [(0, 1)])
    assert (swept[0] >= [[-1, -1, -1], [10, 10, 0]]).all()
    assert (swept[0] <= [[0, 0, 0], [11, 11, 1]]).all()

"""Closest points and certified gaps against exact distances."""

from __future__ import annotations

from math import sqrt

import numpy as np
import pytest
import warp as wp
from benchmarks.hard_pairs import EVERY_FAMILY, HARD, generate
from collision.scenes import random_mesh, unit

from gcodesim.collision.bodies.scene import build_scene
from gcodesim.collision.bounds.forest import build_forest
from gcodesim.collision.bounds.motion_bounds import travelled
from gcodesim.collision.geometry.closest import (
    ForestArrays,
    aim_at_node,
    between_triangles,
    nearest_on_triangle,
    node_gap,
)
from gcodesim.collision.geometry.device import BIT_EQUAL
from gcodesim.collision.geometry.poses import Pose
from gcodesim.machine.kinematics import rotation
from gcodesim.study.exact import squared_clearance
from gcodesim.study.scenes import Array, box, joint, machine, path

wp.set_module_options(BIT_EQUAL)

FAR_MM = 1e-6
RELATIVE = 1e-9
ROUNDING = 1e-14
"""Of the coordinates: small distances of triangles far from the origin are lost to rounding."""

PARALLEL = 1e-8
"""The same for edges parallel to 1e-10: whose nearest points are lost, not the distance."""


@wp.kernel
def launch_between(a: wp.array[wp.mat33d], b: wp.array[wp.mat33d], between_out: wp.array[wp.vec3d]):
    """One thread per pair of triangles."""
    i = wp.tid()
    between_out[i] = between_triangles(a[i], b[i])


@wp.kernel
def launch_nearest(triangles: wp.array[wp.mat33d], point_out: wp.array[wp.vec3d]):
    """One thread per triangle: its point nearest to the origin."""
    i = wp.tid()
    t = triangles[i]
    point_out[i] = nearest_on_triangle(t[0], t[1], t[2])


@wp.kernel
def launch_gaps(
    forest: ForestArrays,
    nodes: wp.array2d[wp.int32],
    poses: wp.array[Pose],
    directions: wp.array[wp.vec3d],
    gap_out: wp.array2d[wp.float64],
    aim_out: wp.array[wp.vec3d],
):
    """One thread per pair of nodes: gaps along a given and along the proposed direction."""
    i = wp.tid()
    a = nodes[i, 0]
    b = nodes[i, 1]
    gap_out[i, 0] = node_gap(forest, a, b, poses[i], directions[i])
    n = aim_at_node(forest, a, b, poses[i])
    aim_out[i] = n
    gap_out[i, 1] = node_gap(forest, a, b, poses[i], n)


def between(a: Array, b: Array, device: str) -> Array:
    vectors = wp.zeros(len(a), dtype=wp.vec3d, device=device)
    inputs = [wp.array(t, dtype=wp.mat33d, device=device) for t in (a, b)]
    wp.launch(launch_between, dim=len(a), inputs=inputs, outputs=[vectors], device=device)
    return np.asarray(vectors.numpy())


@pytest.mark.parametrize("family", EVERY_FAMILY)
def test_distances_of_triangles_apart(family: str, device: str) -> None:
    a, b = generate(family, 250, seed=5)
    found = np.linalg.norm(between(a, b, device), axis=1)
    exact = np.array([sqrt(squared_clearance(p, q)) for p, q in zip(a, b, strict=True)])
    far = exact > FAR_MM
    size = np.abs(np.concatenate([a, b], axis=1)).max(axis=(1, 2))
    parallel = PARALLEL if family in ("F03", HARD) else 0.0
    allowed = (RELATIVE + parallel) * exact + ROUNDING * size + parallel * 100
    assert (np.abs(found - exact) <= allowed)[far].all()
    assert far.sum() > 20 or family == "F08"


def test_the_vector_leads_from_a_to_b(device: str, rng: np.random.Generator) -> None:
    a = rng.uniform(-10, 10, (300, 3, 3))
    b = rng.uniform(-10, 10, (300, 3, 3)) + [40, 0, 0]
    v = between(a, b, device)
    n = v / np.linalg.norm(v, axis=1)[:, None]
    gap = np.einsum("ij,ikj->ik", n, b).min(1) - np.einsum("ij,ikj->ik", n, a).max(1)
    np.testing.assert_allclose(gap, np.linalg.norm(v, axis=1), rtol=1e-12)
    np.testing.assert_allclose(between(b, a, device), -v, atol=1e-11)


def test_nearest_point_of_a_triangle(device: str, rng: np.random.Generator) -> None:
    """Against a point as a degenerate triangle of the exact oracle; segments and points too."""
    triangles = rng.uniform(-10, 10, (300, 3, 3)) + rng.uniform(-20, 20, (300, 1, 3))
    triangles[:50, 2] = triangles[:50, 1]
    triangles[50:100, 2] = (triangles[50:100, 0] + triangles[50:100, 1]) / 2
    triangles[100:120] = triangles[100:120, :1]
    triangles[120:140, :, 2] = 0.0
    points = wp.zeros(300, dtype=wp.vec3d, device=device)
    inputs = [wp.array(triangles, dtype=wp.mat33d, device=device)]
    wp.launch(launch_nearest, dim=300, inputs=inputs, outputs=[points], device=device)
    origin = np.zeros((3, 3))
    exact = [sqrt(squared_clearance(t, origin)) for t in triangles]
    np.testing.assert_allclose(np.linalg.norm(points.numpy(), axis=1), exact, rtol=1e-9, atol=1e-9)


def test_no_gap_of_nodes_exceeds_the_distance_of_their_triangles(
    device: str, rng: np.random.Generator
) -> None:
    """Along any direction, and along the proposed one; that one separates distant nodes."""
    shapes = {
        "bed": random_mesh(rng, 20.0, [0, 0, 0]),
        "mover": np.concatenate([random_mesh(rng, 15.0, [3, 0, 0]), box([9, 1, 2])]),
    }
    joints = [joint("X", [1, 0, 0])]
    m = machine(joints, shapes, [("bed", "mover")])
    scene = build_scene(m.pairs, dict(m.bodies), m.joints, device)
    forest = build_forest(scene, travelled(m.joints, path(joints, [0.0], [(1.0, [1.0])]))).arrays
    count = 500
    roots = forest.root.numpy()
    total = len(forest.left.numpy())
    nodes = np.stack(
        [rng.integers(0, roots[1], count), rng.integers(roots[1], total, count)], axis=1
    )
    poses = np.zeros(count, Pose.numpy_dtype())
    for i in range(count):
        turn = rotation(unit(rng), rng.uniform(0, 360))
        poses[i]["R"], poses[i]["t"] = turn, unit(rng) * rng.uniform(0, 80)
    directions = np.array([unit(rng) for _ in range(count)])
    gaps = wp.zeros((count, 2), dtype=wp.float64, device=device)
    aims = wp.zeros(count, dtype=wp.vec3d, device=device)
    wp.launch(
        launch_gaps,
        dim=count,
        inputs=[
            forest,
            wp.array(nodes, dtype=wp.int32, device=device),
            wp.array(poses, dtype=Pose, device=device),
            wp.array(directions, dtype=wp.vec3d, device=device),
        ],
        outputs=[gaps, aims],
        device=device,
    )
    below = triangles_of(forest)
    proposed = aims.numpy()
    assert np.isin(np.round(np.linalg.norm(proposed, axis=1), 12), [0.0, 1.0]).all()
    separated = 0
    for i, (a, b) in enumerate(nodes):
        own = below[a].reshape(-1, 3)
        posed = below[b].reshape(-1, 3) @ poses[i]["R"].T + poses[i]["t"]
        for n, gap in zip((directions[i], proposed[i]), gaps.numpy()[i], strict=True):
            assert gap <= (posed @ n).min() - (own @ n).max() + 1e-11
        if gaps.numpy()[i, 1] > 0:
            separated += 1
    assert separated > count / 2


def triangles_of(forest: ForestArrays) -> list[Array]:
    """Triangles below every node of a forest."""
    left, right = forest.left.numpy(), forest.right.numpy()
    number, triangles = forest.triangle.numpy(), forest.triangles.numpy()
    below: list[Array] = [np.zeros(0)] * len(left)
    for node in range(len(left) - 1, -1, -1):
        if number[node] >= 0:
            below[node] = triangles[number[node]][None]
        else:
            below[node] = np.concatenate([below[left[node]], below[right[node]]])
    return below

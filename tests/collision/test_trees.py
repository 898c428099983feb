"""Bounding-volume trees: every node contains its triangles, every triangle is one leaf."""

from __future__ import annotations

from math import log

import numpy as np
import pytest
import trimesh
from collision.scenes import random_mesh, unit

from gcodesim.collision.bodies.regions import snapped
from gcodesim.collision.bodies.tree_kernel import LEAST_SHARE
from gcodesim.collision.bodies.trees import Tree, build_tree
from gcodesim.study.scenes import Array, box

DIRECTIONS = 40
ROUNDING_MM = 1e-10
"""A tenth of the slack that proofs leave for rounding."""


def line(count: int) -> Array:
    """Triangles without area along the x axis."""
    starts = np.arange(count)[:, None, None] * np.array([1.0, 0, 0])
    return np.array(starts + np.array([[0.0, 0, 0], [1, 0, 0], [2.5, 0, 0]]))


def slivers(rng: np.random.Generator, height: float) -> Array:
    """Long needles, so thin that their normal is noise, at random places on the grid."""
    start = rng.uniform(-100, 100, (60, 3))
    end = start + rng.normal(size=(60, 3)) * 100
    middle = start + (end - start) * rng.uniform(0.2, 0.8, (60, 1))
    return snapped(np.stack([start, end, middle + rng.normal(size=(60, 3)) * height], axis=1))


def meshes() -> dict[str, Array]:
    rng = np.random.default_rng(7)
    one = rng.uniform(-10, 10, (1, 3, 3))
    return {
        "one": one,
        "two": np.concatenate([one, one + 5]),
        "box": box([3, 200, 1]),
        "ball": np.array(trimesh.creation.icosphere(3, radius=40.0).triangles),
        "torus": random_mesh(rng, 30.0, [400, -900, 20]),
        "soup": rng.uniform(-500, 500, (999, 3, 3)),
        "equal": np.repeat(one, 100, axis=0),
        "coincident": np.repeat(one, 10_000, axis=0),
        "points": np.repeat(rng.uniform(-10, 10, (200, 1, 3)), 3, axis=1),
        "collinear": line(300),
        "flat": np.concatenate([rng.uniform(-10, 10, (300, 3, 2)), np.zeros((300, 3, 1))], axis=2),
        "needles": slivers(rng, 1e-7),
        "thinnest needles": slivers(rng, 1e-10),
        "far away": np.array(trimesh.creation.icosphere(2, radius=1e-3).triangles) + 1e5,
        "geometric": np.array(2.0 ** np.arange(60))[:, None, None] * rng.uniform(0, 1, (60, 3, 3)),
    }


MESHES = meshes()


def triangles_below(tree: Tree) -> list[list[int]]:
    """Triangles of every node; children have higher numbers than their parents."""
    below: list[list[int]] = [[] for _ in tree.left]
    for node in range(len(tree.left) - 1, -1, -1):
        if tree.triangle[node] >= 0:
            below[node] = [int(tree.triangle[node])]
        else:
            below[node] = below[tree.left[node]] + below[tree.right[node]]
    return below


@pytest.mark.parametrize("name", MESHES)
def test_every_triangle_is_one_leaf(name: str) -> None:
    tree = build_tree(MESHES[name])
    count = len(MESHES[name])
    leaves = tree.triangle[tree.triangle >= 0]
    assert sorted(leaves) == list(range(count))
    assert len(tree.left) == 2 * count - 1
    np.testing.assert_array_equal(tree.triangle >= 0, tree.left < 0)
    np.testing.assert_array_equal(tree.left < 0, tree.right < 0)
    assert sorted(triangles_below(tree)[0]) == list(range(count))


@pytest.mark.parametrize("name", MESHES)
def test_every_node_contains_its_triangles(name: str, rng: np.random.Generator) -> None:
    triangles = MESHES[name]
    tree = build_tree(triangles)
    assert np.isfinite(tree.centre).all()
    scale = np.abs(triangles).max() / 1000
    below = triangles_below(tree)
    step = max(1, len(below) // 400)
    for node in range(0, len(below), step):
        points = triangles[below[node]].reshape(-1, 3)
        frame, centre, extent = tree.frame[node], tree.centre[node], tree.extent[node]
        reach = points @ frame.T - frame @ centre
        assert (np.abs(reach) <= extent + ROUNDING_MM * max(1.0, scale)).all()
        np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-12)
        directions = np.array([unit(rng) for _ in range(DIRECTIONS)])
        truth = (points @ directions.T).max(axis=0)
        of_box = directions @ centre + np.abs(directions @ frame.T) @ extent
        assert (of_box >= truth - ROUNDING_MM * max(1.0, scale)).all()
        first, vertices = tree.vertex_first[node], tree.vertex_count[node]
        if vertices:
            own = tree.vertices[first : first + vertices]
            np.testing.assert_array_equal(np.unique(own, axis=0), np.unique(points, axis=0))
        assert tree.size[node] == pytest.approx(float(np.linalg.norm(extent)))


@pytest.mark.parametrize("name", MESHES)
def test_the_depth_is_bounded(name: str) -> None:
    count = len(MESHES[name])
    tree = build_tree(MESHES[name])
    # A node keeps at most 7/8 of its parent's triangles, rounded up; below 8 one less is enough.
    most = LEAST_SHARE + max(0.0, log(count / LEAST_SHARE) / log(LEAST_SHARE / (LEAST_SHARE - 1)))
    assert tree.depth <= most + LEAST_SHARE
    assert tree.levels[0] == 0
    assert tree.levels[-1] == len(tree.left)


@pytest.mark.parametrize("name", ["one", "two", "ball", "coincident", "soup"])
def test_highest_is_the_largest_value_below(name: str, rng: np.random.Generator) -> None:
    tree = build_tree(MESHES[name])
    values = rng.normal(size=len(MESHES[name]))
    highest = tree.highest(values)
    for node, chosen in enumerate(triangles_below(tree)[:500]):
        assert highest[node] == values[chosen].max()

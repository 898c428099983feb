"""The forest: trees, levers and chains of all pairs of a scene, on the device."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from gcodesim.collision.bodies.scene import CheckedShape, Scene
from gcodesim.collision.bodies.trees import Tree, build_tree
from gcodesim.collision.bounds.motion_bounds import common_frame, levers
from gcodesim.collision.geometry.closest import ForestArrays
from gcodesim.collision.geometry.poses import ChainArrays, joints_between, step_arrays
from gcodesim.machine.model import Joint

Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Forest:
    """What the search needs of a scene besides its pairs.

    Attributes:
        sides: chains from the common frame to body a (side 2 p) and to body b (2 p + 1) of pair p.
        distinct: the chains that differ, and `row`: side -> its number among them.
    """

    arrays: ForestArrays
    sides: ChainArrays
    distinct: ChainArrays
    row: wp.array[wp.int32]


def build_forest(scene: Scene, joints: tuple[Joint, ...]) -> Forest:
    """Build the trees of all shapes once, and the levers of each pair.

    Args:
        scene: the pairs.
        joints: with the travel of the program as their limits.
    """
    arrays, trees, roots = build_trees(scene)
    chains, blocks = [], []
    for pair, links in zip(scene.shapes, scene.links, strict=True):
        frame = common_frame(joints, *links)
        for shape, link in zip(pair, links, strict=True):
            chain = joints_between(joints, frame, link)
            blocks.append(levers(joints, chain, shape.regions.triangles, trees[id(shape)]))
            chains.append(chain)
    device = scene.device
    counts = np.array([block.shape[1] for block in blocks])
    first = np.cumsum([0, *(block.size for block in blocks)])[:-1]
    flat = np.concatenate([np.zeros(0), *(block.ravel() for block in blocks)])
    arrays.lever = wp.array(np.append(flat, 0.0), dtype=wp.float64, device=device)
    # Levers are found as lever[first + node * count + k] with the node's number in the forest.
    arrays.lever_first = wp.array(first - roots * counts, dtype=wp.int32, device=device)
    arrays.lever_count = wp.array(counts, dtype=wp.int32, device=device)
    keys = list(dict.fromkeys(tuple(chain) for chain in chains))
    row = wp.array([keys.index(tuple(c)) for c in chains], dtype=wp.int32, device=device)
    distinct = step_arrays(joints, [list(key) for key in keys], device)
    return Forest(arrays, step_arrays(joints, chains, device), distinct, row)


def build_trees(scene: Scene) -> tuple[ForestArrays, dict[int, Tree], Ints]:
    """The trees of all shapes, each once, without levers.

    Returns:
        The arrays, the trees by the id of their shape, and the root of every side.
    """
    shapes = list({id(s): s for pair in scene.shapes for s in pair}.values())
    trees = [build_tree(s.regions.triangles) for s in shapes]
    node_at = np.cumsum([0, *(len(t.left) for t in trees)])
    arrays = _tree_arrays(scene, shapes, trees, node_at)
    place = {id(s): i for i, s in enumerate(shapes)}
    roots = node_at[[place[id(shape)] for pair in scene.shapes for shape in pair]]
    arrays.root = wp.array(roots, dtype=wp.int32, device=scene.device)
    return arrays, {id(s): tree for s, tree in zip(shapes, trees, strict=True)}, roots


def _tree_arrays(
    scene: Scene, shapes: list[CheckedShape], trees: list[Tree], node_at: Ints
) -> ForestArrays:
    device = scene.device
    triangle_at = np.cumsum([0, *(len(s.regions.triangles) for s in shapes)])
    vertex_at = np.cumsum([0, *(len(t.vertices) for t in trees)])

    def joined(field: str, offsets: Ints | None = None) -> NDArray[Any]:
        columns = [getattr(tree, field) for tree in trees]
        if offsets is not None:
            columns = [np.where(c >= 0, c + o, c) for c, o in zip(columns, offsets, strict=False)]
        return np.concatenate(columns)

    arrays = ForestArrays()
    for field, offsets in (
        ("left", node_at),
        ("right", node_at),
        ("triangle", triangle_at),
        ("vertex_first", vertex_at),
        ("vertex_count", None),
    ):
        setattr(arrays, field, wp.array(joined(field, offsets), dtype=wp.int32, device=device))
    arrays.frame = wp.array(joined("frame"), dtype=wp.mat33d, device=device)
    arrays.centre = wp.array(joined("centre"), dtype=wp.vec3d, device=device)
    arrays.extent = wp.array(joined("extent"), dtype=wp.vec3d, device=device)
    arrays.vertices = wp.array(joined("vertices"), dtype=wp.vec3d, device=device)
    arrays.size = wp.array(joined("size"), dtype=wp.float64, device=device)
    triangles = np.concatenate([s.regions.triangles for s in shapes])
    arrays.triangles = wp.array(triangles, dtype=wp.mat33d, device=device)
    return arrays

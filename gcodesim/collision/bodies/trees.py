"""Bounding-volume trees: binary, one triangle a leaf.

A node is bounded by its own vertices when they are few, else by an oriented box; both contain every
triangle below the node, so any direction that separates two nodes separates their triangles.
Splits minimise the surface-area cost (Goldsmith and Salmon 1987) over all three axes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import warp as wp
from numpy.typing import NDArray

from gcodesim.collision.bodies.tree_kernel import MOST_VERTICES, NodeArrays, Working, build_nodes
from gcodesim.collision.geometry.device import lent

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

COLUMNS = {name: field.type.dtype for name, field in NodeArrays.vars.items()}  # type: ignore[attr-defined]
"""Columns of the nodes, with their types on the device."""


@dataclass(frozen=True)
class Tree:
    """Nodes in level order, the root first.

    Attributes:
        left, right: children, -1 at a leaf, shape (n,).
        triangle: triangle of a leaf, -1 above, shape (n,).
        frame, centre, extent: oriented box: axes as rows, centre, half extents [mm].
        vertex_first, vertex_count: vertices of a node; count 0 = use the box.
        vertices: shape (m, 3) [mm].
        size: half diagonal of the box [mm].
        levels: first node of each level, with the end appended.
    """

    left: NDArray[np.int32]
    right: NDArray[np.int32]
    triangle: NDArray[np.int32]
    frame: Floats
    centre: Floats
    extent: Floats
    vertex_first: NDArray[np.int32]
    vertex_count: NDArray[np.int32]
    vertices: Floats
    size: Floats
    levels: Ints

    @property
    def depth(self) -> int:
        """Number of levels."""
        return len(self.levels) - 1

    def highest(self, per_triangle: Floats) -> Floats:
        """Largest value of the triangles below each node, shape (n,)."""
        values = np.where(self.triangle >= 0, per_triangle[self.triangle], -np.inf)
        for first, end in zip(self.levels[-2::-1], self.levels[:0:-1], strict=True):
            nodes = np.arange(first, end)
            nodes = nodes[self.left[nodes] >= 0]
            children = np.maximum(values[self.left[nodes]], values[self.right[nodes]])
            values[nodes] = children
        return values


def build_tree(triangles: Floats) -> Tree:
    """Build the tree of triangles of shape (n, 3, 3), n > 0."""
    count = len(triangles)
    most = 2 * count - 1
    nodes, work = NodeArrays(), _working(triangles, most)
    sizes = {"vertices": MOST_VERTICES * most}
    for name, dtype in COLUMNS.items():
        setattr(nodes, name, wp.empty(sizes.get(name, most), dtype=dtype, device="cpu"))
    nodes.level.fill_(0)
    counts = wp.zeros(2, dtype=wp.int32, device="cpu")
    wp.launch(build_nodes, dim=1, inputs=[work], outputs=[nodes, counts], device="cpu")
    made, vertices = counts.numpy().tolist()
    ends = {"vertices": vertices}
    columns = {
        name: getattr(nodes, name).numpy()[: ends.get(name, made)].copy() for name in COLUMNS
    }
    levels = np.flatnonzero(np.diff(columns.pop("level"), prepend=-1, append=-1))
    return Tree(levels=levels, size=np.linalg.norm(columns["extent"], axis=1), **columns)


def _working(triangles: Floats, most: int) -> Working:
    """The triangles on the CPU, sorted along each axis, and the memory that building needs."""
    low, high = triangles.min(axis=1), triangles.max(axis=1)
    order = np.argsort((low + high).T, axis=1, kind="stable").astype(np.int32)
    work = Working()
    work.triangles = lent(triangles, wp.mat33d, "cpu")
    work.low, work.high = lent(low, wp.vec3d, "cpu"), lent(high, wp.vec3d, "cpu")
    work.order = lent(order, wp.int32, "cpu")
    work.first, work.count = (wp.empty(most, dtype=wp.int32, device="cpu") for _ in range(2))
    work.second, work.put_by = (
        wp.empty(len(triangles), dtype=wp.int32, device="cpu") for _ in range(2)
    )
    work.area = wp.empty(len(triangles), dtype=wp.float64, device="cpu")
    return work

"""Bounding-volume trees: binary, one triangle a leaf, built level by level in NumPy.

A node is bounded by its own vertices when they are few, else by an oriented box; both contain every
triangle below the node, so any direction that separates two nodes separates their triangles.
Splits minimise the surface-area cost (Goldsmith and Salmon 1987) over all three axes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

VERTEX_LIMIT = 8
"""Distinct vertices a node may carry before it gets a box. More make fewer items, each at a higher
price; measured on three programs, 8 costs 0.7 of 48 and 0.95 of 12."""

MANY = 2 * VERTEX_LIMIT
"""Triangles from which on a node is not even asked for its vertices: a closed surface of so many
has more than VERTEX_LIMIT."""

SMALL = 24
"""Triangles up to which a node is split along the best of three axes. Larger ones lose 1 % of the
search and save half of the building."""

LEAST_SHARE = 8
"""A child holds at least 1/8 of its parent's triangles, which bounds the depth of the tree."""

NEEDLE = 1e-8
"""A triangle thinner than this part of its length gives no frame to a box."""


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
    """Build the tree of triangles of shape (n, 3, 3)."""
    _, ids = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)
    corner_ids = ids.reshape(-1, 3)
    low, high = triangles.min(axis=1), triangles.max(axis=1)
    order = np.arange(len(triangles))
    counts = np.array([len(triangles)])
    parts: list[dict[str, NDArray[np.generic]]] = []
    first_node, first_vertex = 0, 0
    while len(counts):
        level = _bound_level(triangles, corner_ids, order, counts, first_vertex)
        splits = counts > 1
        next_node = first_node + len(counts)
        left = np.where(splits, next_node + 2 * (np.cumsum(splits) - 1), -1)
        starts = np.cumsum(counts) - counts
        level |= {
            "left": left,
            "right": np.where(splits, left + 1, -1),
            "triangle": np.where(splits, -1, order[starts]),
        }
        parts.append(level)
        first_vertex += len(level["vertices"])
        first_node = next_node
        order, counts = _split(low, high, order[np.repeat(splits, counts)], counts[splits])
    return _joined(parts)


def _joined(parts: list[dict[str, NDArray[np.generic]]]) -> Tree:
    columns = {key: np.concatenate([part[key] for part in parts]) for key in parts[0]}
    for key in ("left", "right", "triangle", "vertex_first", "vertex_count"):
        columns[key] = columns[key].astype(np.int32)
    levels = np.cumsum([0, *(len(part["left"]) for part in parts)])
    return Tree(levels=levels, **columns)


def _split(low: Floats, high: Floats, order: Ints, counts: Ints) -> tuple[Ints, Ints]:
    """Reorder the triangles of every node for its best split; sizes of all children in turn.

    Small nodes try all three axes, large ones only their longest: near the root it is as good.
    """
    arranged, sizes = order.copy(), np.ones(len(counts), np.int64)
    small = counts <= SMALL
    for nodes, tried in ((small, 3), (~small, 1)):
        inside = np.repeat(nodes, counts)
        if inside.any():
            cuts = _best_cuts(low, high, order[inside], counts[nodes], tried)
            arranged[inside], sizes[nodes] = cuts
    return arranged, np.stack([sizes, counts - sizes], axis=1).ravel()


def _best_cuts(
    low: Floats, high: Floats, order: Ints, counts: Ints, tried: int
) -> tuple[Ints, Ints]:
    """The best order of the triangles of every node, and the size of its first child."""
    segment = np.repeat(np.arange(len(counts)), counts)
    starts = np.cumsum(counts) - counts
    centres = low[order] + high[order]
    extents = np.maximum.reduceat(centres, starts) - np.minimum.reduceat(centres, starts)
    axes = np.argsort(-extents, axis=1, kind="stable")
    best_cost = np.full(len(counts), np.inf)
    best_size = np.ones(len(counts), np.int64)
    arranged = order.copy()
    for axis in axes.T[:tried]:
        centre = centres[np.arange(len(order)), axis[segment]]
        candidate = order[np.lexsort((centre, segment))]
        cost = _sweep_costs(low[candidate], high[candidate], segment, starts, counts)
        lowest = np.minimum.reduceat(cost, starts)
        position = np.flatnonzero(cost == lowest[segment])
        place = position[np.unique(segment[position], return_index=True)[1]]
        better = lowest < best_cost
        best_cost = np.where(better, lowest, best_cost)
        best_size = np.where(better, place - starts + 1, best_size)
        arranged = np.where(better[segment], candidate, arranged)
    return arranged, best_size


def _sweep_costs(low: Floats, high: Floats, segment: Ints, starts: Ints, counts: Ints) -> Floats:
    """Surface-area cost of cutting each node behind each of its triangles."""
    # Offsets larger than the scene make running extremes start anew at every node.
    step = 4.0 * (np.abs(low).max() + np.abs(high).max() + 1.0)
    shift = (segment * step)[:, None]
    lo_before = np.minimum.accumulate(low - shift) + shift
    hi_before = np.maximum.accumulate(high + shift) - shift
    lo_after = np.minimum.accumulate((low + shift)[::-1])[::-1] - shift
    hi_after = np.maximum.accumulate((high - shift)[::-1])[::-1] + shift
    rank = np.arange(len(segment)) - starts[segment] + 1
    rest = counts[segment] - rank
    before, after = _area(lo_before, hi_before), np.roll(_area(lo_after, hi_after), -1)
    cost = before * rank + after * rest
    too_few = np.minimum(rank, rest) < np.maximum(1, counts // LEAST_SHARE)[segment]
    # A cut that leaves too few on one side is worse than any other, but may be the only one.
    worst = 1e300 + np.abs(rank - rest)
    return np.where(rest == 0, np.inf, np.where(too_few, worst, cost))


def _area(low: Floats, high: Floats) -> Floats:
    d = high - low
    return np.asarray(d[:, 0] * d[:, 1] + d[:, 1] * d[:, 2] + d[:, 2] * d[:, 0])


def _bound_level(
    triangles: Floats, corner_ids: Ints, order: Ints, counts: Ints, first_vertex: int
) -> dict[str, NDArray[np.generic]]:
    """Boxes and vertices of the nodes of one level.

    The box of a node that carries its vertices only serves to aim: it stays axis-aligned. Of many
    triangles the vertices are not even counted.
    """
    points = triangles[order].reshape(-1, 3)
    few = counts <= MANY
    small = np.repeat(few, 3 * counts)
    node = np.repeat(np.arange(len(counts)), 3 * counts)[small]
    keys = node * (corner_ids.max() + 1) + corner_ids[order].ravel()[small]
    where = np.unique(keys, return_index=True)[1]
    owner = node[where]
    distinct = np.bincount(owner, minlength=len(counts))
    kept = few & (distinct <= VERTEX_LIMIT)
    count = np.where(kept, distinct, 0)

    starts = 3 * (np.cumsum(counts) - counts)
    low = np.minimum.reduceat(points, starts)
    high = np.maximum.reduceat(points, starts)
    frame = np.tile(np.eye(3), (len(counts), 1, 1))
    centre, extent = (low + high) / 2.0, (high - low) / 2.0
    boxed = np.flatnonzero(~kept)
    if len(boxed):
        of_boxed = np.repeat(~kept, counts)
        boxes = _oriented_boxes(triangles[order[of_boxed]], counts[boxed])
        frame[boxed], centre[boxed], extent[boxed] = boxes
    return {
        "frame": frame,
        "centre": centre,
        "extent": extent,
        "size": np.linalg.norm(extent, axis=1),
        "vertex_first": first_vertex + np.cumsum(count) - count,
        "vertex_count": count,
        "vertices": points[small][where[kept[owner]]],
    }


def _oriented_boxes(triangles: Floats, counts: Ints) -> tuple[Floats, Floats, Floats]:
    """The best of three boxes per node: axis-aligned, principal axes, largest triangle."""
    points = triangles.reshape(-1, 3)
    starts = 3 * (np.cumsum(counts) - counts)
    node = np.repeat(np.arange(len(counts)), 3 * counts)
    frames = [np.broadcast_to(np.eye(3), (len(counts), 3, 3))]
    frames.append(_principal_frames(points, node, starts, counts))
    frames.append(_triangle_frames(triangles, starts // 3, node[::3]))
    boxes = []
    for number, frame in enumerate(frames):
        turned = np.einsum("nij,nj->ni", frame[node], points) if number else points
        low = np.minimum.reduceat(turned, starts)
        high = np.maximum.reduceat(turned, starts)
        boxes.append((frame, low, high, _area(low, high) + 1e-3 * (high - low).sum(axis=1) ** 2))
    choice = np.argmin([area for *_, area in boxes], axis=0)
    rows = np.arange(len(counts))
    frame = np.stack([b[0] for b in boxes])[choice, rows]
    low = np.stack([b[1] for b in boxes])[choice, rows]
    high = np.stack([b[2] for b in boxes])[choice, rows]
    centre = np.einsum("nji,nj->ni", frame, (low + high) / 2.0)
    return frame, centre, (high - low) / 2.0


def _principal_frames(points: Floats, node: Ints, starts: Ints, counts: Ints) -> Floats:
    """Principal axes of the vertices of each node."""
    mean = np.add.reduceat(points, starts) / (3 * counts)[:, None]
    spread = points - mean[node]
    moments = np.zeros((len(counts), 3, 3))
    for i, j in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)):
        moments[:, j, i] = np.add.reduceat(spread[:, i] * spread[:, j], starts)
    # eigh reads the lower triangle only.
    return np.asarray(np.linalg.eigh(moments)[1].transpose(0, 2, 1))


def _triangle_frames(triangles: Floats, starts: Ints, node: Ints) -> Floats:
    """Frame of the largest triangle of each node: longest edge, in-plane normal, normal."""
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    area = np.linalg.norm(normal, axis=1)
    largest = np.flatnonzero(area == np.maximum.reduceat(area, starts)[node])
    chosen = largest[np.unique(node[largest], return_index=True)[1]]
    edges = triangles[chosen] - np.roll(triangles[chosen], 1, axis=1)
    lengths = np.linalg.norm(edges, axis=2)
    rows = np.arange(len(chosen))
    longest = lengths.argmax(axis=1)
    # The normal of a needle is noise: its frame would be skew, and the box would lose the triangle.
    sound = area[chosen] > NEEDLE * lengths[rows, longest] ** 2
    u = edges[rows, longest] / np.where(sound, lengths[rows, longest], 1.0)[:, None]
    v = np.cross(normal[chosen], u)
    v /= np.where(sound, np.linalg.norm(v, axis=1), 1.0)[:, None]
    frame = np.stack([u, v, np.cross(u, v)], axis=1)
    return np.where(sound[:, None, None], frame, np.eye(3))

"""The stock at the start on the device: a box, or closed triangles with a grid across the beams."""

from __future__ import annotations

import numpy as np
import warp as wp
from numpy.typing import NDArray

from gcodesim.machine.model import Body
from gcodesim.stock.solid_lines import SolidArrays

Array = NDArray[np.float64]

TRIANGLES_PER_CELL = 2.0
"""About so many; more cells cost memory, fewer cost time."""


def solid_arrays(body: Body, order: tuple[int, int, int], device: str) -> SolidArrays:
    """A stock with its axes in another order (cyclic), so that beams run along the third."""
    triangles = np.concatenate([part.triangles for part in body.parts])[:, :, order]
    low, high = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
    solid = SolidArrays()
    solid.low, solid.high = wp.vec3d(*low), wp.vec3d(*high)
    first, members, cells = np.zeros(1, np.int64), np.zeros(0, np.int64), (0, 0)
    if not is_box(body, low, high, triangles):
        first, members, cells = _grid(triangles, low, high)
    solid.cells = wp.vec2i(*cells)
    solid.triangles = wp.array(triangles, dtype=wp.mat33d, device=device)
    solid.cell_first = wp.array(first, dtype=wp.int32, device=device)
    solid.cell_triangle = wp.array(members, dtype=wp.int32, device=device)
    return solid


def is_box(body: Body, low: Array, high: Array, triangles: Array) -> bool:
    """Whether a body is one box along the axes."""
    at_corner = ((triangles == low) | (triangles == high)).all()
    return len(body.parts) == 1 and len(triangles) == 12 and bool(at_corner)


def _grid(
    triangles: Array, low: Array, high: Array
) -> tuple[NDArray[np.int64], NDArray[np.int64], tuple[int, int]]:
    """The triangles by cell of a grid in x and y: first of each cell, members, and cells."""
    size = (high - low)[:2]
    cell = float(np.sqrt(size.prod() * TRIANGLES_PER_CELL / len(triangles)))
    counts = np.clip(np.ceil(size / cell), 1, 2000).astype(int)
    place = (triangles[:, :, :2] - low[:2]) / size * counts
    # One cell more on each side: the cell of a line is found with other roundings.
    first = np.clip(np.floor(place.min(axis=1) - 1e-6), 0, counts - 1).astype(int)
    last = np.clip(np.floor(place.max(axis=1) + 1e-6), 0, counts - 1).astype(int)
    wide = last - first + 1
    each = wide.prod(axis=1)
    owner = np.repeat(np.arange(len(triangles)), each)
    number = np.arange(each.sum()) - np.repeat(np.cumsum(each) - each, each)
    x = first[owner, 0] + number % wide[owner, 0]
    y = first[owner, 1] + number // wide[owner, 0]
    key = y * counts[0] + x
    order = np.argsort(key, kind="stable")
    starts = np.searchsorted(key[order], np.arange(counts.prod() + 1))
    return starts.astype(np.int64), owner[order], (int(counts[0]), int(counts[1]))

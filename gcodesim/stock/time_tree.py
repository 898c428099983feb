"""The race on the device: items with their tree in the order of time, tools, and the stock."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from gcodesim.motion.path import Path
from gcodesim.stock.line_cuts import Seams
from gcodesim.stock.race import BOX, CLOCK, ItemArrays, Primitive, RaceArrays
from gcodesim.stock.shapes_of_tools import Solid, ToolShape
from gcodesim.stock.solid_lines import SolidArrays
from gcodesim.stock.tool_items import Items

Array = NDArray[np.float64]

NOWHERE = np.float32(3.0e38)


def race_arrays(
    items: Items, shapes: Mapping[int, ToolShape], solid: SolidArrays, path: Path, period_ps: int,
    device: str,
) -> RaceArrays:  # fmt: skip
    """Copy a race to the device."""
    job = RaceArrays()
    job.items = _item_arrays(items, path, device)
    job.solid = solid
    rows = np.zeros((2 * (max(shapes, default=0) + 1), 3), np.int32)
    flat: list[Solid] = []
    for number, shape in shapes.items():
        for side, (flutes, others) in enumerate((shape.proof, shape.witness)):
            first = len(flat)
            flat += [*flutes, *others]
            rows[2 * number + side] = first, first + len(flutes), len(flat)
    job.primitives = _primitives(flat, device)
    job.rows = wp.array(rows, dtype=wp.vec3i, device=device)
    job.leaves = 1 << max(1, int(np.ceil(np.log2(max(len(items), 1)))))
    job.cut_box = box_tree(items.cut_box, job.leaves, device)
    job.body_box = box_tree(items.body_box, job.leaves, device)
    job.count = len(items)
    job.period_ps = period_ps
    return job


def _item_arrays(items: Items, path: Path, device: str) -> ItemArrays:
    arrays = ItemArrays()
    columns: dict[str, tuple[NDArray[Any], Any]] = {
        "origin": (items.origin, wp.vec3d),
        "way": (items.way, wp.vec3d),
        "axis": (items.axis, wp.vec3d),
        "tilt": (items.tilt, wp.vec3d),
        "doubt": (items.doubt, wp.vec2d),
        "flags": (items.flags, wp.int32),
        "muted": (items.muted, wp.int32),
        "tool": (items.tool, wp.int32),
        "clock": (items.clock, CLOCK),
        "law": (path.law[items.piece], wp.vec3d),
        "fraction": (items.fraction, wp.vec2d),
    }
    for name, (values, dtype) in columns.items():
        setattr(arrays, name, wp.array(np.ascontiguousarray(values), dtype=dtype, device=device))
    return arrays


def _primitives(flat: list[Solid], device: str) -> Any:
    made = []
    for solid in flat:
        one = Primitive()
        one.kind, one.part = solid.kind, solid.part
        one.shape = wp.vec4d(*solid.shape)
        one.lever, one.middle, one.reach = solid.lever, solid.middle, solid.reach
        one.seams = Seams()
        one.seams.low, one.seams.high = solid.seams
        one.seams.below, one.seams.above = solid.beside
        one.seams.limit = solid.limit
        made.append(one)
    return wp.array(made, dtype=Primitive, device=device)


def box_tree(boxes: Array, leaves: int, device: str) -> Any:
    """An implicit binary tree: root 1, children 2 i and 2 i + 1, boxes in float32 outward."""
    low, high = np.full((2 * leaves, 3), NOWHERE), np.full((2 * leaves, 3), -NOWHERE)
    used = np.flatnonzero(boxes[:, 0] <= boxes[:, 1])
    infinity = np.float32(np.inf)
    low[leaves + used] = np.nextafter(boxes[used, 0::2].astype(np.float32), -infinity)
    high[leaves + used] = np.nextafter(boxes[used, 1::2].astype(np.float32), infinity)
    level = leaves
    while level > 1:
        low[level // 2 : level] = low[level : 2 * level].reshape(-1, 2, 3).min(axis=1)
        high[level // 2 : level] = high[level : 2 * level].reshape(-1, 2, 3).max(axis=1)
        level //= 2
    tree = np.empty((2 * leaves, 6), np.float32)
    tree[:, 0::2], tree[:, 1::2] = low, high
    return wp.array(tree, dtype=BOX, device=device)

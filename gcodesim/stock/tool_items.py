"""Items of the race: the straight pieces of the tool's way that come near the stock.

A piece in which nothing turns and nothing bends is one item. Others are cut until what they leave
their chords by is a small part of the inset, for each part of the tool that comes near the stock.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from gcodesim.motion.path import Path, path_fraction
from gcodesim.stock.shapes_of_tools import BALL, Solid, ToolShape, heights
from gcodesim.stock.tool_frames import ToolWay

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

CUTS, FLUTE_IS_BODY, OTHERS_ARE_BODIES = 1, 2, 4

LEAVES_MORE = 1.01
"""Bounds of first order are widened by this part: it covers what is of second order below 0.1
radians, and turns are cut to less."""

LARGEST_TURN = 0.1
"""An item turns by no more than this [rad]."""

LEAST_TURN = 1.0e-12
"""What turns by less [rad] does not turn: so much is rounding."""

HALVINGS = 60
"""To find the time at which a fraction of a piece is done."""


@dataclass(frozen=True)
class Near:
    """What items have to come near to: the stock's box [mm], and how fine they are cut.

    Attributes:
        low, high: corners of the box, (3,).
        order: which axis of the link comes first, second and third: beams run along the third.
        doubt: how far an item may leave what stands for it [mm].
    """

    low: Array
    high: Array
    order: tuple[int, int, int]
    doubt: float


@dataclass(frozen=True)
class Items:
    """m items in the order of time: columns as in race.ItemArrays.

    Attributes:
        piece: path piece, shape (m,).
        cut_box, body_box: what flutes that cut, and bodies, sweep: x, y, z low and high, (m, 6).
        left_out: pieces of the path in which no part of a tool comes near the stock.
    """

    piece: Ints
    origin: Array
    way: Array
    axis: Array
    tilt: Array
    doubt: Array
    flags: NDArray[np.int32]
    muted: NDArray[np.int32]
    tool: NDArray[np.int32]
    clock: Ints
    fraction: Array
    cut_box: Array
    body_box: Array
    left_out: int = 0

    def __len__(self) -> int:
        return len(self.piece)

    def taken(self, index: NDArray[np.intp]) -> Items:
        """The items `index`."""
        columns = {name: v[index] for name, v in vars(self).items() if isinstance(v, np.ndarray)}
        return Items(**columns, left_out=self.left_out)


def tool_items(
    way: ToolWay, tools: NDArray[np.int32], shapes: Mapping[int, ToolShape], near: Near
) -> Items:
    """The items of a path.

    Args:
        way: of the tool, seen from the link of the stock.
        tools: number of the tool's shape in each piece, -1 for none, shape (n,).
        shapes: by that number.
        near: the stock.
    """
    found = [_Cut.of(way, np.flatnonzero(tools == n), shape, near) for n, shape in shapes.items()]
    joined = {name: np.concatenate([getattr(c, name) for c in found]) for name in _Cut.COLUMNS}
    order = np.argsort(joined["piece"], kind="stable")
    cut = _Cut(**{name: column[order] for name, column in joined.items()})
    items = _items(way, cut, tools, near)
    cut_box, body_box = _boxes(items, shapes, near)
    used = np.flatnonzero((body_box[:, 0] <= body_box[:, 1]) | (cut_box[:, 0] <= cut_box[:, 1]))
    items = replace(items, cut_box=cut_box, body_box=body_box).taken(used)
    return replace(items, left_out=len(way.path) - len(np.unique(items.piece)))


def _places(count: Ints) -> Array:
    """Start and end of every item as fractions of its piece, shape (m, 2)."""
    number = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    each = np.repeat(count, count)
    return np.stack([number / each, (number + 1) / each], axis=1)


@dataclass(frozen=True)
class _Cut:
    """Pieces near the stock, into how many items each is cut, and how its points and axis bend."""

    piece: Ints
    count: Ints
    bend: Array
    axis_bend: Array

    COLUMNS: ClassVar = ("piece", "count", "bend", "axis_bend")

    @classmethod
    def of(cls, way: ToolWay, pieces: Ints, shape: ToolShape, near: Near) -> _Cut:
        """Those of one tool."""
        path, size = way.path, heights(shape)
        ends = [way.placed(q[pieces]) for q in (path.q0, path.q1)]
        bend, axis_bend = np.zeros(len(pieces)), np.zeros(len(pieces))
        curved = np.flatnonzero(way.turns()[pieces] | (path.arc[pieces] >= 0))
        bend[curved], axis_bend[curved] = way.bends(pieces[curved], size)
        low, high, radius = size
        corners = [o + z * a for o, a in ends for z in (low, high)]
        room = (radius + bend / 8.0 + path.deviation_mm)[:, None]
        box = np.min(corners, axis=0) - room, np.max(corners, axis=0) + room
        kept = np.flatnonzero(_meets(box[0][:, near.order], box[1][:, near.order], near))
        turn = np.linalg.norm(ends[1][1] - ends[0][1], axis=1)[kept]
        bend, axis_bend = bend[kept], axis_bend[kept]
        return cls(pieces[kept], _counts(shape, near, turn, (bend, axis_bend)), bend, axis_bend)


def _counts(
    shape: ToolShape, near: Near, turn: Array, bends: tuple[Array, Array]
) -> NDArray[np.int64]:
    """Into how many items pieces are cut, so that each is doubtful by no more than is allowed."""
    sides = (shape.proof, shape.witness)
    lever = max(s.lever for side in sides for group in side for s in group)
    first = LEAVES_MORE * turn * lever / 2.0 / near.doubt
    second = (bends[0] + bends[1] * lever) / 8.0 / near.doubt
    # The least n with first / n + second / n^2 <= 1.
    count = np.ceil(first / 2.0 + np.sqrt(first**2 / 4.0 + second) - 1e-9)
    count = np.maximum(count, np.ceil(turn / LARGEST_TURN))
    return np.maximum(count, 1).astype(np.int64)


def _meets(low: Array, high: Array, near: Near) -> NDArray[np.bool_]:
    return np.asarray(((low < near.high) & (high > near.low)).all(axis=1))


def _items(way: ToolWay, cut: _Cut, tools: NDArray[np.int32], near: Near) -> Items:
    path, order = way.path, near.order
    piece, places = np.repeat(cut.piece, cut.count), _places(cut.count)
    bend, axis_bend = np.repeat(cut.bend, cut.count), np.repeat(cut.axis_bend, cut.count)
    times = [_times(path, piece, places[:, k]) for k in (0, 1)]
    (o0, a0, s0), (o1, a1, s1) = (way.at(piece, t) for t in times)
    part, tilt = (s1 - s0) ** 2 / 8.0, np.linalg.norm(a1 - a0, axis=1)
    off = bend * part + np.where(way.turns()[piece], path.deviation_mm, 0.0)
    turn = LEAVES_MORE * (tilt / 2.0 + axis_bend * part)
    turn[turn < LEAST_TURN] = 0.0
    flags = np.full(len(piece), OTHERS_ARE_BODIES, np.int32)
    cuts = np.ones(len(path), np.bool_) if path.cuts is None else path.cuts
    flags |= np.where(cuts[piece], CUTS, FLUTE_IS_BODY).astype(np.int32)
    if path.touching is not None:
        # A skip move is for touching: its flute neither cuts nor may it not be there.
        flags[path.touching[piece]] = OTHERS_ARE_BODIES
    none = np.zeros((len(piece), 6))
    return Items(
        piece=piece,
        origin=o0[:, order],
        way=(o1 - o0)[:, order],
        axis=a0[:, order],
        tilt=np.where(turn[:, None] > 0.0, a1 - a0, 0.0)[:, order],
        doubt=np.stack([off, turn], axis=1),
        flags=flags,
        muted=np.zeros(len(piece), np.int32),
        tool=tools[piece].astype(np.int32),
        clock=np.stack([*times, path.bounds_ps[piece], path.bounds_ps[piece + 1]], axis=1),
        fraction=np.stack([s0, s1], axis=1),
        cut_box=none,
        body_box=none,
    )


def _times(path: Path, piece: Ints, fraction: Array) -> Ints:
    """Times [ps] at which fractions of pieces are done."""
    start, end = path.bounds_ps[piece], path.bounds_ps[piece + 1]
    law = path.law[piece]
    tau = fraction.copy()
    some = np.flatnonzero((law[:, 0] != 1.0) & (fraction > 0.0) & (fraction < 1.0))
    if len(some):
        low, high = np.zeros(len(some)), np.ones(len(some))
        for _ in range(HALVINGS):
            middle = (low + high) / 2.0
            below = path_fraction(law[some], middle) < fraction[some]
            low, high = np.where(below, middle, low), np.where(below, high, middle)
        tau[some] = high
    return np.asarray(start + np.rint(tau * (end - start)).astype(np.int64))


def _boxes(items: Items, shapes: Mapping[int, ToolShape], near: Near) -> tuple[Array, Array]:
    """What flutes that cut, and bodies, sweep in each item; empty where that misses the stock."""
    none = np.tile([np.inf, -np.inf], 3)
    cut_box, body_box = (np.tile(none, (len(items), 1)) for _ in range(2))
    cuts = (items.flags & CUTS) != 0
    bodies = (items.flags & FLUTE_IS_BODY) != 0
    for number, shape in shapes.items():
        own = items.tool == number
        for flutes, others in (shape.proof, shape.witness):
            for solid in flutes:
                _add_box(cut_box, np.flatnonzero(own & cuts), items, solid, near)
                _add_box(body_box, np.flatnonzero(own & bodies), items, solid, near)
            for solid in others:
                _add_box(body_box, np.flatnonzero(own), items, solid, near)
    return cut_box, body_box


def _add_box(boxes: Array, index: NDArray[np.intp], items: Items, solid: Solid, near: Near) -> None:
    if not len(index):
        return
    start = items.origin[index], items.axis[index]
    end = start[0] + items.way[index], start[1] + items.tilt[index]
    ends = [_solid_box(solid, *place) for place in (start, end)]
    room = items.doubt[index, :1] + items.doubt[index, 1:] * solid.lever
    low = np.minimum(ends[0][0], ends[1][0]) - room
    high = np.maximum(ends[0][1], ends[1][1]) + room
    kept = np.flatnonzero(_meets(low, high, near))
    rows = index[kept]
    boxes[rows, 0::2] = np.minimum(boxes[rows, 0::2], low[kept])
    boxes[rows, 1::2] = np.maximum(boxes[rows, 1::2], high[kept])


def _solid_box(solid: Solid, origin: Array, axis: Array) -> tuple[Array, Array]:
    z0, z1, r0, r1 = solid.shape
    if solid.kind == BALL:
        centre = origin + z0 * axis
        return centre - r0, centre + r0
    across = np.sqrt(np.maximum(1.0 - axis**2, 0.0))
    low, high = origin + z0 * axis, origin + z1 * axis
    return (
        np.minimum(low - r0 * across, high - r1 * across),
        np.maximum(low + r0 * across, high + r1 * across),
    )

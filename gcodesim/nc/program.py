"""The canonical program: what the control would do, as columns of arrays in machine units."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gcodesim.constants import FULL_CIRCLE_MM

Floats = NDArray[np.float64]

AXES = "XYZABC"
"""Order of the six axis columns: X Y Z in mm, A B C in degrees."""


Vector = tuple[float, float, float, float, float, float]
"""X Y Z [mm], A B C [deg]."""

ZERO: Vector = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


class Plane(IntEnum):
    """A plane of two axes; arcs turn in it, tools stand square on it."""

    XY = 0
    ZX = 1
    YZ = 2


PLANES = ((0, 1, 2), (2, 0, 1), (1, 2, 0))
"""Plane -> indices of its axes u and v and of its normal w."""


class Frame(IntEnum):
    """What the end point of a move is counted in; a switch between frames moves nothing.

    In WORK and GREAT_CIRCLE `to` holds the tip of the tool [mm] and the rotary axis positions
    [deg]. The tip is counted in the frame that rides on the work link, as it stands with all rotary
    joints at zero, in machine coordinates: there the axis position is the tip plus the tool offset.
    The tip runs straight, or along its arc, in that frame, and F is its speed there.
    """

    MACHINE = 0  # axis positions; every joint runs straight
    WORK = 1  # the rotary axes run linearly while the tip runs
    GREAT_CIRCLE = 2  # the tool axis runs along the great circle between its two directions


class Kind(IntEnum):
    """Kind of a canonical command, named as in RS274/NGC."""

    RAPID = 0  # straight traverse to `to`
    FEED = 1  # straight feed to `to`
    ARC = 2  # arc feed to `to`; `aux` is the row in `arcs`
    DWELL = 3  # stand still for `f` seconds
    TOOL = 4  # tool number `aux` goes into the spindle
    TOOL_OFFSET = 5  # `to` is the new tool offset
    G5X = 6  # work offset number `aux` (1 = G54) becomes active with value `to`
    G92 = 7  # `to` is the new G92 offset
    MESSAGE = 8  # `aux` is the row in `texts`
    STOP = 9  # M0, M1, M2, M30; `aux` is the M number
    PATH = 10  # G61 G61.1 G64: `aux` is the code in tenths, `f` the tolerance P [mm], 0 without


class Turning(IntEnum):
    """What is known of the spindle while a command runs."""

    STANDS = 0  # not started yet, or stopped since
    MAY_TURN = 1  # started, or after a code of the builder's that may start it
    TURNED_AWAY = 2  # stands at an angle at which the edge clears the wall: the shift of G76, G87
    HALTED = 3  # turned when M0 or M1 came: it stands or turns on (Readings.spindle_at_stop)


class FeedMode(IntEnum):
    """How the column `f` of a feed or arc is to be read."""

    PER_MINUTE = 94  # mm/min; deg/min where no linear axis moves
    INVERSE_TIME = 93  # 1/min: the move takes 1/f minutes
    PER_REVOLUTION = 95  # mm/rev at `speed` rev/min


StockCorners = tuple[list[float], list[float]]
"""Two opposite corners of a box, X Y Z [mm]."""

ARC_DTYPE = np.dtype([("center", "f8", 3), ("normal", "f8", 3), ("turns", "i4")])
"""Arc data: centre [mm] in the frame of the move, plane normal, turns (> 0 counter-clockwise about
the normal, |turns| - 1 extra full turns)."""


@dataclass(frozen=True)
class CanonicalProgram:
    """Columns of n canonical commands in the order of execution.

    Attributes:
        kind: Kind, shape (n,) uint8.
        line: 1-based source line, shape (n,) int32; 0 = set-up.
        frame: Frame of `to`, shape (n,) uint8; all offsets but the tool's are resolved.
        to: end point of a move, or the vector value of a command, shape (n, 6), mm and deg.
        f: feed as feed_mode says, or seconds of a dwell, shape (n,) float64.
        feed_mode: FeedMode, shape (n,) uint8.
        speed: spindle speed [rev/min] in force, shape (n,) float32.
        aux: see Kind, shape (n,) int32.
        turning: Turning but HALTED, shape (n,) uint8; None = may turn throughout.
        touching: rows of skip moves, and of moves that begin where one has stopped: what the flute
            touches there stopped it.
        arcs: rows of ARC_DTYPE.
        texts: messages.
        start: machine position before the first command, shape (6,).
        stock: the stock that the program itself defines, as positions; None without one.
    """

    kind: NDArray[np.uint8]
    line: NDArray[np.int32]
    frame: NDArray[np.uint8]
    to: NDArray[np.float64]
    f: NDArray[np.float64]
    feed_mode: NDArray[np.uint8]
    speed: NDArray[np.float32]
    aux: NDArray[np.int32]
    arcs: NDArray[np.void]
    start: NDArray[np.float64]
    texts: list[str] = field(default_factory=list)
    stock: StockCorners | None = None
    turning: NDArray[np.uint8] | None = None
    touching: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))

    def __len__(self) -> int:
        return len(self.kind)


def starts_of_moves(program: CanonicalProgram) -> Floats:
    """Return the machine position before every command, shape (n, 6), mm and deg."""
    is_move = program.kind <= Kind.ARC
    # Row 0 is the start; a move's row is its own number + 1, carried on over other commands.
    last = np.maximum.accumulate(np.where(is_move, np.arange(1, len(program) + 1), 0))
    before = np.concatenate(([0], last[:-1])) if len(program) else last
    positions = np.vstack([program.start[None, :], program.to])
    return np.asarray(positions[before], np.float64)


def path_lengths(program: CanonicalProgram) -> Floats:
    """Return what the feed of each command is counted along, shape (n,).

    XYZ path length [mm] where X, Y or Z moves, else the Euclidean length in A B C [deg];
    0 for commands that are no moves.
    """
    start = starts_of_moves(program)
    lengths = np.zeros(len(program))
    straight = program.kind <= Kind.FEED
    step = program.to[straight] - start[straight]
    linear = np.sqrt((step[:, :3] ** 2).sum(axis=1))
    rotary = np.sqrt((step[:, 3:] ** 2).sum(axis=1))
    lengths[straight] = np.where(linear > 0, linear, rotary)
    is_arc = program.kind == Kind.ARC
    if is_arc.any():
        arcs = program.arcs[program.aux[is_arc]]
        lengths[is_arc] = arc_lengths(start[is_arc, :3], program.to[is_arc, :3], arcs)
    return lengths


def arc_lengths(start: Floats, end: Floats, arcs: NDArray[Any]) -> Floats:
    """Return the lengths [mm] of arcs between points of shape (n, 3), helix and turns included.

    A radius that changes from start to end counts with its mean along the angle and its change
    across it, as the rise of a helix does.
    """
    first, last, rise = _in_plane(start, end, arcs)
    radius_first, radius_last = (np.sqrt((v**2).sum(axis=1)) for v in (first, last))
    along = (radius_first + radius_last) / 2 * np.abs(arc_sweeps(start, end, arcs))
    lengths = np.sqrt(along**2 + (radius_last - radius_first) ** 2 + rise**2)
    return np.asarray(lengths, np.float64)


def arc_sweeps(start: Floats, end: Floats, arcs: NDArray[Any]) -> Floats:
    """Return the angles [rad] that arcs turn through, > 0 counter-clockwise, all turns included.

    The one place that decides between a full turn and none: an end nearer than FULL_CIRCLE_MM
    along the arc is a full turn.
    """
    first, last, _ = _in_plane(start, end, arcs)
    sense = np.sign(arcs["turns"]).astype(np.float64)
    cross = (np.cross(first, last) * arcs["normal"]).sum(axis=1)
    angle = np.mod(sense * np.arctan2(cross, (first * last).sum(axis=1)), 2 * np.pi)
    radius = np.sqrt((first**2).sum(axis=1))
    angle = np.where(angle * radius < FULL_CIRCLE_MM, angle + 2 * np.pi, angle)
    return np.asarray(sense * (angle + 2 * np.pi * (np.abs(arcs["turns"]) - 1)), np.float64)


def _in_plane(start: Floats, end: Floats, arcs: NDArray[Any]) -> tuple[Floats, Floats, Floats]:
    """Return start and end as seen from the centre in the plane, and the rise out of it."""
    normal = arcs["normal"]
    vectors = []
    for point in (start, end):
        arm = point - arcs["center"]
        vectors.append(arm - (arm * normal).sum(axis=1)[:, None] * normal)
    rise = ((end - start) * normal).sum(axis=1)
    return vectors[0], vectors[1], rise

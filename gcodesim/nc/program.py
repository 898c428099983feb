"""The canonical program: what the control would do, as columns of arrays in machine units."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

AXES = "XYZABC"
"""Order of the six axis columns: X Y Z in mm, A B C in degrees."""


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


class FeedMode(IntEnum):
    """How the column `f` of a feed or arc is to be read."""

    PER_MINUTE = 94  # mm/min; deg/min where no linear axis moves
    INVERSE_TIME = 93  # 1/min: the move takes 1/f minutes
    PER_REVOLUTION = 95  # mm/rev at `speed` rev/min


ARC_DTYPE = np.dtype([("center", "f8", 3), ("normal", "f8", 3), ("turns", "i4")])
"""Arc data: centre [mm] in the frame of the move, plane normal, turns (> 0 counter-clockwise about
the normal, |turns| - 1 extra full turns)."""


@dataclass(frozen=True)
class CanonicalProgram:
    """Columns of n canonical commands in the order of execution.

    Attributes:
        kind: Kind, shape (n,) uint8.
        line: 1-based source line, shape (n,) int32; 0 = set-up.
        frame: frame of `to`, shape (n,) uint8: 0 = machine frame (all offsets resolved). Other
            frames (tilted plane, tool centre point) are resolved by motion/.
        to: end point of a move, or the vector value of a command, shape (n, 6), mm and deg.
        f: feed as feed_mode says, or seconds of a dwell, shape (n,) float64.
        feed_mode: FeedMode, shape (n,) uint8.
        speed: spindle speed [rev/min] in force, shape (n,) float32.
        aux: see Kind, shape (n,) int32.
        arcs: rows of ARC_DTYPE.
        texts: messages.
        start: machine position before the first command, shape (6,).
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

    def __len__(self) -> int:
        return len(self.kind)

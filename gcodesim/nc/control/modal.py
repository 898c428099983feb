"""The modal state: what stays in force from line to line, in terms that every language shares."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, IntEnum

from gcodesim.nc.program import FeedMode, Plane


class Motion(IntEnum):
    """What a line of plain axis words does; the values stand in columns.Columns too."""

    RAPID = 0
    FEED = 1
    CLOCKWISE = 2
    COUNTER_CLOCKWISE = 3
    THREADING = 4
    RIGID_TAPPING = 5
    NONE = -1


class Spindle(Enum):
    """What the spindle does."""

    OFF, CLOCKWISE, COUNTER_CLOCKWISE, ORIENTED = range(4)


TURNING = (Spindle.CLOCKWISE, Spindle.COUNTER_CLOCKWISE)


class TipControl(Enum):
    """Tool centre point control: what X Y Z and the words of direction mean."""

    OFF = 0  # X Y Z are axis positions, or a tip in the tilted plane
    ANGLES = 1  # X Y Z are the tip, rotary words are axis positions
    VECTORS = 2  # X Y Z are the tip, words of direction point the tool


class CutterSide(Enum):
    """The side of the path on which the cutter runs."""

    NONE, LEFT, RIGHT = range(3)


@dataclass(slots=True)
class Modal:
    """What stays in force from line to line.

    Attributes:
        motion: what plain axis words do.
        drilling: plain axis words drill a hole: a cycle is in force.
        plane: of arcs, rotations and cycles.
        incremental: words count from the current point unless they say otherwise.
        centre_absolute: arc centres are points of the program frame, not steps from the start.
        inch: lengths are in inches.
        feed_mode, feed: F as programmed, None when missing or cleared by a change of feed mode.
        feed_scale: mm per length unit that was in force at the F word.
        feed_given: an F word was read, so Control.feed is not used any more.
        speed: of the spindle [rev/min].
        surface_speed: words of speed are no number of revolutions, and leave `speed` alone.
        tip_control: whether, and how, X Y Z are the tip of the tool.
        table_offset: the table carries the work offset's zero point along.
        selected: tool number that was selected last, None before it.
        tool: tool number in the spindle, None before the first change.
    """

    motion: Motion = Motion.NONE
    drilling: bool = False
    plane: Plane = Plane.XY
    incremental: bool = False
    centre_absolute: bool = False
    inch: bool = False
    feed_mode: FeedMode = FeedMode.PER_MINUTE
    feed: float | None = None
    feed_scale: float = 1.0
    feed_given: bool = False
    speed: float = 0.0
    surface_speed: bool = False
    spindle: Spindle = Spindle.OFF
    side: CutterSide = CutterSide.NONE
    tip_control: TipControl = TipControl.OFF
    table_offset: bool = False
    selected: int | None = None
    tool: int | None = None

    @property
    def spindle_turns(self) -> bool:
        """The spindle turns, whichever way."""
        return self.spindle in TURNING

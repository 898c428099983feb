"""A row of the table of codes: the groups, the order of execution, and what a code takes."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, IntEnum


class Group(Enum):
    """Modal groups; a block takes one code of each but NONE."""

    NONE, MOTION, CYCLE, PLANE, DISTANCE, CENTRE_DISTANCE, FEED_MODE, UNIT = range(8)
    COMPENSATION, LENGTH, CYCLE_RETURN, WORK_OFFSET, PATH, FRAME, TABLE = range(8, 15)
    POLAR, MIRROR, ONE_SHOT = range(15, 18)
    STOP, CHANGE, SPINDLE, COOLANT, CALL, OVERRIDE, TCP, SPEED = range(18, 26)


class Order(IntEnum):
    """Order of execution inside a block; 1 is messages."""

    FEED_MODE = 2
    FEED = 3
    SPEED = 4
    TOOL = 5
    CHANGE = 6
    SPINDLE = 7
    COOLANT = 8
    OTHER = 9
    DWELL = 10
    PLANE = 11
    UNIT = 12
    COMPENSATION = 13
    LENGTH = 14
    WORK_OFFSET = 15
    PATH = 16
    DISTANCE = 17
    CYCLE_RETURN = 18
    ONE_SHOT = 19
    MOTION = 20
    STOP = 21


AXIS_WORDS = "XYZABC"


@dataclass(frozen=True, eq=False)
class Row:
    """One code; every row is its own.

    Attributes:
        letter, number: the code, number in tenths: G43.4 is ("G", 434).
        group, order: see there.
        words: letters it uses.
        sentence: what it does.
        action: name of its action, see actions.ACTIONS; empty when it changes nothing the check
            looks at.
        refused: why gcodesim stops at this code; empty for a code it follows.
        dialects: names of the dialects that have it; empty = all.
        optional: axis words beside it belong to motion when there is a motion code.
    """

    letter: str
    number: int
    group: Group
    order: Order
    words: str
    sentence: str
    action: str = ""
    refused: str = ""
    dialects: str = ""
    optional: bool = False

    @property
    def name(self) -> str:
        """The code as people write it."""
        return f"{self.letter}{self.number / 10:g}" if self.letter in "GM" else self.letter

    @property
    def takes_axes(self) -> bool:
        """The code uses axis words as such (G4 takes X as a time)."""
        return AXIS_WORDS in self.words

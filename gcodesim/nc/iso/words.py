"""The one table of codes: group checks, word checks, order and supported list follow from it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum, IntEnum

from gcodesim.nc.control.readings import Readings
from gcodesim.nc.control.state import State
from gcodesim.nc.control.supply import Control
from gcodesim.nc.iso import calls, cycles, five_axis, offsets, tables
from gcodesim.nc.iso import modes as settings
from gcodesim.nc.iso import motion as moves
from gcodesim.nc.iso.block import Block

Action = Callable[[State, Block, int], None]
"""What a code does; the number is its code in tenths."""


class Group(Enum):
    """Modal groups (nc-language section 3); a block takes one code of each but NONE."""

    NONE, MOTION, CYCLE, PLANE, DISTANCE, CENTRE_DISTANCE, FEED_MODE, UNIT = range(8)
    COMPENSATION, LENGTH, CYCLE_RETURN, WORK_OFFSET, PATH, FRAME, TABLE = range(8, 15)
    POLAR, MIRROR, ONE_SHOT = range(15, 18)
    STOP, CHANGE, SPINDLE, COOLANT, CALL, OVERRIDE, TCP, SPEED = range(18, 26)


class Order(IntEnum):
    """Order of execution inside a block (nc-language section 4); 1 is messages."""

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
LEFT_OVER = "PQREL"
"""Words that a code takes whose meaning is not ours."""


@dataclass(frozen=True, eq=False)
class Row:
    """One code; every row is its own.

    Attributes:
        letter, number: the code, number in tenths: G43.4 is ("G", 434).
        group, order: see there.
        words: letters it uses.
        sentence: what it does.
        action: None when it changes nothing the check looks at.
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
    action: Action | None = None
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


_G, _O = Group, Order
_FANUC_HAAS = "fanuc haas"
_ARC_WORDS = AXIS_WORDS + "IJKRP"
_CYCLE_WORDS = AXIS_WORDS + "RQPLK"


def _refused(
    letter: str, number: int, group: Group, sentence: str, reason: str, dialects: str = ""
) -> Row:
    return Row(letter, number, group, Order.OTHER, "", sentence, refused=reason, dialects=dialects)


WORDS: dict[str, Row] = {
    "F": Row("F", 0, _G.NONE, _O.FEED, "", "Feed", settings.set_feed),
    "S": Row("S", 0, _G.NONE, _O.SPEED, "", "Spindle speed", settings.set_speed),
    "T": Row("T", 0, _G.NONE, _O.TOOL, "", "Select a tool", offsets.select_tool),
}
"""Words that act by themselves."""

# fmt: off
TABLE: tuple[Row, ...] = (
    # Motion.
    Row("G", 0, _G.MOTION, _O.MOTION, AXIS_WORDS, "Rapid move", moves.straight),
    Row("G", 10, _G.MOTION, _O.MOTION, AXIS_WORDS, "Straight feed move", moves.straight),
    Row("G", 20, _G.MOTION, _O.MOTION, _ARC_WORDS, "Arc, clockwise", moves.arc),
    Row("G", 30, _G.MOTION, _O.MOTION, _ARC_WORDS, "Arc, counter-clockwise", moves.arc),
    Row("G", 530, _G.ONE_SHOT, _O.DISTANCE, "", "Machine coordinates in this block"),
    Row("G", 280, _G.ONE_SHOT, _O.ONE_SHOT, AXIS_WORDS, "Return to the reference point",
        moves.return_to_reference),
    Row("G", 300, _G.ONE_SHOT, _O.ONE_SHOT, AXIS_WORDS + "P", "Return to the second point",
        moves.return_to_reference),
    *(Row("G", number, _G.ONE_SHOT, _O.ONE_SHOT, "", "Store the reference point",
          moves.store_reference, dialects="linuxcnc") for number in (281, 301)),
    Row("G", 40, _G.ONE_SHOT, _O.DWELL, "PXU", "Dwell", settings.dwell, dialects=_FANUC_HAAS),
    Row("G", 40, _G.ONE_SHOT, _O.DWELL, "P", "Dwell", settings.dwell, dialects="linuxcnc"),
    # Plane, unit, distance, feed mode.
    Row("G", 170, _G.PLANE, _O.PLANE, "", "Plane XY", settings.set_plane),
    Row("G", 180, _G.PLANE, _O.PLANE, "", "Plane ZX", settings.set_plane),
    Row("G", 190, _G.PLANE, _O.PLANE, "", "Plane YZ", settings.set_plane),
    Row("G", 200, _G.UNIT, _O.UNIT, "", "Lengths in inches", settings.set_unit),
    Row("G", 210, _G.UNIT, _O.UNIT, "", "Lengths in millimetres", settings.set_unit),
    Row("G", 900, _G.DISTANCE, _O.DISTANCE, "", "Absolute words", settings.set_distance),
    Row("G", 910, _G.DISTANCE, _O.DISTANCE, "", "Incremental words", settings.set_distance),
    Row("G", 901, _G.CENTRE_DISTANCE, _O.DISTANCE, "", "Absolute arc centres",
        settings.set_centre_distance),
    Row("G", 911, _G.CENTRE_DISTANCE, _O.DISTANCE, "", "Incremental arc centres",
        settings.set_centre_distance),
    Row("G", 930, _G.FEED_MODE, _O.FEED_MODE, "", "Inverse time feed", settings.set_feed_mode),
    Row("G", 940, _G.FEED_MODE, _O.FEED_MODE, "", "Feed per minute", settings.set_feed_mode),
    Row("G", 950, _G.FEED_MODE, _O.FEED_MODE, "", "Feed per revolution", settings.set_feed_mode),
    # Path control and cycle return.
    Row("G", 610, _G.PATH, _O.PATH, "", "Exact path", settings.set_path),
    Row("G", 611, _G.PATH, _O.PATH, "", "Exact stop", settings.set_path),
    Row("G", 640, _G.PATH, _O.PATH, "PQ", "Continuous path", settings.set_path),
    Row("G", 980, _G.CYCLE_RETURN, _O.CYCLE_RETURN, "", "Cycles return to the initial level",
        settings.set_cycle_return),
    Row("G", 990, _G.CYCLE_RETURN, _O.CYCLE_RETURN, "", "Cycles return to the R level",
        settings.set_cycle_return),
    # Radius and length compensation.
    Row("G", 400, _G.COMPENSATION, _O.COMPENSATION, "", "Radius compensation off",
        settings.cancel_compensation),
    Row("G", 410, _G.COMPENSATION, _O.COMPENSATION, "D", "Radius left", settings.compensate),
    Row("G", 420, _G.COMPENSATION, _O.COMPENSATION, "D", "Radius right", settings.compensate),
    Row("G", 411, _G.COMPENSATION, _O.COMPENSATION, "DL", "Radius left", settings.compensate),
    Row("G", 421, _G.COMPENSATION, _O.COMPENSATION, "DL", "Radius right", settings.compensate),
    Row("G", 430, _G.LENGTH, _O.LENGTH, "H", "Tool length", offsets.set_tool_length),
    Row("G", 431, _G.LENGTH, _O.LENGTH, AXIS_WORDS, "Tool offset in words",
        offsets.set_tool_length_words),
    Row("G", 432, _G.LENGTH, _O.LENGTH, "H", "Further tool length", offsets.set_tool_length),
    Row("G", 440, _G.LENGTH, _O.LENGTH, "H", "Tool length, negative", offsets.set_tool_length),
    Row("G", 490, _G.LENGTH, _O.LENGTH, "", "Tool length off",
        five_axis.cancel_tool_centre_point),
    Row("G", 434, _G.LENGTH, _O.LENGTH, "H", "Tool centre point, rotary words",
        five_axis.set_tool_centre_point),
    Row("G", 435, _G.LENGTH, _O.LENGTH, "H", "Tool centre point, vectors",
        five_axis.set_tool_centre_point),
    Row("G", 2340, _G.LENGTH, _O.LENGTH, "H", "Tool centre point of Haas",
        five_axis.set_tool_centre_point, dialects="haas"),
    # Work offsets.
    *(Row("G", number, _G.WORK_OFFSET, _O.WORK_OFFSET, "", f"Work offset {index}",
          offsets.set_work_offset)
      for index, number in enumerate((540, 550, 560, 570, 580, 590, 591, 592, 593), start=1)),
    Row("G", 541, _G.WORK_OFFSET, _O.WORK_OFFSET, "P", "Additional work offset",
        offsets.set_additional_offset),
    Row("G", 1540, _G.WORK_OFFSET, _O.WORK_OFFSET, "P", "Additional work offset",
        offsets.set_additional_offset, dialects="haas"),
    Row("G", 520, _G.ONE_SHOT, _O.ONE_SHOT, AXIS_WORDS, "Local offset", offsets.set_local_offset),
    Row("G", 920, _G.ONE_SHOT, _O.ONE_SHOT, AXIS_WORDS, "Current point reads the words",
        offsets.set_g92),
    Row("G", 921, _G.ONE_SHOT, _O.ONE_SHOT, "", "Clear G92", offsets.cancel_g92),
    Row("G", 922, _G.ONE_SHOT, _O.ONE_SHOT, "", "Suspend G92", offsets.cancel_g92),
    Row("G", 923, _G.ONE_SHOT, _O.ONE_SHOT, "", "Restore G92", offsets.cancel_g92),
    Row("G", 100, _G.ONE_SHOT, _O.ONE_SHOT, AXIS_WORDS + "LPRIJQ", "Set offsets or tools",
        tables.set_table),
    # Off-switches of modes that are never on.
    Row("G", 690, _G.FRAME, _O.WORK_OFFSET, "", "Plane rotation off", offsets.rotate_plane),
    Row("G", 680, _G.FRAME, _O.WORK_OFFSET, AXIS_WORDS + "R", "Rotation of the plane",
        offsets.rotate_plane, dialects=_FANUC_HAAS),
    *(Row("G", number, _G.TABLE, _O.WORK_OFFSET, "", "Table offset of Haas, on and off",
          five_axis.set_table_offset, dialects="haas") for number in (2540, 2550)),
    Row("G", 542, _G.TABLE, _O.WORK_OFFSET, "P", "Table offset", five_axis.set_table_offset,
        dialects="fanuc"),
    Row("G", 150, _G.POLAR, _O.DISTANCE, "", "Polar words off", moves.set_polar),
    Row("G", 160, _G.POLAR, _O.DISTANCE, "", "Polar words", moves.set_polar,
        dialects=_FANUC_HAAS),
    Row("G", 501, _G.MIRROR, _O.WORK_OFFSET, "", "Mirror off", offsets.mirror,
        dialects="linuxcnc"),
    Row("G", 501, _G.MIRROR, _O.WORK_OFFSET, AXIS_WORDS, "Mirror off", offsets.mirror,
        dialects=_FANUC_HAAS, optional=True),
    Row("G", 511, _G.MIRROR, _O.WORK_OFFSET, AXIS_WORDS, "Mirror", offsets.mirror,
        dialects=_FANUC_HAAS),
    *(Row("G", number, _G.FRAME, _O.WORK_OFFSET, AXIS_WORDS + "IJKPQR", sentence,
          five_axis.set_tilted_plane, dialects="fanuc")
      for number, sentence in ((682, "Tilted plane"), (684, "Further tilted plane"))),
    Row("G", 683, _G.FRAME, _O.WORK_OFFSET, AXIS_WORDS + "R", "Tilted plane from the tool axis",
        five_axis.set_tilted_plane, dialects="fanuc"),
    Row("G", 2680, _G.FRAME, _O.WORK_OFFSET, AXIS_WORDS + "IJKQ", "Tilted plane of Haas",
        five_axis.set_tilted_plane, dialects="haas"),
    Row("G", 2690, _G.FRAME, _O.WORK_OFFSET, "", "Tilted plane of Haas off",
        offsets.rotate_plane, dialects="haas"),
    Row("G", 531, _G.ONE_SHOT, _O.ONE_SHOT, "P", "Tool axis normal to the plane",
        five_axis.align_tool, dialects="fanuc"),
    # Cycles, probing, calls.
    Row("G", 800, _G.CYCLE, _O.CYCLE_RETURN, "", "End of the cycle", cycles.end_cycle),
    *(Row("G", number * 10, _G.CYCLE, _O.MOTION, _CYCLE_WORDS, "Canned cycle", cycles.run_cycle)
      for number in (73, 74, 81, 82, 83, 84, 85, 86, 88, 89)),
    Row("G", 760, _G.CYCLE, _O.MOTION, _CYCLE_WORDS, "Fine boring", cycles.run_cycle,
        dialects=_FANUC_HAAS),
    _refused("G", 760, _G.CYCLE, "Threading", "threading is for lathes", "linuxcnc"),
    Row("G", 870, _G.CYCLE, _O.MOTION, _CYCLE_WORDS + "IJ", "Back boring", cycles.run_cycle),
    Row("G", 310, _G.MOTION, _O.MOTION, AXIS_WORDS + "P", "Skip move", moves.probe,
        dialects=_FANUC_HAAS),
    *(Row("G", number, _G.MOTION, _O.MOTION, AXIS_WORDS, "Probing move", moves.probe,
          dialects="linuxcnc") for number in (382, 383, 384, 385)),
    Row("G", 650, _G.ONE_SHOT, _O.STOP, "PL", "Macro call", calls.call_macro),
    *(_refused("G", number * 10, _G.ONE_SHOT, "Modal macro call",
               "macros called after every move are not followed") for number in (66, 67)),
    Row("M", 970, _G.CALL, _O.STOP, "PL", "Call of a block", calls.call_block, dialects="haas"),
    Row("M", 980, _G.CALL, _O.STOP, "PL", "Subprogram", calls.call_program),
    Row("M", 990, _G.CALL, _O.STOP, "P", "Return", calls.return_from_call),
    Row("M", 4280, _G.TCP, _O.LENGTH, "", "Tool centre point", five_axis.set_tool_centre_point,
        dialects="linuxcnc"),
    Row("M", 4290, _G.TCP, _O.LENGTH, "", "Tool centre point off",
        five_axis.cancel_tool_centre_point, dialects="linuxcnc"),
    # Accepted without an effect on the path.
    Row("G", 50, _G.NONE, _O.OTHER, "P", "High-speed machining", dialects=_FANUC_HAAS),
    Row("G", 51, _G.NONE, _O.OTHER, "QR", "Look-ahead", dialects=_FANUC_HAAS),
    Row("G", 80, _G.NONE, _O.OTHER, "P", "Look-ahead", dialects=_FANUC_HAAS),
    Row("G", 1870, _G.NONE, _O.OTHER, "PE", "Smoothness", dialects=_FANUC_HAAS),
    # Spindle speed.
    Row("G", 960, _G.SPEED, _O.FEED_MODE, "D", "Surface speed", settings.set_surface_speed),
    Row("G", 970, _G.SPEED, _O.FEED_MODE, "", "Speed in rev/min", settings.set_surface_speed),
    # M codes.
    *(Row("M", number * 10, _G.STOP, _O.STOP, "", sentence, settings.stop)
      for number, sentence in ((0, "Stop"), (1, "Optional stop"), (2, "End"), (30, "End"))),
    Row("M", 60, _G.CHANGE, _O.CHANGE, "", "Tool change", offsets.change_tool),
    Row("M", 610, _G.CHANGE, _O.CHANGE, "Q", "Tool in the spindle", offsets.declare_tool),
    Row("M", 30, _G.SPINDLE, _O.SPINDLE, "", "Spindle clockwise", settings.set_spindle),
    Row("M", 40, _G.SPINDLE, _O.SPINDLE, "", "Spindle counter-clockwise", settings.set_spindle),
    Row("M", 50, _G.SPINDLE, _O.SPINDLE, "", "Spindle off", settings.set_spindle),
    Row("M", 190, _G.SPINDLE, _O.SPINDLE, "RQP", "Orient the spindle", settings.set_spindle),
    *(Row("M", number * 10, _G.COOLANT, _O.COOLANT, "", "Coolant") for number in (7, 8, 9)),
    *(Row("M", number * 10, _G.OVERRIDE, _O.OTHER, "", "Overrides") for number in (48, 49)),
    *(Row("M", number * 10, _G.NONE, _O.OTHER, "P", "Clamp") for number in (10, 11, 12, 13)),
    Row("M", 290, _G.NONE, _O.OTHER, "", "Rigid tapping", settings.set_rigid_tapping),
    *(Row("M", number * 10, _G.NONE, _O.OTHER, "PQE", "Output")
      for number in (62, 63, 64, 65, 67, 68)),
)
# fmt: on


def codes_of(readings: Readings) -> dict[tuple[str, int], Row]:
    """Return the rows a dialect has, by letter and number in tenths."""
    return {
        (row.letter, row.number): row
        for row in TABLE
        if not row.dialects or readings.dialect in row.dialects.split()
    }


def codes_for(control: Control) -> dict[tuple[str, int], Row]:
    """Return the rows of the control's dialect and the codes its machine file lists.

    A listed code replaces a refused one, never one that gcodesim follows.
    """
    rows = codes_of(control.readings)
    for letter, listed, action in (
        ("G", control.readings.g_codes, settings.listed_g),
        ("M", control.readings.m_codes, settings.listed_m),
    ):
        for code in listed:
            key = (letter, round(code * 10))
            if key not in rows or rows[key].refused:
                sentence = "Listed in the machine file"
                rows[key] = Row(*key, Group.NONE, Order.OTHER, LEFT_OVER, sentence, action)
    return rows


def unknown_m(number: int) -> Row:
    """Return the row of an M code that no table lists."""
    return Row("M", number, Group.NONE, Order.OTHER, LEFT_OVER, "Unknown", settings.unknown_m)

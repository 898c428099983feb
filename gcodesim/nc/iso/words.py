"""The one table of codes: group checks, word checks, order and supported list follow from it."""

from __future__ import annotations

from collections.abc import Mapping

from gcodesim.nc.control.readings import Effect
from gcodesim.nc.iso.code_rows import AXIS_WORDS, Group, Order, Row
from gcodesim.nc.iso.own_codes import OWN_CODES, refused

LEFT_OVER = "PQREL"
"""Words that a code takes whose meaning is not ours."""

_G, _O = Group, Order
_FANUC_HAAS, _LINUXCNC_GRBL = "fanuc haas", "linuxcnc grbl"
_ARC_WORDS = AXIS_WORDS + "IJKRP"
_CYCLE_WORDS = AXIS_WORDS + "RQPLK"


WORDS: dict[str, Row] = {
    "F": Row("F", 0, _G.NONE, _O.FEED, "", "Feed", "set_feed"),
    "S": Row("S", 0, _G.NONE, _O.SPEED, "", "Spindle speed", "set_speed"),
    "T": Row("T", 0, _G.NONE, _O.TOOL, "", "Select a tool", "select_tool"),
}
"""Words that act by themselves."""

OFFSET_WORDS: dict[str, Row] = {
    "H": Row("H", 0, _G.NONE, _O.LENGTH, "H", "Row of the tool length", "change_length_entry"),
    "D": Row("D", 0, _G.NONE, _O.OTHER, "D", "Row of the tool radius"),
}
"""Words that act where no code of their block takes them, on some controls."""

# fmt: off
TABLE: tuple[Row, ...] = (
    # Motion.
    Row("G", 0, _G.MOTION, _O.MOTION, AXIS_WORDS, "Rapid move", "straight"),
    Row("G", 10, _G.MOTION, _O.MOTION, AXIS_WORDS, "Straight feed move", "straight"),
    Row("G", 20, _G.MOTION, _O.MOTION, _ARC_WORDS, "Arc, clockwise", "arc"),
    Row("G", 30, _G.MOTION, _O.MOTION, _ARC_WORDS, "Arc, counter-clockwise", "arc"),
    *(Row("G", number, _G.MOTION, _O.MOTION, AXIS_WORDS + "K", sentence, "move_in_step",
          dialects="linuxcnc")
      for number, sentence in ((330, "Feed in step with the spindle"), (331, "Rigid tapping"))),
    Row("G", 530, _G.ONE_SHOT, _O.DISTANCE, "", "Machine coordinates in this block"),
    Row("G", 280, _G.ONE_SHOT, _O.ONE_SHOT, AXIS_WORDS, "Return to the reference point",
        "return_to_reference"),
    Row("G", 300, _G.ONE_SHOT, _O.ONE_SHOT, AXIS_WORDS + "P", "Return to the second point",
        "return_to_reference"),
    *(Row("G", number, _G.ONE_SHOT, _O.ONE_SHOT, "", "Store the reference point",
          "store_reference", dialects=_LINUXCNC_GRBL) for number in (281, 301)),
    Row("G", 40, _G.ONE_SHOT, _O.DWELL, "PXU", "Dwell", "dwell", dialects=_FANUC_HAAS),
    Row("G", 40, _G.ONE_SHOT, _O.DWELL, "P", "Dwell", "dwell", dialects=_LINUXCNC_GRBL),
    # Plane, unit, distance, feed mode.
    Row("G", 170, _G.PLANE, _O.PLANE, "", "Plane XY", "set_plane"),
    Row("G", 180, _G.PLANE, _O.PLANE, "", "Plane ZX", "set_plane"),
    Row("G", 190, _G.PLANE, _O.PLANE, "", "Plane YZ", "set_plane"),
    Row("G", 200, _G.UNIT, _O.UNIT, "", "Lengths in inches", "set_unit"),
    Row("G", 210, _G.UNIT, _O.UNIT, "", "Lengths in millimetres", "set_unit"),
    Row("G", 900, _G.DISTANCE, _O.DISTANCE, "", "Absolute words", "set_distance"),
    Row("G", 910, _G.DISTANCE, _O.DISTANCE, "", "Incremental words", "set_distance"),
    Row("G", 901, _G.CENTRE_DISTANCE, _O.DISTANCE, "", "Absolute arc centres",
        "set_centre_distance"),
    Row("G", 911, _G.CENTRE_DISTANCE, _O.DISTANCE, "", "Incremental arc centres",
        "set_centre_distance"),
    Row("G", 930, _G.FEED_MODE, _O.FEED_MODE, "", "Inverse time feed", "set_feed_mode"),
    Row("G", 940, _G.FEED_MODE, _O.FEED_MODE, "", "Feed per minute", "set_feed_mode"),
    Row("G", 950, _G.FEED_MODE, _O.FEED_MODE, "", "Feed per revolution", "set_feed_mode"),
    # Path control and cycle return.
    Row("G", 610, _G.PATH, _O.PATH, "", "Exact path", "set_path"),
    Row("G", 611, _G.PATH, _O.PATH, "", "Exact stop", "set_path"),
    Row("G", 640, _G.PATH, _O.PATH, "PQ", "Continuous path", "set_path"),
    Row("G", 980, _G.CYCLE_RETURN, _O.CYCLE_RETURN, "", "Cycles return to the initial level",
        "set_cycle_return"),
    Row("G", 990, _G.CYCLE_RETURN, _O.CYCLE_RETURN, "", "Cycles return to the R level",
        "set_cycle_return"),
    # Radius and length compensation.
    Row("G", 400, _G.COMPENSATION, _O.COMPENSATION, "", "Radius compensation off",
        "compensate"),
    Row("G", 410, _G.COMPENSATION, _O.COMPENSATION, "D", "Radius left", "compensate"),
    Row("G", 420, _G.COMPENSATION, _O.COMPENSATION, "D", "Radius right", "compensate"),
    Row("G", 411, _G.COMPENSATION, _O.COMPENSATION, "DL", "Radius left", "compensate"),
    Row("G", 421, _G.COMPENSATION, _O.COMPENSATION, "DL", "Radius right", "compensate"),
    Row("G", 430, _G.LENGTH, _O.LENGTH, "H", "Tool length", "set_tool_length"),
    Row("G", 431, _G.LENGTH, _O.LENGTH, AXIS_WORDS, "Tool offset in words",
        "set_tool_length_words", dialects=_LINUXCNC_GRBL),
    Row("G", 432, _G.LENGTH, _O.LENGTH, "H", "Further tool length", "set_tool_length",
        dialects="linuxcnc"),
    Row("G", 440, _G.LENGTH, _O.LENGTH, "H", "Tool length, negative", "set_tool_length"),
    Row("G", 490, _G.LENGTH, _O.LENGTH, "", "Tool length off",
        "cancel_tool_centre_point"),
    Row("G", 434, _G.LENGTH, _O.LENGTH, "H", "Tool centre point, rotary words",
        "set_tool_centre_point"),
    Row("G", 435, _G.LENGTH, _O.LENGTH, "H", "Tool centre point, vectors",
        "set_tool_centre_point"),
    Row("G", 2340, _G.LENGTH, _O.LENGTH, "H", "Tool centre point of Haas",
        "set_tool_centre_point", dialects="haas"),
    # Work offsets.
    *(Row("G", number, _G.WORK_OFFSET, _O.WORK_OFFSET, "", f"Work offset {index}",
          "set_work_offset", dialects="haas linuxcnc grbl")
      for index, number in enumerate((540, 550, 560, 570, 580, 590, 591, 592, 593), start=1)),
    *(Row("G", number, _G.WORK_OFFSET, _O.WORK_OFFSET, "P", "Work offset", "set_work_offset",
          dialects="fanuc")
      for number in (540, 550, 560, 570, 580, 590, 591, 592, 593)),
    Row("G", 541, _G.WORK_OFFSET, _O.WORK_OFFSET, "P", "Additional work offset",
        "set_additional_offset"),
    Row("G", 1540, _G.WORK_OFFSET, _O.WORK_OFFSET, "P", "Additional work offset",
        "set_additional_offset", dialects="haas"),
    Row("G", 520, _G.ONE_SHOT, _O.ONE_SHOT, AXIS_WORDS, "Local offset", "set_local_offset"),
    Row("G", 920, _G.ONE_SHOT, _O.ONE_SHOT, AXIS_WORDS, "Current point reads the words",
        "set_g92"),
    Row("G", 921, _G.ONE_SHOT, _O.ONE_SHOT, "", "Clear G92", "cancel_g92",
        dialects=_LINUXCNC_GRBL),
    *(Row("G", number, _G.ONE_SHOT, _O.ONE_SHOT, "", sentence, "cancel_g92",
          dialects="linuxcnc")
      for number, sentence in ((922, "Suspend G92"), (923, "Restore G92"))),
    Row("G", 921, _G.ONE_SHOT, _O.ONE_SHOT, AXIS_WORDS, "Work offset as it is stored",
        "preset", dialects="fanuc"),
    Row("G", 100, _G.ONE_SHOT, _O.ONE_SHOT, AXIS_WORDS + "LPRIJQ", "Set offsets or tools",
        "set_table"),
    # Off-switches of modes that are never on.
    Row("G", 690, _G.FRAME, _O.WORK_OFFSET, "", "Plane rotation off", "rotate_plane"),
    Row("G", 680, _G.FRAME, _O.WORK_OFFSET, AXIS_WORDS + "R", "Rotation of the plane",
        "rotate_plane", dialects=_FANUC_HAAS),
    *(Row("G", number, _G.TABLE, _O.WORK_OFFSET, "", "Table offset of Haas, on and off",
          "set_table_offset", dialects="haas") for number in (2540, 2550)),
    Row("G", 542, _G.TABLE, _O.WORK_OFFSET, "P", "Table offset", "set_table_offset",
        dialects="fanuc"),
    Row("G", 150, _G.POLAR, _O.DISTANCE, "", "Polar words off", "set_polar"),
    Row("G", 160, _G.POLAR, _O.DISTANCE, "", "Polar words", "set_polar",
        dialects=_FANUC_HAAS),
    Row("G", 501, _G.MIRROR, _O.WORK_OFFSET, "", "Mirror off", "mirror",
        dialects="linuxcnc"),
    Row("G", 501, _G.MIRROR, _O.WORK_OFFSET, AXIS_WORDS, "Mirror off", "mirror",
        dialects=_FANUC_HAAS, optional=True),
    Row("G", 511, _G.MIRROR, _O.WORK_OFFSET, AXIS_WORDS, "Mirror", "mirror",
        dialects=_FANUC_HAAS),
    *(Row("G", number, _G.FRAME, _O.WORK_OFFSET, AXIS_WORDS + "IJKPQR", sentence,
          "set_tilted_plane", dialects="fanuc")
      for number, sentence in ((682, "Tilted plane"), (684, "Further tilted plane"))),
    Row("G", 683, _G.FRAME, _O.WORK_OFFSET, AXIS_WORDS + "R", "Tilted plane from the tool axis",
        "set_tilted_plane", dialects="fanuc"),
    Row("G", 2680, _G.FRAME, _O.WORK_OFFSET, AXIS_WORDS + "IJKQ", "Tilted plane of Haas",
        "set_tilted_plane", dialects="haas"),
    Row("G", 2690, _G.FRAME, _O.WORK_OFFSET, "", "Tilted plane of Haas off",
        "rotate_plane", dialects="haas"),
    Row("G", 531, _G.ONE_SHOT, _O.ONE_SHOT, "P", "Tool axis normal to the plane",
        "align_tool", dialects="fanuc"),
    # Cycles, probing, calls.
    Row("G", 800, _G.CYCLE, _O.CYCLE_RETURN, "", "End of the cycle", "end_cycle"),
    *(Row("G", number * 10, _G.CYCLE, _O.MOTION, _CYCLE_WORDS, "Canned cycle", "run_cycle",
          dialects="fanuc linuxcnc")
      for number in (73, 74, 81, 82, 83, 84, 85, 86, 88, 89)),
    *(Row("G", number * 10, _G.CYCLE, _O.MOTION, _CYCLE_WORDS + "IJ", "Canned cycle",
          "run_cycle", dialects="haas")
      for number in (73, 74, 76, 81, 82, 83, 84, 85, 86, 88, 89)),
    Row("G", 760, _G.CYCLE, _O.MOTION, _CYCLE_WORDS + "IJ", "Fine boring", "run_cycle",
        dialects="fanuc"),
    refused(760, "Threading", "threading is for lathes", "linuxcnc", _G.CYCLE),
    Row("G", 870, _G.CYCLE, _O.MOTION, _CYCLE_WORDS + "IJ", "Back boring", "run_cycle",
        dialects="fanuc linuxcnc"),
    Row("G", 310, _G.MOTION, _O.MOTION, AXIS_WORDS + "P", "Skip move", "probe",
        dialects=_FANUC_HAAS),
    *(Row("G", number, _G.MOTION, _O.MOTION, AXIS_WORDS, "Probing move", "probe",
          dialects=_LINUXCNC_GRBL) for number in (382, 383, 384, 385)),
    Row("G", 650, _G.ONE_SHOT, _O.STOP, "PL", "Macro call", "call_macro"),
    refused(660, "Modal macro call", "macros called after every move are not followed"),
    Row("M", 970, _G.CALL, _O.STOP, "PL", "Call of a block", "call_block", dialects="haas"),
    Row("M", 980, _G.CALL, _O.STOP, "PL", "Subprogram", "call_program"),
    Row("M", 990, _G.CALL, _O.STOP, "P", "Return", "return_from_call"),
    Row("M", 4280, _G.TCP, _O.LENGTH, "", "Tool centre point", "set_tool_centre_point",
        dialects="linuxcnc"),
    Row("M", 4290, _G.TCP, _O.LENGTH, "", "Tool centre point off",
        "cancel_tool_centre_point", dialects="linuxcnc"),
    # Accepted without an effect on the path.
    Row("G", 50, _G.NONE, _O.OTHER, "P", "High-speed machining", dialects=_FANUC_HAAS),
    Row("G", 80, _G.NONE, _O.OTHER, "P", "Look-ahead", dialects=_FANUC_HAAS),
    Row("G", 1870, _G.NONE, _O.OTHER, "PE", "Smoothness", dialects=_FANUC_HAAS),
    # Spindle speed.
    Row("G", 960, _G.SPEED, _O.FEED_MODE, "D", "Surface speed", "set_surface_speed"),
    Row("G", 970, _G.SPEED, _O.FEED_MODE, "", "Speed in rev/min", "set_surface_speed"),
    # M codes.
    *(Row("M", number * 10, _G.STOP, _O.STOP, "", sentence, "stop")
      for number, sentence in ((0, "Stop"), (1, "Optional stop"), (2, "End"), (30, "End"))),
    Row("M", 60, _G.CHANGE, _O.CHANGE, "", "Tool change", "change_tool"),
    Row("M", 160, _G.CHANGE, _O.CHANGE, "", "Tool change", "change_tool", dialects="haas"),
    Row("M", 610, _G.CHANGE, _O.CHANGE, "Q", "Tool in the spindle", "declare_tool",
        dialects="linuxcnc"),
    Row("M", 30, _G.SPINDLE, _O.SPINDLE, "", "Spindle clockwise", "set_spindle"),
    Row("M", 40, _G.SPINDLE, _O.SPINDLE, "", "Spindle counter-clockwise", "set_spindle"),
    Row("M", 50, _G.SPINDLE, _O.SPINDLE, "", "Spindle off", "set_spindle"),
    Row("M", 190, _G.SPINDLE, _O.SPINDLE, "RQP", "Orient the spindle", "set_spindle"),
    *(Row("M", number * 10, _G.COOLANT, _O.COOLANT, "", "Coolant") for number in (7, 8, 9)),
    *(Row("M", number * 10, _G.OVERRIDE, _O.OTHER, "", "Overrides") for number in (48, 49)),
    *(Row("M", number, _G.CALL, _O.OTHER, "", "Save the modes", "save_modes",
          dialects="linuxcnc") for number in (700, 730)),
    Row("M", 710, _G.CALL, _O.OTHER, "", "Forget the saved modes", "forget_modes",
        dialects="linuxcnc"),
    Row("M", 720, _G.CALL, _O.OTHER, "", "Restore the saved modes", "restore_modes",
        dialects="linuxcnc"),
    *(Row("M", number * 10, _G.NONE, _O.OTHER, "P", "Clamp") for number in (10, 11, 12, 13)),
    Row("M", 290, _G.NONE, _O.OTHER, "", "Rigid tapping", "set_rigid_tapping"),
    *(Row("M", number * 10, _G.NONE, _O.OTHER, "PQE", "Output")
      for number in (62, 63, 64, 65, 67, 68)),
    *OWN_CODES,
)
# fmt: on


_G_OF_GRBL = (
    *(0, 1, 2, 3, 4, 10, 17, 18, 19, 20, 21, 28, 28.1, 30, 30.1, 38.2, 38.3, 38.4, 38.5, 40),
    *(43.1, 49, 53, 54, 55, 56, 57, 58, 59, 61, 80, 90, 91, 91.1, 92, 92.1, 93, 94),
)
_M_OF_GRBL = (0, 1, 2, 3, 4, 5, 7, 8, 9, 30)

ONLY: dict[str, frozenset[str]] = {
    "grbl": frozenset([f"G{g:g}" for g in _G_OF_GRBL] + [f"M{m}" for m in _M_OF_GRBL])
}
"""Dialect -> all codes it has, where these are few."""


def codes_of(dialect: str) -> dict[tuple[str, int], Row]:
    """Return the rows a dialect has, by letter and number in tenths."""
    only = ONLY.get(dialect)
    return {
        (row.letter, row.number): row
        for row in TABLE
        if (not row.dialects or dialect in row.dialects.split())
        and (only is None or row.name in only)
    }


def codes_for(
    dialect: str, g_codes: Mapping[float, Effect], m_codes: Mapping[float, Effect]
) -> dict[tuple[str, int], Row]:
    """Return the rows of a dialect, and of the codes that a machine file lists.

    A listed code replaces a refused one, and a clamp another that does nothing, but never one that
    gcodesim follows.
    """
    rows = codes_of(dialect)
    for letter, listed, action in (("G", g_codes, "listed_g"), ("M", m_codes, "listed_m")):
        for code, effect in listed.items():
            key = (letter, round(code * 10))
            clamps = effect in ("clamp", "unclamp") and key in rows and not rows[key].action
            if key not in rows or rows[key].refused or clamps:
                sentence = "Listed in the machine file"
                rows[key] = Row(*key, Group.NONE, Order.OTHER, LEFT_OVER, sentence, action)
    return rows


def unlisted_m(number: int) -> Row:
    """Return the row of an M code that no table lists."""
    return Row("M", number, Group.NONE, Order.OTHER, LEFT_OVER, "Unknown", "unknown_m")

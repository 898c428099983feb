"""Named parameters that LinuxCNC itself keeps: what is known of them, and which are not."""

from __future__ import annotations

import re
from collections.abc import Callable

from gcodesim.nc.control.modal import TURNING, Motion, Spindle
from gcodesim.nc.control.state import INCH
from gcodesim.nc.iso.g_codes import G, motion_code
from gcodesim.nc.iso.memory import IsoState
from gcodesim.nc.program import FeedMode

Known = Callable[[IsoState], float | None]
"""Returns None where the value is not known."""


def _axis(i: int) -> Known:
    return lambda s: s.point[i] / (s.scale if i < 3 else 1.0)


def _machine_axis(i: int) -> Known:
    inch = INCH if i < 3 else 1.0
    return lambda s: s.axes[i] / (inch if s.control.readings.program_unit == "inch" else 1.0)


def _feed_mode(mode: FeedMode) -> Known:
    return lambda s: float(s.modal.feed_mode is mode)


def _motion_mode(state: IsoState) -> float:
    if state.codes.cycle:
        return float(state.codes.cycle)
    motion = state.modal.motion
    return float(G.CYCLE_OFF if motion is Motion.NONE else motion_code(motion))


def _selected(state: IsoState) -> float | None:
    return None if state.modal.selected is None else float(state.modal.selected)


PREDEFINED: dict[str, Known] = {
    **{f"_{letter}": _axis(i) for i, letter in enumerate("XYZABC")},
    **{f"_ABS_{letter}": _machine_axis(i) for i, letter in enumerate("XYZABC")},
    **dict.fromkeys(("_U", "_V", "_W", "_VALUE", "_VALUE_RETURNED"), lambda _: 0.0),
    "_LINE": lambda s: float(s.place.line),
    "_MOTION_MODE": _motion_mode,
    "_PLANE": lambda s: 170.0 + 10.0 * s.modal.plane,
    "_CCOMP": lambda s: float(s.codes.compensation),
    "_METRIC": lambda s: float(not s.modal.inch),
    "_IMPERIAL": lambda s: float(s.modal.inch),
    "_ABSOLUTE": lambda s: float(not s.modal.incremental),
    "_INCREMENTAL": lambda s: float(s.modal.incremental),
    "_INVERSE_TIME": _feed_mode(FeedMode.INVERSE_TIME),
    "_UNITS_PER_MINUTE": _feed_mode(FeedMode.PER_MINUTE),
    "_UNITS_PER_REV": _feed_mode(FeedMode.PER_REVOLUTION),
    "_COORD_SYSTEM": lambda s: float(s.codes.work_offset),
    "_TOOL_OFFSET": lambda s: float(any(s.frames.tool)),
    "_RETRACT_R_PLANE": lambda s: float(s.codes.cycle_return == G.RETURN_TO_R),
    "_RETRACT_OLD_Z": lambda s: float(s.codes.cycle_return == G.RETURN_TO_START),
    "_SPINDLE_RPM_MODE": lambda s: float(not s.modal.surface_speed),
    "_SPINDLE_CSS_MODE": lambda s: float(s.modal.surface_speed),
    "_IJK_ABSOLUTE_MODE": lambda s: float(s.modal.centre_absolute),
    "_LATHE_DIAMETER_MODE": lambda _: 0.0,
    "_LATHE_RADIUS_MODE": lambda _: 1.0,
    "_SPINDLE_ON": lambda s: float(s.modal.spindle in TURNING),
    "_SPINDLE_CW": lambda s: float(s.modal.spindle is Spindle.CLOCKWISE),
    "_FEED": lambda s: s.modal.feed or 0.0,
    "_RPM": lambda s: s.modal.speed,
    "_CURRENT_TOOL": lambda s: float(s.modal.tool or 0),
    "_SELECTED_TOOL": _selected,
}
"""Name in capitals -> its value."""

OUTSIDE = re.compile(
    r"_(?:HAL|INI)\[[^\]]*\].*|_(?:VMAJOR|VMINOR|TASK|CALL_LEVEL|REMAP_LEVEL|CURRENT_POCKET"
    r"|SELECTED_POCKET|MIST|FLOOD|SPEED_OVERRIDE|FEED_OVERRIDE|ADAPTIVE_FEED|FEED_HOLD)"
)
"""Names whose values only the running control has."""

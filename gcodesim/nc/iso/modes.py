"""What codes and words do that set a mode or value and move nothing."""

from __future__ import annotations

from gcodesim.nc.control import orders
from gcodesim.nc.control.modal import TURNING, CutterSide, Spindle
from gcodesim.nc.iso.block import Block
from gcodesim.nc.iso.g_codes import G
from gcodesim.nc.iso.memory import IsoState
from gcodesim.nc.program import FeedMode, Kind, Plane, Turning

FEED_MODES = {
    G.INVERSE_TIME: FeedMode.INVERSE_TIME,
    G.PER_MINUTE: FeedMode.PER_MINUTE,
    G.PER_REVOLUTION: FeedMode.PER_REVOLUTION,
}
PLANES = {G.PLANE_XY: Plane.XY, G.PLANE_ZX: Plane.ZX, G.PLANE_YZ: Plane.YZ}
SPINDLES = {
    30: Spindle.CLOCKWISE,
    40: Spindle.COUNTER_CLOCKWISE,
    50: Spindle.OFF,
    190: Spindle.ORIENTED,
}
"""M code in tenths -> what the spindle does."""

SIDES = {
    **dict.fromkeys((G.LEFT, G.LEFT_BY), CutterSide.LEFT),
    **dict.fromkeys((G.RIGHT, G.RIGHT_BY), CutterSide.RIGHT),
}


def set_feed_mode(state: IsoState, block: Block, number: int) -> None:
    """G93 G94 G95: a change clears F, for the number would mean something else."""
    mode, modal = FEED_MODES[number], state.modal
    if modal.feed_mode != mode or state.control.readings.feed_forgotten == "always":
        modal.feed = None
    modal.feed_mode = mode


def set_feed(state: IsoState, block: Block, number: int) -> None:
    """F."""
    feed = block.values["F"]
    if feed < 0:
        raise block.error("feed_negative", f"F{feed:g}", "F")
    modal = state.modal
    modal.feed, modal.feed_scale, modal.feed_given = feed, state.scale, True
    state.line_feed = feed


def set_speed(state: IsoState, block: Block, number: int) -> None:
    """S; under G96 it is a surface speed, and says nothing about revolutions."""
    speed = block.not_negative("S")
    if not state.modal.surface_speed:
        state.modal.speed = speed


def set_surface_speed(state: IsoState, block: Block, number: int) -> None:
    """G96: the speed is only known to stay below D; G97: S is in rev/min again."""
    state.modal.surface_speed = number == G.SURFACE_SPEED
    if state.modal.surface_speed:
        state.modal.speed = block.not_negative("D") if "D" in block.values else 0.0


def set_spindle(state: IsoState, block: Block, number: int) -> None:
    """M3 M4 M5 M19."""
    spindle = SPINDLES[number]
    if spindle in TURNING and spindle is not state.modal.spindle:
        orders.dwell(state, state.control.readings.spindle_seconds)
    state.turn_spindle(spindle)


def set_rigid_tapping(state: IsoState, block: Block, number: int) -> None:
    """M29: the next tapping cycle turns the spindle itself."""
    state.codes.rigid_tapping = True


def set_plane(state: IsoState, block: Block, number: int) -> None:
    """G17 G18 G19."""
    state.modal.plane = PLANES[number]


def set_unit(state: IsoState, block: Block, number: int) -> None:
    """G20 G21; the position is kept in mm, so there is nothing to convert."""
    state.modal.inch, state.is_unit_told = number == G.INCH, True


def set_distance(state: IsoState, block: Block, number: int) -> None:
    """G90 G91."""
    state.modal.incremental = number == G.INCREMENTAL


def set_centre_distance(state: IsoState, block: Block, number: int) -> None:
    """G90.1 G91.1."""
    state.modal.centre_absolute = number == G.ABSOLUTE_CENTRES


def set_cycle_return(state: IsoState, block: Block, number: int) -> None:
    """G98 G99."""
    state.codes.cycle_return = number


def set_path(state: IsoState, block: Block, number: int) -> None:
    """G61 G61.1 G64: the exact path is checked under each of them, which G64 does not promise."""
    tolerance = block.not_negative("P") * state.scale if "P" in block.values else 0.0
    orders.set_path(state, number, tolerance)
    if number == G.CONTINUOUS_PATH and not tolerance:
        state.report("exact_path_assumed", "G64", "G64")


def dwell(state: IsoState, block: Block, number: int) -> None:
    """G4: P in the unit of the dialect, X and U in seconds, or thousandths without a point."""
    letter = next((letter for letter in "PXU" if letter in block.values), "")
    if not letter:
        raise block.error("dwell_missing", "G4 without P", "G4")
    orders.dwell(state, dwell_seconds(state, block, letter))


def dwell_seconds(state: IsoState, block: Block, letter: str) -> float:
    """Return the time a word gives: P in the unit of the dialect, others in seconds.

    Where numbers without a decimal point count increments, those of X and U are milliseconds.
    """
    seconds = block.not_negative(letter)
    return seconds / 1000.0 if _is_milliseconds(state, block, letter) else seconds


def _is_milliseconds(state: IsoState, block: Block, letter: str) -> bool:
    readings = state.control.readings
    unit = readings.dwell_p
    if letter != "P":
        unit = "point" if readings.no_point == "increment" else "s"
    if unit == "point":
        return not any(token[0] == letter and "." in str(token[1]) for token in block.tokens)
    return unit == "ms"


def stop(state: IsoState, block: Block, number: int) -> None:
    """M0 M1, and M2 M30, which end the program."""
    orders.stop(state, number // 10, ends=number in (20, 300))


def compensate(state: IsoState, block: Block, number: int) -> None:
    """G41 G42 G41.1 G42.1, and G40: accepted, reported, not applied."""
    state.codes.compensation = number
    if "D" in block.values and number in (G.LEFT, G.RIGHT):
        entry, tools = block.whole("D"), state.tools
        if tools is not None and entry and entry not in tools:
            raise block.error("tool_not_found", f"D{entry}", "D")
    orders.compensate(state, SIDES.get(number, CutterSide.NONE), f"G{number / 10:g}")


def listed_g(state: IsoState, block: Block, number: int) -> None:
    """A G code that the machine file lists."""
    _listed(state, f"G{number / 10:g}", state.control.readings.g_codes[number / 10])


def listed_m(state: IsoState, block: Block, number: int) -> None:
    """An M code that the machine file lists."""
    _listed(state, f"M{number / 10:g}", state.control.readings.m_codes[number / 10])


def _listed(state: IsoState, code: str, effect: str) -> None:
    if effect in ("clamp", "unclamp"):
        state.clamped_by = code if effect == "clamp" else ""
        return
    state.ignored[code] += 1
    if code[0] == "M":
        state.recorder.turn(Turning.MAY_TURN)
    if effect == "stop":
        state.emit(Kind.STOP)


def unknown_m(state: IsoState, block: Block, number: int) -> None:
    """An M code that nothing lists: the program runs on, the verdict is open."""
    code = f"M{number / 10:g}"
    what = f"unknown code {code} (control: {{m_codes: {{{code[1:]}: none}}}})"
    if code not in (known.split()[0] for known in state.unsupported):
        state.unsupported.append(f"{code} line {block.line}")
    state.report("unknown_m", what, code, subject=code)
    state.recorder.turn(Turning.MAY_TURN)

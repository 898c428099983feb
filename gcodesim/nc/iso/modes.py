"""What codes and words do that set a mode or value and move nothing."""

from __future__ import annotations

from gcodesim.nc.control.state import State
from gcodesim.nc.iso.block import Block
from gcodesim.nc.program import Kind


def set_feed_mode(state: State, block: Block, number: int) -> None:
    """G93 G94 G95: a change clears F, for the number would mean something else.

    Some controls forget F with every such word, also without a change.
    """
    if state.modal.feed_mode != number or state.control.readings.feed_forgotten == "always":
        state.modal.feed = None
    state.modal.feed_mode = number


def set_feed(state: State, block: Block, number: int) -> None:
    """F."""
    feed = block.values["F"]
    if feed < 0:
        raise block.error("feed_negative", f"F{feed:g}", "F")
    modal = state.modal
    modal.feed, modal.feed_scale, modal.feed_given = feed, state.scale, True


def set_speed(state: State, block: Block, number: int) -> None:
    """S; under G96 it is a surface speed, and says nothing about revolutions."""
    speed = block.not_negative("S")
    if not state.modal.surface_speed:
        state.modal.speed = speed


def set_surface_speed(state: State, block: Block, number: int) -> None:
    """G96: the speed is only known to stay below D; G97: S is in rev/min again."""
    state.modal.surface_speed = number == 960
    if number == 960:
        state.modal.speed = block.not_negative("D") if "D" in block.values else 0.0


def set_spindle(state: State, block: Block, number: int) -> None:
    """M3 M4 M5 M19."""
    state.modal.spindle = number


def set_rigid_tapping(state: State, block: Block, number: int) -> None:
    """M29: the next tapping cycle turns the spindle itself."""
    state.modal.rigid_tapping = True


def set_plane(state: State, block: Block, number: int) -> None:
    """G17 G18 G19."""
    state.modal.plane = number


def set_unit(state: State, block: Block, number: int) -> None:
    """G20 G21; the position is kept in mm, so there is nothing to convert."""
    state.modal.unit = number


def set_distance(state: State, block: Block, number: int) -> None:
    """G90 G91."""
    state.modal.distance = number


def set_centre_distance(state: State, block: Block, number: int) -> None:
    """G90.1 G91.1."""
    state.modal.centre_distance = number


def set_cycle_return(state: State, block: Block, number: int) -> None:
    """G98 G99."""
    state.modal.cycle_return = number


def set_path(state: State, block: Block, number: int) -> None:
    """G61 G61.1 G64: the exact path is checked under each of them, which G64 does not promise."""
    state.modal.path = number
    tolerance = block.not_negative("P") * state.scale if "P" in block.values else 0.0
    state.recorder.add(Kind.PATH, block.row, f=tolerance, aux=number)
    if number == 640 and not tolerance:
        state.report(block.finding("exact_path_assumed", "G64", "G64"))


def dwell(state: State, block: Block, number: int) -> None:
    """G4: P in the unit of the control, X and U in seconds."""
    letter = next((letter for letter in "PXU" if letter in block.values), "")
    if not letter:
        raise block.error("dwell_missing", "G4 without P", "G4")
    seconds = dwell_seconds(state, block, letter)
    if seconds:
        state.recorder.add(Kind.DWELL, block.row, f=seconds)


def dwell_seconds(state: State, block: Block, letter: str) -> float:
    """Return the time a word gives: P in the unit of the control, others in seconds."""
    seconds = block.not_negative(letter)
    return seconds / 1000.0 if letter == "P" and _is_milliseconds(state, block) else seconds


def _is_milliseconds(state: State, block: Block) -> bool:
    unit = state.control.readings.dwell_p
    if unit == "point":
        return not any(token[0] == "P" and "." in str(token[1]) for token in block.tokens)
    return unit == "ms"


def stop(state: State, block: Block, number: int) -> None:
    """M0 M1, and M2 M30, which end the program."""
    state.emit(Kind.STOP, block, aux=number // 10)
    state.ended = number in (20, 300)


def compensate(state: State, block: Block, number: int) -> None:
    """G41 G42 G41.1 G42.1: accepted, reported, not applied."""
    state.modal.compensation = number
    code = f"G{number / 10:g}"
    tools = state.tools
    if "D" in block.values and number in (410, 420):
        entry = block.whole("D")
        if tools is not None and entry and entry not in tools:
            raise block.error("tool_not_found", f"D{entry}", "D")
    state.unsupported.append(f"{code} line {block.line}")
    state.report(block.finding("cutter_comp_uncompensated", code, code), code)


def cancel_compensation(state: State, block: Block, number: int) -> None:
    """G40."""
    state.modal.compensation = number


def listed_g(state: State, block: Block, number: int) -> None:
    """A G code that the machine file lists."""
    _listed(state, block, f"G{number / 10:g}", state.control.readings.g_codes[number / 10])


def listed_m(state: State, block: Block, number: int) -> None:
    """An M code that the machine file lists."""
    _listed(state, block, f"M{number / 10:g}", state.control.readings.m_codes[number / 10])


def _listed(state: State, block: Block, code: str, effect: str) -> None:
    state.ignored[code] += 1
    if effect == "stop":
        state.emit(Kind.STOP, block)


def unknown_m(state: State, block: Block, number: int) -> None:
    """An M code nobody listed: the program runs on, the verdict is open."""
    code = f"M{number / 10:g}"
    what = f"unknown code {code} (control: {{m_codes: {{{code[1:]}: none}}}})"
    if code not in (known.split()[0] for known in state.unsupported):
        state.unsupported.append(f"{code} line {block.line}")
    state.report(block.finding("unknown_m", what, code), code)

"""What T, M6, M61 and the codes of tool length and tool centre point do."""

from __future__ import annotations

from gcodesim.nc.control import tool_changes
from gcodesim.nc.control.five_axes import follows, set_tip_control
from gcodesim.nc.control.modal import Motion, TipControl
from gcodesim.nc.control.moves import feed_of, move
from gcodesim.nc.iso.block import Block
from gcodesim.nc.iso.g_codes import G
from gcodesim.nc.iso.memory import IsoState
from gcodesim.nc.iso.motion import axis_values
from gcodesim.nc.program import ZERO, Frame, Kind

TIP_CODES = (G.TIP, G.TIP_BY_VECTORS, G.TIP_OF_HAAS)

M428 = 4280


def select_tool(state: IsoState, block: Block, number: int) -> None:
    """T."""
    tool_changes.select_tool(state, block.whole("T"), "T")


def change_tool(state: IsoState, block: Block, number: int) -> None:
    """M6, M16 of Haas: the selected tool goes into the spindle, which stops."""
    tool_changes.change_tool(state, f"M{number // 10}")
    tool = (state.tools or {}).get(state.modal.tool or 0)
    if state.frames.tool[2] and tool is not None and state.codes.length == G.LENGTH:
        length = tool.offset[2]
        state.length_of_new_tool = None if length == state.frames.tool[2] else length


def declare_tool(state: IsoState, block: Block, number: int) -> None:
    """M61 Qn: tool n is in the spindle already."""
    if "Q" not in block.values:
        raise block.error("tool_not_found", "M61 without Q", "M61")
    tool = block.whole("Q")
    tool_changes.check_tool(state, tool, "Q")
    tool_changes.load_tool(state, tool, "M61")


def set_tool_length(state: IsoState, block: Block, number: int) -> None:
    """G43 Hn, G43.2 Hn added, G44 Hn subtracted; without H the tool in the spindle.

    They end what G43.4, G43.5 or G234 has begun, which take this way too.
    """
    value = _tool_offset(state, block)
    if number == G.LENGTH_NEGATIVE:
        value = [-v for v in value]
    elif number == G.LENGTH_ADDED:
        value = [old + v for old, v in zip(state.frames.tool, value, strict=True)]
    _set_tool_offset(state, value, number, "Z" not in block.values)


def change_length_entry(state: IsoState, block: Block, number: int) -> None:
    """H without a code of length: the row it names, for the length in force and the next G43."""
    code = state.codes.length
    if code == G.LENGTH_OFF:
        state.codes.length_entry = block.whole("H")
    elif code in TIP_CODES:
        set_tool_centre_point(state, block, code)
    else:
        set_tool_length(state, block, code)


def set_tool_length_words(state: IsoState, block: Block, number: int) -> None:
    """G43.1: the words are the tool offset."""
    values = axis_values(state, block)
    if not values:
        raise block.error("axis_missing", "G43.1 without axis words", "G43.1")
    value = [values.get(i, old) for i, old in enumerate(state.frames.tool)]
    _set_tool_offset(state, value, number, False)


def _set_tool_offset(state: IsoState, value: list[float], number: int, alone: bool) -> None:
    """Put a tool offset into force; `alone`: its block does not tell the length axis to move."""
    codes, before = state.codes, state.frames.tool[2]
    codes.length = number
    kept = M428 if codes.tip == M428 else 0
    followed = state.control.kinematics is not None
    codes.tip = number if number in TIP_CODES and followed else kept
    tool_changes.set_length(state, value, _tips(codes.tip))
    _change_length(state, value[2] - before, alone)


def _change_length(state: IsoState, change: float, alone: bool) -> None:
    """Move the length axis by a change of the tool length, where the control does so at once.

    Where the length was cancelled at a reference point, nothing of it is left to move.
    """
    was_cancelled, state.is_length_cancelled = state.is_length_cancelled, False
    state.length_of_new_tool = None
    if not change or not alone or was_cancelled or state.frame is not Frame.MACHINE:
        return
    if state.reading("length_change") == "at_once":
        position = state.position.copy()
        position[2] += change
        rapid = state.modal.motion in (Motion.RAPID, Motion.NONE)
        f = 0.0 if rapid else feed_of(state)
        move(state, Kind.RAPID if rapid else Kind.FEED, position, f)
        state.point = state.frames.program(position)


def _tips(code: int) -> TipControl:
    """Return what a code of tool centre point control says of X Y Z and I J K; 0 for none."""
    if not code:
        return TipControl.OFF
    return TipControl.VECTORS if code == G.TIP_BY_VECTORS else TipControl.ANGLES


def _tool_offset(state: IsoState, block: Block) -> list[float]:
    """Return the offset that H names; without H, what the reading `length_without_h` says."""
    entry: int | None
    reading, last = state.control.readings.length_without_h, state.codes.length_entry
    if "H" in block.values:
        entry = state.codes.length_entry = block.whole("H")
    elif reading == "spindle" or (reading == "last_or_spindle" and last is None):
        entry = state.modal.tool
    else:
        entry = last or 0
    tool = state.modal.tool
    if entry and tool and entry != tool and not block.has("G", G.LENGTH_ADDED):
        what = f"H{entry} with T{tool} in the spindle"
        state.report("length_not_of_tool", what, "H", subject=f"H{entry} T{tool}")
    if entry == 0 and state.control.readings.h0 == "spindle":
        entry = state.modal.tool
    return tool_changes.length_of(state, entry, "H", "G43")


def set_tool_centre_point(state: IsoState, block: Block, number: int) -> None:
    """G43.4 H, G43.5 H, G234 H, M428: X Y Z are the tip, seen from the part.

    Rotary words are axis positions; under G43.5 I J K is the direction of the tool instead.
    """
    is_m_code = block.has("M", number)
    if state.modal.table_offset or "table" in state.unfollowed:
        raise block.error("five_axis_conflict", "a five-axis code under a table offset")
    if not is_m_code:
        set_tool_length(state, block, number)
    name = f"M{number // 10}" if is_m_code else f"G{number / 10:g}"
    if follows(state, "length", name):
        # The same code once more changes nothing; another one may hold another table.
        tool = None if state.codes.tip == number else state.frames.tool
        state.codes.tip = number
        set_tip_control(state, _tips(number), tool)


def cancel_tool_centre_point(state: IsoState, block: Block, number: int) -> None:
    """G49, which ends the tool length too, M429."""
    state.codes.tip = 0
    if number != G.LENGTH_OFF:
        set_tip_control(state, TipControl.OFF)
        return
    state.codes.length = number
    set_tip_control(state, TipControl.OFF)
    if any(state.frames.tool):
        change = -state.frames.tool[2]
        tool_changes.set_length(state, list(ZERO), TipControl.OFF)
        _change_length(state, change, "Z" not in block.values)

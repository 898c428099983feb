"""What work offsets, G52, G92, tool changes and tool lengths do; none of them moves an axis."""

from __future__ import annotations

from gcodesim.nc.control.modal import TABLE_OFFSET_OFF
from gcodesim.nc.control.state import State
from gcodesim.nc.control.supply import ZERO, WorkOffset
from gcodesim.nc.iso.block import Block
from gcodesim.nc.program import AXES, PLANES, Kind

TIP_CODES = (434, 435, 2340)
"""G43.4, G43.5 and G234: X Y Z are the tip, seen from the part."""

M428 = 4280

ADDITIONAL = 100
"""G54.1 Pn is work offset 100 + n."""


def axis_values(state: State, block: Block) -> dict[int, float]:
    """Return index in AXES -> value [mm or deg] of the axis words of a block."""
    return {
        i: block.values[letter] * (state.scale if i < 3 else 1.0)
        for i, letter in enumerate(AXES)
        if letter in block.values
    }


def set_work_offset(state: State, block: Block, number: int) -> None:
    """G54 .. G59, G59.1 .. G59.3."""
    _activate(state, block, number // 10 - 53 if number < 590 else number - 584, number)


def set_additional_offset(state: State, block: Block, number: int) -> None:
    """G54.1 Pn, G154 Pn."""
    if "P" not in block.values:
        raise block.error("offset_not_found", f"G{number / 10:g} without P")
    _activate(state, block, ADDITIONAL + block.whole("P"), number)


def _activate(state: State, block: Block, index: int, number: int) -> None:
    offset = state.offsets.get(index)
    if offset is None and index != 1:
        name = f"G54.1 P{index - ADDITIONAL}" if index > ADDITIONAL else f"G{number / 10:g}"
        raise block.error("offset_not_found", name, f"G{number / 10:g}")
    offset = offset or WorkOffset()
    if state.modal.table_offset != TABLE_OFFSET_OFF and any(offset.value[3:]):
        raise block.error("table_offset_turned", f"G{number / 10:g} under a table offset")
    state.work_offset = index
    same = list(offset.value) == state.frames.g5x and offset.rotation == state.frames.rotation
    if same and state.modal.work_offset == number:
        return
    state.modal.work_offset = number
    state.frames.g5x, state.frames.rotation = list(offset.value), offset.rotation
    state.reframe()
    state.emit(Kind.G5X, block, state.frames.g5x, aux=index)


def set_local_offset(state: State, block: Block, number: int) -> None:
    """G52: the words are the G92 offset itself."""
    values = _needed(state, block, "G52")
    _set_g92(state, block, [values.get(i, old) for i, old in enumerate(state.frames.g92)])


def set_g92(state: State, block: Block, number: int) -> None:
    """G92: the offset with which the current point reads the words."""
    values = _needed(state, block, "G92")
    frames, point = state.frames, state.point
    steps = [point[i] - values.get(i, point[i]) for i in range(6)]
    if not frames.is_plain:
        steps = frames.inside(steps)
    _set_g92(state, block, [old + step for old, step in zip(frames.g92, steps, strict=True)])


def cancel_g92(state: State, block: Block, number: int) -> None:
    """G92.1 zeroes the offset, G92.2 lays it aside, G92.3 takes it up again."""
    frames = state.frames
    if number == 921:
        frames.g92_kept = list(ZERO)
    frames.g92 = list(frames.g92_kept) if number == 923 else list(ZERO)
    state.reframe()
    state.emit(Kind.G92, block, frames.g92)


def _set_g92(state: State, block: Block, value: list[float]) -> None:
    state.frames.g92 = value
    state.frames.g92_kept = list(value)
    state.reframe()
    state.emit(Kind.G92, block, value)


def _needed(state: State, block: Block, code: str) -> dict[int, float]:
    values = axis_values(state, block)
    if not values:
        raise block.error("axis_missing", f"{code} without axis words", code)
    return values


def rotate_plane(state: State, block: Block, number: int) -> None:
    """G68: program points turn by R about the words, or about the current point; G69 ends it.

    G69 ends a tilted plane too (G68.2).
    """
    frames = state.frames
    if number != 680:
        state.unfollowed.pop("frame", None)
        if frames.tilt is not None:
            axes, frames.tilt = state.axes, None
            state.stand(axes)
        if frames.turn_about is None:
            return
        frames.turn_about = None
    elif frames.tilt is not None:
        raise block.error("tilted_plane_active", "G68 in a tilted plane", "G68")
    elif "R" not in block.values:
        raise block.error("rotation_without_angle", "G68 without R", "G68")
    else:
        _, _, normal = PLANES[state.modal.plane]
        values = axis_values(state, block)
        centre = [values.get(i, state.point[i]) for i in range(3)]
        frames.turn_about = (centre, normal, block.values["R"])
    state.reframe()


def mirror(state: State, block: Block, number: int) -> None:
    """G51.1: program points are mirrored at the words; G50.1 ends it for the axes it names."""
    frames = state.frames
    values = axis_values(state, block)
    if rotary := next((letter for letter in "ABC" if letter in block.values), ""):
        raise block.error("unused_word", f"{rotary} cannot be mirrored", rotary)
    if number == 511:
        frames.mirror |= _needed(state, block, "G51.1")
    elif values:
        frames.mirror = {i: at for i, at in frames.mirror.items() if i not in values}
    elif frames.mirror:
        frames.mirror = {}
    else:
        return
    state.reframe()


def select_tool(state: State, block: Block, number: int) -> None:
    """T."""
    tool = block.whole("T")
    _check_tool(state, block, tool, "T")
    state.modal.selected = tool


def change_tool(state: State, block: Block, number: int) -> None:
    """M6: the selected tool goes into the spindle, which stops."""
    tool = state.modal.selected
    if tool is None:
        state.report(block.finding("tool_change_without_t", "M6 without T", "M6"))
        return
    _load(state, block, tool)
    state.modal.spindle = 50


def declare_tool(state: State, block: Block, number: int) -> None:
    """M61 Qn: tool n is in the spindle already."""
    if "Q" not in block.values:
        raise block.error("tool_not_found", "M61 without Q", "M61")
    tool = block.whole("Q")
    _check_tool(state, block, tool, "Q")
    _load(state, block, tool)


def _load(state: State, block: Block, tool: int) -> None:
    control = state.control
    if tool and control.tools is None and not control.tool_for_all:
        what = f"nothing is known about tool T{tool}"
        state.report(block.finding("tool_without_shape", what, "M"), f"T{tool}")
    state.modal.tool = tool
    state.emit(Kind.TOOL, block, aux=tool)


def _check_tool(state: State, block: Block, tool: int, letter: str) -> None:
    tools = state.tools
    if tools is not None and tool and tool not in tools:
        raise block.error("tool_not_found", f"{letter}{tool}", letter)


def set_tool_length(state: State, block: Block, number: int) -> None:
    """G43 Hn, G43.2 Hn added, G44 Hn subtracted; without H the tool in the spindle.

    They end what G43.4, G43.5 or G234 has begun, which take this way too.
    """
    value = _tool_offset(state, block)
    if number == 440:
        value = [-v for v in value]
    elif number == 432:
        value = [old + v for old, v in zip(state.frames.tool, value, strict=True)]
    _set_tool_offset(state, block, value, number)


def set_tool_length_words(state: State, block: Block, number: int) -> None:
    """G43.1: the words are the tool offset."""
    values = _needed(state, block, "G43.1")
    value = [values.get(i, old) for i, old in enumerate(state.frames.tool)]
    _set_tool_offset(state, block, value, number)


def cancel_tool_length(state: State, block: Block, number: int) -> None:
    """G49; it ends tool centre point control too, also that of M428."""
    state.modal.length = number
    set_tip_control(state, 0)
    if any(state.frames.tool):
        _set_tool_offset(state, block, list(ZERO), number)


def set_tip_control(state: State, code: int, tool: list[float] | None = None) -> None:
    """Switch tool centre point control on (G43.4 and its like, in tenths) or off (0).

    Nothing moves: what the axes stand at is counted anew.
    """
    state.unfollowed.pop("length", None)
    axes, modal = state.axes, state.modal
    if code and state.control.readings.tcp_frame == "work":
        state.tcp_rotary = axes[3:]
    if tool is not None:
        state.frames.tool = tool
    elif modal.tcp == code:
        return
    modal.tcp = code
    state.stand(axes)


def _set_tool_offset(state: State, block: Block, value: list[float], number: int) -> None:
    state.modal.length = number
    kept = M428 if state.modal.tcp == M428 else 0
    followed = state.control.kinematics is not None
    set_tip_control(state, number if number in TIP_CODES and followed else kept, value)
    state.emit(Kind.TOOL_OFFSET, block, value)


def _tool_offset(state: State, block: Block) -> list[float]:
    """Return the offset that H names, or that of the tool in the spindle without H.

    Without a tool table the length of the mounted tool stands in. H0 is zero, or the tool
    in the spindle too where the control reads it so.
    """
    control = state.control
    entry = block.whole("H") if "H" in block.values else state.modal.tool
    if entry == 0 and control.readings.h0 == "spindle":
        entry = state.modal.tool
    if state.tools is None and entry != 0:
        if not control.tool_for_all:
            what = f"no tools file gives the length of H{entry}" if entry else "no tools file"
            state.report(block.finding("tool_without_shape", what, "G43"), f"H{entry}")
        return [0.0, 0.0, control.mounted_length, 0.0, 0.0, 0.0]
    if not entry or state.tools is None:
        return list(ZERO)
    _check_tool(state, block, entry, "H")
    return list(state.tools[entry].offset)

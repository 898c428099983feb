"""What work offsets, G52, G92, tool changes and tool lengths do; none of them moves an axis."""

from __future__ import annotations

from gcodesim.nc.block import Block
from gcodesim.nc.control import ZERO, WorkOffset
from gcodesim.nc.program import AXES, PLANES, Kind
from gcodesim.nc.state import State

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
    _set_g92(
        state,
        block,
        [old + point[i] - values.get(i, point[i]) for i, old in enumerate(frames.g92)],
    )


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
    """G68: program points turn by R about the words, or about the current point; G69 ends it."""
    frames = state.frames
    if number != 680:
        state.unfollowed.pop("frame", None)
        if frames.turn_about is None:
            return
        frames.turn_about = None
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
    """G43 Hn, G43.2 Hn added, G44 Hn subtracted; without H the tool in the spindle."""
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
    """G49."""
    if any(state.frames.tool):
        _set_tool_offset(state, block, list(ZERO), number)
    state.modal.length = number


def _set_tool_offset(state: State, block: Block, value: list[float], number: int) -> None:
    state.unfollowed.pop("length", None)
    state.frames.tool = value
    state.modal.length = number
    state.reframe()
    state.emit(Kind.TOOL_OFFSET, block, value)


def _tool_offset(state: State, block: Block) -> list[float]:
    """Return the offset that H names, or that of the tool in the spindle without H.

    Without a tool table the length of the mounted tool stands in; H0 is always zero.
    """
    control = state.control
    entry = block.whole("H") if "H" in block.values else state.modal.tool
    if state.tools is None and entry != 0:
        if not control.tool_for_all:
            what = f"no tools file gives the length of H{entry}" if entry else "no tools file"
            state.report(block.finding("tool_without_shape", what, "G43"), f"H{entry}")
        return [0.0, 0.0, control.mounted_length, 0.0, 0.0, 0.0]
    if not entry or state.tools is None:
        return list(ZERO)
    _check_tool(state, block, entry, "H")
    return list(state.tools[entry].offset)

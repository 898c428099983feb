"""Tools: selected, loaded, their length put into the frames; a change may have a motion."""

from __future__ import annotations

from gcodesim.nc.control.five_axes import set_tip_control
from gcodesim.nc.control.modal import Spindle, TipControl
from gcodesim.nc.control.moves import move_axes
from gcodesim.nc.control.orders import dwell
from gcodesim.nc.control.readings import ToolChangeMotion
from gcodesim.nc.control.state import State
from gcodesim.nc.program import AXES, ZERO, Kind


def select_tool(state: State, tool: int, letter: str) -> None:
    """Select a tool for the next change.

    Args:
        state: of the control.
        tool: its number.
        letter: of the word that names it.

    Raises:
        ProgramError: the supplied table has no such tool.
    """
    check_tool(state, tool, letter)
    state.modal.selected = tool


def change_tool(state: State, code: str) -> None:
    """Put the selected tool into the spindle, which stops, where the control changes tools.

    Args:
        state: of the control.
        code: name of the code that asks for it.
    """
    tool = state.modal.selected
    if tool is None:
        state.report("tool_change_without_t", f"{code} without T", code)
        return
    state.turn_spindle(Spindle.OFF)
    _go_to_change(state)
    load_tool(state, tool, code)


def _go_to_change(state: State) -> None:
    """Rapid the old tool to where the control changes tools, and wait as long as that takes."""
    motion = state.control.readings.tool_change
    if not isinstance(motion, ToolChangeMotion):
        # A word; what is not known makes no difference where Z stands at the reference point.
        motion = ToolChangeMotion(retract=("Z",))
        if _ends_of(state, motion)[-1] == state.axes or state.reading("tool_change") == "stays":
            return
    state.tell(AXES.index(letter) for letter in (*motion.retract, *motion.position))
    for axes in _ends_of(state, motion):
        move_axes(state, Kind.RAPID, axes)
    dwell(state, motion.seconds)


def _ends_of(state: State, motion: ToolChangeMotion) -> list[list[float]]:
    """Return the axis positions that a tool change goes to, one after the other."""
    named = (*motion.retract, *motion.position)
    first, then = state.axes.copy(), state.axes.copy()
    reference = state.reference.get("G28", {})
    for letter in named:
        i = AXES.index(letter)
        if letter in state.control.axes:
            then[i] = motion.position.get(letter, reference.get(letter, then[i]))
            if letter in motion.retract:
                first[i] = then[i]
    return [first, then]


def load_tool(state: State, tool: int, code: str) -> None:
    """Count a tool as the one in the spindle.

    Args:
        state: of the control.
        tool: its number, 0 = none.
        code: name of the code that asks for it.
    """
    control = state.control
    if tool and control.tools is None and not control.tool_for_all:
        what = f"nothing is known about tool T{tool}"
        state.report("tool_without_shape", what, code[:1], subject=f"T{tool}")
    state.modal.tool = tool
    state.emit(Kind.TOOL, aux=tool)


def check_tool(state: State, tool: int, letter: str) -> None:
    """Check that a supplied table has a tool, 0 aside.

    Raises:
        ProgramError: it has not.
    """
    tools = state.tools
    if tools is not None and tool and tool not in tools:
        raise state.place.error("tool_not_found", f"{letter}{tool}", letter)


def length_of(state: State, entry: int | None, letter: str, code: str) -> list[float]:
    """Return the offset X Y Z A B C that a row of the tool table gives.

    Without a tool table the length of the mounted tool is used instead. Row 0 is no offset.

    Args:
        state: of the control.
        entry: number of the row, None where no tool was loaded.
        letter: of the word that names it.
        code: name of the code that asks for it.

    Raises:
        ProgramError: the supplied table has no such row.
    """
    control = state.control
    if state.tools is None and entry != 0:
        if not control.tool_for_all:
            what = f"no tools file gives the length of {letter}{entry}"
            what = what if entry else "no tools file"
            state.report("tool_without_shape", what, code, subject=f"{letter}{entry}")
        return [0.0, 0.0, control.mounted_length, 0.0, 0.0, 0.0]
    if not entry or state.tools is None:
        return list(ZERO)
    check_tool(state, entry, letter)
    return list(state.tools[entry].offset)


def set_length(state: State, offset: list[float], tips: TipControl) -> None:
    """Put a tool offset into force, with or without tool centre point control.

    Args:
        state: of the control.
        offset: X Y Z [mm], A B C [deg].
        tips: what X Y Z and directions mean from here on.
    """
    set_tip_control(state, tips, offset)
    state.emit(Kind.TOOL_OFFSET, offset)

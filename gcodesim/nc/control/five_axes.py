"""Tool centre point control, tilted planes and table offsets; only a swivel moves an axis.

Tool centre point control and tilted planes count moves as tips (Frame.WORK); moves to axis
positions are reached straight in the joints all the same, and the program point is counted anew
after them. A tool change moves nothing and leaves everything on: the tool offset stays until the
next one. Table offsets keep the axes of the machine, so their moves are recorded as axis positions.
"""

from __future__ import annotations

from collections.abc import Sequence

from gcodesim.nc.control.frames import Level, Matrix, apply, inverse, product
from gcodesim.nc.control.modal import TipControl
from gcodesim.nc.control.moves import move_axes
from gcodesim.nc.control.state import State
from gcodesim.nc.control.tips import rotary_for, tool_turn
from gcodesim.nc.program import Kind

REASONS = {
    "length": "tool centre point control",
    "frame": "a tilted plane",
    "table": "a table offset",
}
"""What is switched on -> what it is called; it needs the kinematics of a machine."""


def follows(state: State, what: str, code: str) -> bool:
    """Tell whether a code can be followed; without kinematics the next move will be refused.

    Args:
        state: of the control.
        what: key of REASONS.
        code: name of the code.

    Raises:
        ProgramError: the machine has no rotary axes.
    """
    if not set("ABC") & set(state.control.axes):
        raise state.place.error("rotary_axes_missing", code, code)
    if state.control.kinematics is not None:
        return True
    state.unfollowed[what] = f"{code} ({REASONS[what]} needs a machine with its kinematics)"
    return False


def set_tip_control(state: State, tips: TipControl, tool: list[float] | None = None) -> None:
    """Switch tool centre point control on or off.

    Nothing moves: what the axes stand at is counted anew.

    Args:
        state: of the control.
        tips: what X Y Z and directions mean from here on.
        tool: the tool offset from here on, None = the one in force.
    """
    state.unfollowed.pop("length", None)
    axes, modal = state.axes, state.modal
    if tips is not TipControl.OFF and state.control.readings.tcp_frame == "work":
        state.tcp_rotary = axes[3:]
    if tool is not None:
        state.frames.tool = tool
    elif modal.tip_control is tips:
        return
    modal.tip_control = tips
    state.stand(axes)


def set_plane(state: State, level: str, turn: Matrix, origin: Sequence[float]) -> None:
    """Let program points lie in a tilted plane.

    Args:
        state: of the control.
        level: the level of the frames that tilts.
        turn: axes of the plane in columns, in those outside the level.
        origin: X Y Z of its zero point there [mm].
    """
    axes, frames = state.axes, state.frames
    frames.levels[level] = Level([*origin, 0.0, 0.0, 0.0], turn)
    frames.tilted = True
    state.stand(axes)


def set_further_plane(state: State, level: str, turn: Matrix, origin: Sequence[float]) -> None:
    """Tilt the plane in force further, about a zero point [mm] that lies in it."""
    outer = state.frames.levels[level]
    assert outer.turn is not None
    arm = apply(outer.turn, origin)
    origin = [a + o for a, o in zip(arm, outer.shift, strict=False)]
    set_plane(state, level, product(outer.turn, turn), origin)


def end_plane(state: State, level: str) -> None:
    """End the tilted plane of a level; nothing moves."""
    state.unfollowed.pop("frame", None)
    if state.frames.tilted:
        axes = state.axes
        state.frames.levels[level], state.frames.tilted = Level(), False
        state.stand(axes)


def plane_of_tool(state: State, level: str) -> Matrix:
    """Return the axes of the tool's link as it stands, in those outside a level."""
    kinematics = state.control.kinematics
    assert kinematics is not None
    seen = tool_turn(kinematics, state.axes[3:])
    return product(inverse(state.frames.turn_outside(level)), seen)


def swivel(state: State, prefer: int = 0) -> None:
    """Rapid the rotary axes until the tool stands square on the tilted plane.

    Only rotary joints move.

    Args:
        state: of the control.
        prefer: sign that the tilting joint shall have, 0 for the nearer way.

    Raises:
        ProgramError: the machine file lacks the kinematics.
    """
    if "frame" in state.unfollowed:
        raise state.refusal()
    kinematics = state.control.kinematics
    assert kinematics is not None
    normal = state.frames.turn([0.0, 0.0, 1.0])
    axes = state.axes
    rotary = rotary_for(kinematics, normal, axes[3:], prefer)
    move_axes(state, Kind.RAPID, [*axes[:3], *rotary])


def set_table_offset(state: State, *, on: bool) -> None:
    """Let the table carry the work offset's zero point along, or no longer."""
    state.unfollowed.pop("table", None)
    state.modal.table_offset = on
    state.reframe()

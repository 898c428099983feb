"""Tool centre point control, tilted planes and table offsets: what their codes switch on and off.

Nothing here moves an axis but G53.1, which turns the rotary ones. Tool centre point control and
tilted planes count moves as tips (Frame.WORK); what G53, G28 and G30 ask for are axis positions all
the same, reached straight in the joints, and the program point is counted anew behind them. A tool
change moves nothing and leaves everything on: the tool offset stays until the next G43 or G43.4.
Table offsets keep the axes of the machine, so their moves are recorded as axis positions.
"""

from __future__ import annotations

from gcodesim.nc.control.frames import Matrix, Placement, apply, product, rotation, transposed
from gcodesim.nc.control.modal import TABLE_OFFSET_OFF
from gcodesim.nc.control.state import State
from gcodesim.nc.control.tips import rotary_for, tool_turn
from gcodesim.nc.iso.block import Block
from gcodesim.nc.iso.motion import move_axes
from gcodesim.nc.iso.offsets import (
    axis_values,
    cancel_tool_length,
    set_tip_control,
    set_tool_length,
)
from gcodesim.nc.program import Kind

TOOL_PLANE, FURTHER_PLANE, HAAS_PLANE = 683, 684, 2680

REASONS = {
    "length": "tool centre point control",
    "frame": "a tilted plane",
    "table": "a table offset",
}
"""What is switched on -> what it is called; it needs the kinematics of a machine."""


def set_tool_centre_point(state: State, block: Block, number: int) -> None:
    """G43.4 H, G43.5 H, G234 H, M428: X Y Z are the tip, seen from the part.

    Rotary words are axis positions; under G43.5 I J K is the direction of the tool instead.
    """
    is_m_code = block.has("M", number)
    _refuse_beside_table_offset(state, block)
    if not is_m_code:
        set_tool_length(state, block, number)
    if _follows(state, block, "length", f"M{number // 10}" if is_m_code else f"G{number / 10:g}"):
        set_tip_control(state, number)


def cancel_tool_centre_point(state: State, block: Block, number: int) -> None:
    """G49, M429."""
    if number == 490:
        cancel_tool_length(state, block, number)
    else:
        set_tip_control(state, 0)


def set_tilted_plane(state: State, block: Block, number: int) -> None:
    """G68.2, G68.3, G68.4: program points lie in a tilted plane about X Y Z; G69 ends it.

    G68.2 I J K: turned about Z, the new X, the new Z. G68.4: the same, in the plane in force.
    G68.3 R: its axes are those of the tool's link as it stands, turned by R about the tool.
    """
    code, frames = f"G{number / 10:g}", state.frames
    _refuse_beside_table_offset(state, block)
    _check_plane(state, block, number, code)
    if not _follows(state, block, "frame", code):
        return
    axes, values = state.axes, axis_values(state, block)
    origin = [values.get(i, 0.0) for i in range(3)]
    turn = _plane_of_tool(state, block) if number == TOOL_PLANE else _euler(block)
    if number == FURTHER_PLANE and frames.tilt is not None:
        arm = apply(frames.tilt.turn, origin)
        origin = [a + o for a, o in zip(arm, frames.tilt.shift, strict=True)]
        turn = product(frames.tilt.turn, turn)
    frames.tilt = Placement(turn, origin)
    state.stand(axes)


def _check_plane(state: State, block: Block, number: int, code: str) -> None:
    """Check that a plane may begin here, and that it is given in a way that is followed."""
    frames, values = state.frames, block.values
    if number == FURTHER_PLANE and frames.tilt is None and "frame" not in state.unfollowed:
        raise block.error("tilted_plane_missing", "G68.4 without a plane", code)
    if number != FURTHER_PLANE and (frames.tilt or frames.turn_about):
        raise block.error("tilted_plane_active", f"{code} with another plane in force", code)
    if values.get("P") or number == HAAS_PLANE:
        state.unsupported.append(f"{code} line {block.line}")
        what = code if number == HAAS_PLANE else f"{code} P{values['P']:g}"
        raise block.error("unknown_g", f"{what} (planes are followed by their Euler angles only)")
    unused = "ABCQ" if number == TOOL_PLANE else "ABCQR"
    if stray := next((letter for letter in unused if letter in values), ""):
        raise block.error("unused_word", f"{stray} with {code}", stray)


def _euler(block: Block) -> Matrix:
    about_z, about_x, about_z_again = (
        rotation(axis, block.values.get(letter, 0.0))
        for axis, letter in ((2, "I"), (0, "J"), (2, "K"))
    )
    return product(about_z, product(about_x, about_z_again))


def _plane_of_tool(state: State, block: Block) -> Matrix:
    """Return the axes of the tool's link in those of the work offset, turned by R."""
    assert state.control.kinematics is not None
    seen = tool_turn(state.control.kinematics, state.axes[3:])
    turn = product(transposed(state.frames.outer), seen)
    return product(turn, rotation(2, block.values.get("R", 0.0)))


def align_tool(state: State, block: Block, number: int) -> None:
    """G53.1 P: the rotary axes turn at rapid until the tool stands square on the tilted plane.

    P1 wants the tilting joint positive, P2 negative. Only rotary joints move.
    """
    if "frame" in state.unfollowed:
        raise state.refusal(block)
    if state.frames.tilt is None:
        raise block.error("tilted_plane_missing", "G53.1 without a plane", "G53.1")
    choice = block.whole("P") if "P" in block.values else 0
    if choice > 2:
        raise block.error("alignment_choice", f"P{choice}", "P")
    assert state.control.kinematics is not None
    normal = state.frames.turn([0.0, 0.0, 1.0, 0.0, 0.0, 0.0])[:3]
    axes = state.axes
    rotary = rotary_for(state.control.kinematics, normal, axes[3:], (0, 1, -1)[choice])
    move_axes(state, block, Kind.RAPID, [*axes[:3], *rotary])


def set_table_offset(state: State, block: Block, number: int) -> None:
    """G254, G54.2 P: the table carries the work offset's zero point along; G255, G54.2 P0 end it.

    The axes stay those of the machine. G54.2 takes the work offset in force, whatever its P.
    """
    modal = state.modal
    if number == TABLE_OFFSET_OFF or block.values.get("P") == 0.0:
        state.unfollowed.pop("table", None)
        modal.table_offset = TABLE_OFFSET_OFF
        state.reframe()
        return
    code = f"G{number / 10:g}"
    if modal.tcp or state.frames.tilt or state.unfollowed.keys() & {"length", "frame"}:
        raise block.error("five_axis_conflict", f"{code} beside another five-axis code", code)
    if any(state.frames.g5x[3:]):
        raise block.error("table_offset_turned", code, code)
    if _follows(state, block, "table", code):
        modal.table_offset = number
        state.reframe()


def _refuse_beside_table_offset(state: State, block: Block) -> None:
    if state.modal.table_offset != TABLE_OFFSET_OFF or "table" in state.unfollowed:
        raise block.error("five_axis_conflict", "a five-axis code under a table offset")


def _follows(state: State, block: Block, what: str, code: str) -> bool:
    """Tell whether a code can be followed; without kinematics the next move will be refused."""
    if not set("ABC") & set(state.control.axes):
        raise block.error("rotary_axes_missing", code, code)
    if state.control.kinematics is not None:
        return True
    state.unfollowed[what] = f"{code} ({REASONS[what]} needs a machine with its kinematics)"
    return False

"""What the codes of tilted planes and table offsets switch on and off; G53.1 turns rotary axes."""

from __future__ import annotations

from gcodesim.nc.control import five_axes
from gcodesim.nc.control.five_axes import follows
from gcodesim.nc.control.frames import Matrix, product, rotation
from gcodesim.nc.iso.block import Block
from gcodesim.nc.iso.g_codes import G
from gcodesim.nc.iso.memory import PLANE, IsoState
from gcodesim.nc.iso.motion import axis_values


def set_tilted_plane(state: IsoState, block: Block, number: int) -> None:
    """G68.2, G68.3, G68.4: program points lie in a tilted plane about X Y Z; G69 ends it.

    G68.2 I J K: turned about Z, the new X, the new Z. G68.4: the same, in the plane in force.
    G68.3 R: its axes are those of the tool's link as it stands, turned by R about the tool.
    """
    code = f"G{number / 10:g}"
    if state.modal.table_offset or "table" in state.unfollowed:
        raise block.error("five_axis_conflict", "a five-axis code under a table offset")
    _check_plane(state, block, number, code)
    if not follows(state, "frame", code):
        return
    values = axis_values(state, block)
    origin = [values.get(i, 0.0) for i in range(3)]
    if number == G.PLANE_OF_TOOL:
        turn = product(five_axes.plane_of_tool(state, PLANE), _about_normal(block))
        five_axes.set_plane(state, PLANE, turn, origin)
    elif number == G.FURTHER_PLANE and state.frames.tilted:
        five_axes.set_further_plane(state, PLANE, _euler(block), origin)
    else:
        five_axes.set_plane(state, PLANE, _euler(block), origin)


def _check_plane(state: IsoState, block: Block, number: int, code: str) -> None:
    """Check that a plane may begin here, and that it is given in a way that is followed."""
    tilted, values = state.frames.tilted, block.values
    if number == G.FURTHER_PLANE and not tilted and "frame" not in state.unfollowed:
        raise block.error("tilted_plane_missing", "G68.4 without a plane", code)
    if number != G.FURTHER_PLANE and (tilted or state.is_rotated):
        raise block.error("tilted_plane_active", f"{code} with another plane in force", code)
    if values.get("P") or number == G.PLANE_OF_HAAS:
        state.unsupported.append(f"{code} line {block.line}")
        what = code if number == G.PLANE_OF_HAAS else f"{code} P{values['P']:g}"
        raise block.error("unknown_g", f"{what} (planes are followed by their Euler angles only)")
    unused = "ABCQ" if number == G.PLANE_OF_TOOL else "ABCQR"
    if stray := next((letter for letter in unused if letter in values), ""):
        raise block.error("unused_word", f"{stray} with {code}", stray)


def _euler(block: Block) -> Matrix:
    about_z, about_x, about_z_again = (
        rotation(axis, block.values.get(letter, 0.0))
        for axis, letter in ((2, "I"), (0, "J"), (2, "K"))
    )
    return product(about_z, product(about_x, about_z_again))


def _about_normal(block: Block) -> Matrix:
    return rotation(2, block.values.get("R", 0.0))


def align_tool(state: IsoState, block: Block, number: int) -> None:
    """G53.1 P: the rotary axes turn at rapid until the tool stands square on the tilted plane.

    P1 wants the tilting joint positive, P2 negative. Only rotary joints move.
    """
    if "frame" in state.unfollowed:
        raise state.refusal()
    if not state.frames.tilted:
        raise block.error("tilted_plane_missing", "G53.1 without a plane", "G53.1")
    choice = block.whole("P") if "P" in block.values else 0
    if choice > 2:
        raise block.error("alignment_choice", f"P{choice}", "P")
    five_axes.swivel(state, (0, 1, -1)[choice])


def set_table_offset(state: IsoState, block: Block, number: int) -> None:
    """G254, G54.2 P: the table carries the work offset's zero point along; G255, G54.2 P0 end it.

    The axes stay those of the machine. G54.2 takes the work offset in force, whatever its P.
    """
    if number == G.TABLE_OFFSET_OFF or block.values.get("P") == 0.0:
        five_axes.set_table_offset(state, on=False)
        return
    code = f"G{number / 10:g}"
    tips = state.codes.tip or state.frames.tilted
    if tips or state.unfollowed.keys() & {"length", "frame"}:
        raise block.error("five_axis_conflict", f"{code} beside another five-axis code", code)
    if any(state.work.value[3:]):
        raise block.error("table_offset_turned", code, code)
    if follows(state, "table", code):
        five_axes.set_table_offset(state, on=True)

"""Tool centre point, tilted planes, table offsets: kept until motion/ can follow their moves."""

from __future__ import annotations

from gcodesim.errors import ProgramError
from gcodesim.nc.block import Block
from gcodesim.nc.offsets import cancel_tool_length, set_tool_length
from gcodesim.nc.state import State

REASONS = {
    "length": "tool centre point control is not followed yet",
    "frame": "tilted planes are not followed yet",
    "table": "table offsets are not followed yet",
}
"""What is switched on -> why a move under it is refused."""


def set_tool_centre_point(state: State, block: Block, number: int) -> None:
    """G43.4 H, G43.5 H, G234 H, M428: X Y Z are the tip, seen from the part."""
    if block.has("M", number):
        _switch_on(state, block, "length", f"M{number // 10}")
        return
    set_tool_length(state, block, number)
    _switch_on(state, block, "length", f"G{number / 10:g}")


def cancel_tool_centre_point(state: State, block: Block, number: int) -> None:
    """G49, M429."""
    state.unfollowed.pop("length", None)
    if number == 490:
        cancel_tool_length(state, block, number)


def set_tilted_plane(state: State, block: Block, number: int) -> None:
    """G68.2 X Y Z I J K, G68.3: program points lie in a tilted plane; G69 ends it."""
    _switch_on(state, block, "frame", f"G{number / 10:g}")


def align_tool(state: State, block: Block, number: int) -> None:
    """G53.1: the rotary axes turn until the tool stands on the tilted plane."""
    if "frame" not in state.unfollowed:
        raise block.error("tilted_plane_missing", "G53.1 without a plane", "G53.1")
    raise refusal(state, block)


def set_table_offset(state: State, block: Block, number: int) -> None:
    """G254, G54.2 P: the table carries the work offset; G255 ends it."""
    if number == 2550:
        state.unfollowed.pop("table", None)
    else:
        _switch_on(state, block, "table", f"G{number / 10:g}")


def _switch_on(state: State, block: Block, what: str, code: str) -> None:
    if not set("ABC") & set(state.control.axes):
        raise block.error("rotary_axes_missing", code, code)
    state.unfollowed[what] = f"{code} ({REASONS[what]})"


def refusal(state: State, block: Block) -> ProgramError:
    """Return the error of a move under what is not followed."""
    what = next(iter(state.unfollowed.values()))
    state.unsupported.append(f"{what.partition(' ')[0]} line {block.line}")
    return block.error("unknown_g", what)

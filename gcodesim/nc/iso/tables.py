"""G10: what a program writes into the control's tables of offsets and tools."""

from __future__ import annotations

import math
from collections.abc import Sequence

from gcodesim.nc.control.supply import ToolEntry, WorkOffset
from gcodesim.nc.iso.block import Block
from gcodesim.nc.iso.memory import IsoState
from gcodesim.nc.iso.motion import axis_values
from gcodesim.nc.iso.offsets import ADDITIONAL, check_measured, in_force
from gcodesim.nc.program import ZERO, Frame, Kind

FIXTURES = 9
"""Work offsets G54 to G59.3."""


def set_table(state: IsoState, block: Block, number: int) -> None:
    """G10: L2 and L20 set work offsets, L1, L10 and L11 tools."""
    kind = block.values.get("L")
    by_radius = state.control.readings.g10_tool_r == "length"
    if by_radius and "R" in block.values and kind in (None, 1.0):
        kind = 11.0
    if kind == 2.0 and block.values.get("P") == 0.0 and _is_external(state):
        _set_external(state, block)
    elif by_radius and kind in (12.0, 13.0):
        # The diameter and its wear change no path that is followed.
        _tool_number(block)
    elif kind in (2.0, 20.0):
        _set_offset(state, block, solve=kind == 20.0)
    elif kind in (1.0, 10.0, 11.0):
        _set_tool(state, block, int(kind))
    else:
        what = "G10 without L" if kind is None else f"G10 L{kind:g}"
        raise block.error("g10_bad_l", what, "L" if kind is not None else "G10")


def _set_offset(state: IsoState, block: Block, *, solve: bool) -> None:
    index, solve = _offset_index(state, block, solve)
    if solve:
        _refuse_where_points_are_tips(state, block)
    values = axis_values(state, block)
    if solve:
        check_measured(state, block, values)
    old = state.offsets.get(index, WorkOffset())
    rotation = block.values.get("R", old.rotation)
    if solve:
        new = _solved(state, values, old.value, math.radians(rotation))
    else:
        adds = state.modal.incremental and state.control.readings.g10_in_g91 == "adds"
        new = [
            values.get(i, 0.0) + v if adds or i not in values else values[i]
            for i, v in enumerate(old.value)
        ]
    offset = WorkOffset((new[0], new[1], new[2], new[3], new[4], new[5]), rotation)
    state.offsets[index] = offset
    if index == state.codes.offset:
        _renew(state)


def _is_external(state: IsoState) -> bool:
    return state.control.readings.g10_l2_p0 == "external"


def _set_external(state: IsoState, block: Block) -> None:
    """L2 P0: what is added to every work offset."""
    adds = state.modal.incremental and state.control.readings.g10_in_g91 == "adds"
    for i, value in axis_values(state, block).items():
        state.external[i] = state.external[i] + value if adds else value
    _renew(state)


def _renew(state: IsoState) -> None:
    """Put the active work offset into force as the tables give it now."""
    offset = in_force(state, state.codes.offset)
    state.set_work(offset)
    state.emit(Kind.G5X, offset.value, aux=state.codes.offset)


def _solved(
    state: IsoState, values: dict[int, float], old: Sequence[float], angle: float
) -> list[float]:
    """Return the offset with which the current point reads the words, and what it read elsewhere.

    Where X and Y are turned, one word alone moves the origin in both.
    """
    cos, sin = math.cos(angle), math.sin(angle)
    held = [p - t for p, t in zip(state.position, state.frames.tool, strict=True)]
    arm = _about_z(cos, -sin, [h - o for h, o in zip(held, old, strict=True)])
    words = [values.get(i, a - g) for i, (a, g) in enumerate(zip(arm, state.g92, strict=True))]
    turned = _about_z(cos, sin, [w + g for w, g in zip(words, state.g92, strict=True)])
    named = values.keys() | ({0, 1} if angle and values.keys() & {0, 1} else set())
    return [held[i] - turned[i] if i in named else old[i] for i in range(6)]


def _about_z(cos: float, sin: float, vector: list[float]) -> list[float]:
    """Return a vector turned about Z by the angle with this cosine and sine."""
    x, y, *rest = vector
    return [cos * x - sin * y, sin * x + cos * y, *rest]


def _offset_index(state: IsoState, block: Block, solve: bool) -> tuple[int, bool]:
    """Return the number of the work offset, and whether it is to be solved for.

    P of L20 may name an additional offset, which its words set (readings.g10_l20).
    """
    value = block.values.get("P", 0.0)
    reading = state.control.readings.g10_l20
    additional = solve and reading == "additional"
    additional = additional or (solve and reading == "above_9" and value > FIXTURES)
    if value < 0 or not value.is_integer() or (value > FIXTURES and not additional):
        raise block.error("g10_bad_p", f"G10 with P{value:g}", "P")
    if additional and value:
        return ADDITIONAL + int(value), False
    return int(value) or state.codes.offset, solve


def _set_tool(state: IsoState, block: Block, kind: int) -> None:
    """L1: the words; L10: the current point reads them; L11: it reads them in G59.3.

    Fanuc and Haas give the length, or its wear, as R.
    """
    tool = _tool_number(block)
    if state.tools is None:
        what = f"no tools file to change T{tool} in"
        state.report("tool_without_shape", what, "G10", subject=f"T{tool}")
        return
    values = axis_values(state, block)
    if kind != 1 and values:
        _refuse_where_points_are_tips(state, block)
        check_measured(state, block, values)
    old = state.tools.get(tool, ToolEntry(tool, ZERO, 0.0))
    offset = list(old.offset)
    if state.control.readings.g10_tool_r == "length" and "R" in block.values:
        length = block.values["R"] * state.scale
        offset[2] = offset[2] + length if kind == 11 else length
    fixture = state.offsets.get(FIXTURES, WorkOffset()).value
    for i, word in values.items():
        if kind == 1:
            offset[i] = word
        elif kind == 10:
            offset[i] = state.frames.tool[i] + state.point[i] - word
        else:
            offset[i] = state.position[i] - fixture[i] - word
    entry = (offset[0], offset[1], offset[2], offset[3], offset[4], offset[5])
    state.tools[tool] = ToolEntry(tool, entry, old.diameter, old.name)


def _tool_number(block: Block) -> int:
    value = block.values.get("P")
    if value is None or value < 1 or not value.is_integer():
        raise block.error("g10_bad_p", "G10 for a tool needs P1 or more", "P")
    return int(value)


def _refuse_where_points_are_tips(state: IsoState, block: Block) -> None:
    """Refuse to measure an offset or a tool where points are no axis positions."""
    if state.frame is not Frame.MACHINE or state.frames.carried is not None:
        what = f"G10 L{block.values['L']:g} with five-axis codes in force"
        raise block.error("measured_on_tips", what, "G10")

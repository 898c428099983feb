"""Lengths and angles among the words of a block: which they are, in which unit, how they count.

A number without a decimal point, other than 0, may count increments (key `no_point`), and a length
needs a unit (key `program_unit`). Words that are neither length nor angle have no part in this.
"""

from __future__ import annotations

from gcodesim.nc.control.modal import TipControl
from gcodesim.nc.control.readings import ReadingMet
from gcodesim.nc.iso.block import CORNER, Block
from gcodesim.nc.iso.code_rows import Group, Order
from gcodesim.nc.iso.g_codes import G
from gcodesim.nc.iso.memory import IsoState
from gcodesim.nc.program import AXES, PLANES

LETTERS = frozenset("XYZUVWABCIJKQR")
"""Letters of lengths and angles. P L N D H T S are none, and F is read in one way."""

NUMBERS = frozenset((Order.SPINDLE, Order.OTHER, Order.DWELL, Order.PATH))
"""Orders of codes whose words are numbers: M19 R, G5.1 Q, G4 X, G64 Q."""

BY_ANGLES = (G.PLANE, G.FURTHER_PLANE, G.PLANE_OF_HAAS)
"""Codes whose I J K and R are angles."""

OFFSETS = 2.0
"""L of a G10 whose R is an angle."""


def settle_bare(state: IsoState, block: Block) -> None:
    """Leave in `bare` what is a length or an angle, and let it count increments if it does."""
    numbers = _numbers(state, block)
    block.bare = [at for at in block.bare if at not in numbers]
    if state.control.readings.no_point != "increment":
        return
    angles, inch = _angles(state, block), state.modal.inch
    # The unit counts for its own block.
    state.modal.inch = next((r.number == G.INCH for r in block.rows if r.group is Group.UNIT), inch)
    length, angle = state.increment(is_angle=False), state.increment(is_angle=True)
    state.modal.inch = inch
    for at in block.bare:
        if at == CORNER:
            block.corner = block.corner[0], block.corner[1] * length
        elif isinstance(at, int):
            letter, value = block.arguments[at]
            block.arguments[at] = letter, value * (angle if letter in "ABC" else length)
        else:
            block.values[at] *= angle if at in angles else length


def report_bare(state: IsoState, block: Block) -> None:
    """Say that a number without a decimal point may mean something else, where it may."""
    if state.reading("no_point") != "open":
        return
    at = block.bare[0]
    if isinstance(at, int):
        letter, value = block.arguments[at]
    else:
        letter, value = block.corner if at == CORNER else (at, block.values[at])
    state.report("no_point_open", f"{letter}{value:g} without a decimal point", letter)


def report_unit(state: IsoState, block: Block) -> None:
    """Say in which unit the first length is read, where nothing before it gives one."""
    others = _numbers(state, block) | _angles(state, block)
    lengths = LETTERS & block.values.keys() - others
    letter = next((letter for letter in block.values if letter in lengths), "")
    if not any(block.values[letter] for letter in lengths):
        return
    state.is_unit_told = True
    unit, given = "inch" if state.modal.inch else "mm", state.control.unit
    what = f"no G20 or G21 before {letter}: lengths are in {unit}"
    if given:
        state.report("unit_assumed", f"{what}, as `units` of the machine file", letter)
    else:
        state.report("unit_open", what, letter)
    state.met["program_unit"] = ReadingMet("program_unit", block.row, value=unit)


def _numbers(state: IsoState, block: Block) -> set[str]:
    """Return the letters of a block whose values are neither lengths nor angles."""
    found: set[str] = set()
    drills = bool(state.codes.cycle)
    for row in block.rows:
        if row.order in NUMBERS:
            found.update(row.words)
        elif row.number in BY_ANGLES and row.letter == "G":
            found.add("Q")
        elif row.number == G.SCALING and row.letter == "G":
            found.update("IJK")
        if row.order is Order.MOTION:
            drills = row.group is Group.CYCLE
    if drills and state.control.readings.peck_words == "q":
        # It counts holes.
        found.add("K")
    if state.modal.tip_control is TipControl.VECTORS or block.has("G", G.TIP_BY_VECTORS):
        vector = [letter for letter in "IJK" if block.values.get(letter)]
        if set(vector) <= set(map(str, block.bare)):
            # Scaled alike, they point the same way.
            found.update(vector)
    return found


def _angles(state: IsoState, block: Block) -> set[str]:
    """Return the letters of a block whose values are angles."""
    found = set("ABC")
    for row in block.rows:
        if row.letter != "G":
            continue
        if row.number in BY_ANGLES:
            found.update("IJKR")
        is_table = row.number == G.TABLE and block.values.get("L") == OFFSETS
        if is_table or row.number in (G.ROTATION, G.PLANE_OF_TOOL):
            found.add("R")
    polar = [row.number == G.POLAR for row in block.rows if row.group is Group.POLAR]
    if polar[-1] if polar else state.codes.polar:
        found.add(AXES[PLANES[state.modal.plane][1]])
    return found

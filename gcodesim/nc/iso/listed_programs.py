"""Programs that live in the control, by what the machine file says that they do."""

from __future__ import annotations

from gcodesim.nc.control import moves, tool_changes
from gcodesim.nc.iso.calls import ARGUMENTS
from gcodesim.nc.iso.memory import IsoState
from gcodesim.nc.iso.motion import INDEX
from gcodesim.nc.iso.requests import CallProgram

LINEAR = "XYZ"


def stand_for(state: IsoState, what: str, call: CallProgram) -> None:
    """Do what a program of the control stands for.

    Args:
        state: of the control.
        what: a word of readings.STANDS_FOR.
        call: of the program.
    """
    name = f"O{call.number}"
    if what == "tool_change":
        tool_changes.change_tool(state, name)
    elif what == "probe":
        state.report("program_of_probe", name, subject=name)
        _probe(state, call.arguments or {})
    else:
        state.ignored[name] += 1


def _probe(state: IsoState, arguments: dict[float, float | None]) -> None:
    """Feed towards X Y Z of a probing program; where it stops is not known."""
    words = {
        INDEX[letter]: value * state.scale
        for letter in LINEAR
        if (value := arguments.get(ARGUMENTS[letter])) is not None
    }
    if words:
        given = arguments.get(ARGUMENTS["F"])
        feed = (given or 0.0) * state.scale
        moves.probe(state, moves.point_to(state, words), feed or PROBING_FEED)


PROBING_FEED = 3000.0
"""Feed of a probing program that is called without F [mm/min]: it decides the time alone."""

"""Calls and returns: what their words ask of the program flow."""

from __future__ import annotations

from gcodesim.nc.iso.block import Block
from gcodesim.nc.iso.memory import IsoState
from gcodesim.nc.iso.requests import CallBlock, CallProgram, Return

MAX_REPEATS = 1_000_000_000

ARGUMENTS = {
    **dict(zip("ABC", (1, 2, 3), strict=True)),
    **dict(zip("DEFHM", (7, 8, 9, 11, 13), strict=True)),
    **dict(zip("QRSTUVWXYZ", range(17, 27), strict=True)),
}
"""Letter of G65 -> local parameter; I J K begin at 4 and go on in threes."""


def call_program(state: IsoState, block: Block, number: int) -> None:
    """M98 P L; Fanuc writes the repeats before four digits of P too."""
    if "P" not in block.values and state.control.readings.tape and "(" in block.text:
        raise block.error("unknown_g", "M98 with the path of a file", "M98")
    if "P" not in block.values:
        raise block.error("call_without_number", "M98 without P", "M98")
    program = block.whole("P")
    repeats = _repeats(block)
    if "L" not in block.values:
        repeats, program = split_number(program, state.control.readings.m98_p)
    state.request = CallProgram(program, repeats)


def split_number(number: int, reading: str) -> tuple[int, int]:
    """Return repeats and number of the subprogram that P of M98 without L means."""
    return divmod(number, 10_000) if number > 9999 and reading == "repeats" else (1, number)


def call_block(state: IsoState, block: Block, number: int) -> None:
    """M97 P L."""
    if "P" not in block.values:
        raise block.error("call_without_number", "M97 without P", "M97")
    target = block.whole("P")
    state.request = CallBlock(target, _repeats(block))


def return_from_call(state: IsoState, block: Block, number: int) -> None:
    """M99, M99 P."""
    state.request = Return(block.whole("P") if "P" in block.values else None)


def call_macro(state: IsoState, block: Block, number: int) -> None:
    """G65 P L: the other words become local parameters of the macro."""
    if "P" not in block.values:
        raise block.error("call_without_number", "G65 without P", "G65")
    program, repeats = block.whole("P"), _repeats(block)
    arguments: dict[float, float | None] = {}
    sets, last = 0, -1
    for letter, value in block.arguments:
        if letter in "IJK":
            # A letter that does not come after the last one begins the next set of three.
            place = "IJK".index(letter)
            sets, last = (sets + 1 if place <= last else sets), place
            arguments[4 + 3 * sets + place] = value
        else:
            arguments[ARGUMENTS[letter]] = value
    if 4 + 3 * sets + 2 > 33:
        raise block.error("duplicate_word", f"{sets + 1} sets of I J K", "G65")
    state.request = CallProgram(program, repeats, arguments)


def _repeats(block: Block) -> int:
    repeats = block.whole("L") if "L" in block.values else 1
    if repeats > MAX_REPEATS:
        raise block.error("number_too_large", f"L{repeats}", "L")
    return repeats

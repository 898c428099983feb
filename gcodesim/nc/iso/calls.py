"""What calls and returns ask for; nc.flow carries it out behind the block."""

from __future__ import annotations

from collections.abc import Callable

from gcodesim.nc.control.program_flow import Flow
from gcodesim.nc.control.readings import Readings
from gcodesim.nc.control.state import State
from gcodesim.nc.iso.block import Block
from gcodesim.nc.iso.parameters import Level

Request = Callable[[Flow], None]
"""What happens to the flow behind a block."""

MAX_REPEATS = 1_000_000_000

ARGUMENTS = {
    **dict(zip("ABC", (1, 2, 3), strict=True)),
    **dict(zip("DEFHM", (7, 8, 9, 11, 13), strict=True)),
    **dict(zip("QRSTUVWXYZ", range(17, 27), strict=True)),
}
"""Letter of G65 -> local parameter; I J K begin at 4 and go on in threes."""


def call_program(state: State, block: Block, number: int) -> None:
    """M98 P L; the repeats may stand before four digits of P too."""
    if "P" not in block.values:
        raise block.error("subprogram_not_found", "M98 without P", "M98")
    program = block.whole("P")
    repeats = _repeats(block)
    if "L" not in block.values:
        repeats, program = split_number(program, state.control.readings)
    state.request = lambda flow: flow.call_program(program, repeats)


def split_number(number: int, readings: Readings) -> tuple[int, int]:
    """Return repeats and number of the subprogram that P of M98 without L means."""
    repeats = number > 9999 and readings.m98_p == "repeats"
    return divmod(number, 10_000) if repeats else (1, number)


def call_block(state: State, block: Block, number: int) -> None:
    """M97 P L."""
    if "P" not in block.values:
        raise block.error("block_not_found", "M97 without P", "M97")
    target, repeats = block.whole("P"), _repeats(block)
    state.request = lambda flow: flow.call_block(target, repeats)


def return_from_call(state: State, block: Block, number: int) -> None:
    """M99, M99 P; in the main program one pass, or all over again."""
    target = block.whole("P") if "P" in block.values else None

    def leave(flow: Flow) -> None:
        if not flow.is_main:
            flow.leave(target)
        elif target is not None:
            flow.go_to_number(target)
        elif state.control.readings.m99 == "restart":
            flow.restart()
        else:
            state.report(block.finding("main_program_repeats", "M99 in the main program", "M99"))
            state.ended = True

    state.request = leave


def call_macro(state: State, block: Block, number: int) -> None:
    """G65 P L: the other words become local parameters of the macro."""
    if "P" not in block.values:
        raise block.error("subprogram_not_found", "G65 without P", "G65")
    program, repeats = block.whole("P"), _repeats(block)
    level, sets = Level(), 0
    last = -1
    for letter, value in block.arguments:
        if letter in "IJK":
            # A letter that does not come behind the last one begins the next set of three.
            place = "IJK".index(letter)
            sets, last = (sets + 1 if place <= last else sets), place
            level.numbers[4 + 3 * sets + place] = value
        else:
            level.numbers[ARGUMENTS[letter]] = value
    if 4 + 3 * sets + 2 > 33:
        raise block.error("duplicate_word", f"{sets + 1} sets of I J K", "G65")
    state.request = lambda flow: flow.call_program(program, repeats, level)


def _repeats(block: Block) -> int:
    repeats = block.whole("L") if "L" in block.values else 1
    if repeats > MAX_REPEATS:
        raise block.error("number_too_large", f"L{repeats}", "L")
    return repeats

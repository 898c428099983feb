"""Finds a call of a subprogram that is nowhere before anything has moved, where it can be known.

That is the case for calls of the main program that nothing can keep from running: before the first
jump, loop, return or end of the program. Others are found when they run.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from gcodesim.nc.control.program_flow import FlowError, Source
from gcodesim.nc.iso.calls import split_number
from gcodesim.nc.iso.jumps import Jumps
from gcodesim.nc.iso.tape import compact

CALLS = (b"M98", b"m98", b"G65", b"g65")
NUMBER = re.compile(r"P([0-9]{1,8})(?![0-9.])")
FORK = re.compile(
    rb"(?i)goto|while|if|do *[1-3]|end|sub|repeat|break|continue|call|return|%"
    rb"|m *0*(?:2|30|97|99)(?![0-9.])"
)

FAR = 1 << 24
"""Bytes into a program after which calls are left to be found when they run."""


def missing_call(jumps: Jumps, m98_p: str) -> tuple[int, str, FlowError] | None:
    """Return line index, code and error of the first such call, None when there is none.

    A call in a block that is wrong otherwise, or may be deleted, is left alone.
    """
    source = jumps.flow.sources[0]
    for index in _certain_calls(source):
        text = compact(source.lines[index])
        number = NUMBER.search(text)
        letters = [letter for letter in text if letter.isalpha() and letter not in "GMIJK"]
        if number is None or "/" in text or len(set(letters)) < len(letters):
            continue
        code = "G65" if "G65" in text else "M98"
        program = int(number[1])
        if code == "M98" and "L" not in text:
            _, program = split_number(program, m98_p)
        try:
            jumps.find_program(program)
        except FlowError as error:
            return index, code, error
    return None


def _certain_calls(source: Source) -> Iterator[int]:
    """Yield the lines that call, as long as nothing stands before them that may go elsewhere."""
    lines = source.lines
    begin = int(lines.bounds[source.begin])
    end = min(int(lines.bounds[source.end]), begin + FAR)
    if not any(lines.data.find(letter, begin, end) >= 0 for letter in (b"P", b"p")):
        # Every call has a P word; in long programs one letter is found much faster than three.
        return
    calls = {
        lines.line_at(place) for word in CALLS for place in _places(lines.data, word, begin, end)
    }
    for index in sorted(calls):
        start = int(lines.bounds[index])
        if FORK.search(lines.data, begin, start):
            return
        begin = start
        yield index


def _places(data: bytes, word: bytes, begin: int, end: int) -> Iterator[int]:
    while (begin := data.find(word, begin, end)) >= 0:
        yield begin
        begin += len(word)

"""Where the text of a program begins and ends: %, the leader before it, the name behind it."""

from __future__ import annotations

import re

from gcodesim.nc.lines import TAPE_CHARACTERS, Lines

BLANKS = " \t" + TAPE_CHARACTERS
DROPPED = str.maketrans(dict.fromkeys(map(ord, BLANKS)))
COMMENT = re.compile(r"\([^()]*\)|;.*")
BLOCK = re.compile(r"(?:/[1-9]?)?(?:[A-Z][+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+))*")
"""A block of words, without blanks, in capitals."""

CODE = re.compile(r"[GMO:][0-9]")
NAMED = re.compile(r"%[O:][0-9]+")
"""A program number behind %, as in %O7031(NAME)."""


def compact(line: str) -> str:
    """Return a line without comments and blanks, in capitals."""
    if "(" in line or ";" in line:
        line = COMMENT.sub("", line)
    line = line.translate(DROPPED)
    return line.upper() if line.isascii() else line


def is_percent(line: str) -> bool:
    """Tell whether a line holds % and nothing else."""
    return line.strip(BLANKS) == "%"


def opening(lines: Lines, *, tape: bool) -> tuple[int, bool]:
    """Return the index of the first line to run, and whether the next % ends the program.

    Args:
        lines: the text.
        tape: what stands before the first % is a leader and is not read, and a program may end
            with a % that it has not begun with (Readings.tape).
    """
    first = next((i for i, line in enumerate(lines) if line.strip(BLANKS)), len(lines))
    if first < len(lines) and is_percent(lines[first]):
        return first + 1, True
    if tape and (opened := _after_leader(lines, first)) is not None:
        return opened, True
    return first, tape


def _after_leader(lines: Lines, first: int) -> int | None:
    """Return the index of the first line of the program that a % begins, None without one.

    A % after blocks, or with nothing after it, ends the program. The title behind a % is no block.
    """
    place = lines.data.find(b"%")
    if place < 0:
        return None
    index = lines.line_at(place)
    text = compact(lines[index])
    if not text.startswith("%") or any(_is_block(lines[i]) for i in range(first, index)):
        return None
    if text == "%" and not lines.data[int(lines.bounds[index + 1]) :].strip():
        return None
    if NAMED.fullmatch(text):
        return index
    return None if text != "%" and _is_block(text[1:]) else index + 1


def _is_block(line: str) -> bool:
    """Tell whether a line is a block with a code or a program number."""
    text = compact(line)
    return BLOCK.fullmatch(text) is not None and CODE.search(text) is not None

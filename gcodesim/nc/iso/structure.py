"""Where a program text may jump to: subprograms, loops and branches, found when it is read."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from gcodesim.errors import GcodesimError
from gcodesim.nc.iso.tape import compact, is_percent
from gcodesim.nc.lines import Lines

SEARCHED = 1 << 16
"""Bytes searched in one step."""

HEAD = re.compile(r"^%?(?:/[1-9]?)?(?:N[0-9.]+)?(?:/[1-9]?)?")
PROGRAM = re.compile(r"[:O]([0-9]{1,18})(?![0-9.]|[A-Z]{2})")
NAMED = re.compile(r"(<[^<>]*>)")
LOOP = re.compile(r"(?:WHILE\[.*\])?DO([0-9]+)$|END([0-9]+)$")
O_WORD = re.compile(
    r"O(?:([0-9]+)|<([^<>]*)>)"
    r"(SUB|ENDSUB|CALL|RETURN|IF|ELSEIF|ELSE|ENDIF|WHILE|ENDWHILE|DO|REPEAT|ENDREPEAT|BREAK|CONTINUE)"
)
BLOCK_NUMBER = re.compile(
    rb"(?mi)^[ \t\0\x11-\x14\x7f]*+(?:/[ \t]*+[1-9]?)?[ \t]*+N[ \t]*+([0-9]{1,18})"
)

RETURN_OR_END = re.compile(rb"(?i)M[ \t]*+0*+(?:2|30|99)(?![0-9.])")
CODE_AT_END = re.compile(r"M0*(2|30|99)(?![0-9.])")
"""In bytes, and in a compact line without comments."""

OPENERS = {
    "SUB": "ENDSUB",
    "IF": "ENDIF",
    "WHILE": "ENDWHILE",
    "REPEAT": "ENDREPEAT",
    "DO": "WHILE",
}
BRANCHES = ("ELSEIF", "ELSE")


class StructureError(GcodesimError):
    """Blocks that open and close nothing, or each other.

    Attributes:
        line: index of the line at fault.
    """

    def __init__(self, line: int, what: str) -> None:
        self.line = line
        super().__init__(what)


@dataclass(slots=True)
class Structure:
    """Line indices of what may be jumped to.

    Attributes:
        end: index of the line that closes the text (%), or the number of lines.
        programs: O-number, or <NAME>, -> its line.
        twice: O-number, or <NAME>, of several programs of the text -> the line of the second.
        subs: label of an o-word subprogram -> its line.
        partner: line that opens -> line that closes, and back: loops, and SUB to ENDSUB.
        next_branch: IF, ELSEIF, ELSE -> the next branch or ENDIF.
        loop_of: BREAK or CONTINUE -> line that opens its loop.
    """

    end: int
    programs: dict[int | str, int] = field(default_factory=dict)
    twice: dict[int | str, int] = field(default_factory=dict)
    subs: dict[str, int] = field(default_factory=dict)
    partner: dict[int, int] = field(default_factory=dict)
    next_branch: dict[int, int] = field(default_factory=dict)
    loop_of: dict[int, int] = field(default_factory=dict)

    def span(self, line: int) -> tuple[int, int]:
        """Return first line and end of the program that holds a line."""
        starts = sorted(self.programs.values())
        before = [start for start in starts if start <= line]
        after = [start for start in starts if start > line]
        return (before[-1] if before else 0), (after[0] if after else self.end)


def read_structure(lines: Lines, first: int, opened: bool, o_words: bool) -> Structure:
    """Find everything that may be jumped to, and check that blocks open and close each other.

    Args:
        lines: the text.
        first: index of the first line that runs.
        opened: the next % ends the text.
        o_words: the dialect has o-words.

    Raises:
        StructureError: they do not.
    """
    structure = Structure(len(lines))
    if opened:
        structure.end = _closing_percent(lines, first)
    loops: list[tuple[str, int]] = []
    opens: list[tuple[str, str, int]] = []
    for index in _candidates(lines, first, structure.end):
        text = compact(lines[index])
        text = HEAD.sub("", text, count=1)
        if o_words and (match := O_WORD.match(text)):
            label = str(int(match[1])) if match[1] else match[2]
            keyword = "ELSEIF" if match[3] == "ELSE" and "ELSEIF" in text else match[3]
            _o_word(structure, opens, keyword, label, index)
        elif match := PROGRAM.match(text) or (None if o_words else NAMED.fullmatch(text)):
            _unclosed(loops)
            number = int(match[1]) if match[1].isdigit() else match[1]
            if structure.programs.setdefault(number, index) != index:
                structure.twice.setdefault(number, index)
        elif match := LOOP.match(text):
            _loop(structure, loops, match, index)
    _unclosed(loops)
    if opens:
        keyword, label, line = opens[-1]
        raise StructureError(line, f"O{label} {keyword} without {OPENERS[keyword]}")
    return structure


def _closing_percent(lines: Lines, first: int) -> int:
    place = int(lines.bounds[first])
    while (place := lines.data.find(b"%", place)) >= 0:
        index = lines.line_at(place)
        if is_percent(lines[index]):
            return index
        place = int(lines.bounds[index + 1])
    return len(lines)


def _candidates(lines: Lines, first: int, end: int) -> Iterator[int]:
    """Yield the lines that hold a letter of O-words, program numbers and loops, in order."""
    marks = (b"O", b"o", b"D", b"d", b":", b"<")
    table = np.zeros(256, bool)
    table[list(b"".join(marks))] = True
    begin, stop = int(lines.bounds[first]), int(lines.bounds[end])
    last = -1
    for chunk in range(begin, stop, SEARCHED):
        text = lines.data[chunk : min(chunk + SEARCHED, stop)]
        # Most pieces of a long program hold none of them, and one letter is found fast.
        if not any(mark in text for mark in marks):
            continue
        places = np.flatnonzero(table[np.frombuffer(text, np.uint8)]) + chunk
        for index in np.unique(np.searchsorted(lines.bounds, places, side="right") - 1).tolist():
            if index != last:
                yield index
            last = index


def _loop(
    structure: Structure, loops: list[tuple[str, int]], match: re.Match[str], index: int
) -> None:
    """Take in DO or END."""
    if match[1]:
        if match[1] not in ("1", "2", "3"):
            raise StructureError(index, f"DO{match[1]}: there are DO1, DO2 and DO3")
        if any(number == match[1] for number, _ in loops):
            raise StructureError(index, f"DO{match[1]} inside DO{match[1]}")
        loops.append((match[1], index))
    elif not loops or loops[-1][0] != match[2]:
        raise StructureError(index, f"END{match[2]} without DO{match[2]}")
    else:
        _pair(structure, loops.pop()[1], index)


def _unclosed(loops: list[tuple[str, int]]) -> None:
    if loops:
        number, line = loops[-1]
        raise StructureError(line, f"DO{number} without END{number}")


def _pair(structure: Structure, opening: int, closing: int) -> None:
    structure.partner[opening] = closing
    structure.partner[closing] = opening


def _o_word(
    structure: Structure, opens: list[tuple[str, str, int]], keyword: str, label: str, index: int
) -> None:
    """Take in an O-word."""
    top = opens[-1] if opens else ("", "", -1)
    if keyword == "WHILE" and top[:2] == ("DO", label):
        _pair(structure, opens.pop()[2], index)
    elif keyword in OPENERS:
        if keyword == "SUB":
            structure.subs.setdefault(label, index)
        opens.append((keyword, label, index))
    elif keyword in BRANCHES:
        if top[1] != label or top[0] != "IF":
            raise StructureError(index, f"O{label} {keyword} without IF")
        _branch(structure, top[2], index)
    elif keyword in OPENERS.values():
        if top[1] != label or OPENERS[top[0]] != keyword:
            raise StructureError(index, f"O{label} {keyword} closes nothing")
        if keyword == "ENDIF":
            _branch(structure, top[2], index)
        _pair(structure, opens.pop()[2], index)
    elif keyword in ("BREAK", "CONTINUE"):
        loop = next(
            (o for o in reversed(opens) if o[1] == label and o[0] not in ("SUB", "IF")), None
        )
        if loop is None:
            raise StructureError(index, f"O{label} {keyword} outside its loop")
        structure.loop_of[index] = loop[2]


def _branch(structure: Structure, opening: int, index: int) -> None:
    """Hang a branch after the last one of its IF."""
    while opening in structure.next_branch:
        opening = structure.next_branch[opening]
    structure.next_branch[opening] = index


def returns(lines: Lines, first: int, end: int) -> bool:
    """Tell whether lines first to end (excluded) are a subprogram: they return, and never end."""
    found = {
        match[1]
        for place in RETURN_OR_END.finditer(
            lines.data, int(lines.bounds[first]), int(lines.bounds[end])
        )
        for match in CODE_AT_END.finditer(compact(lines[lines.line_at(place.start())]))
    }
    return found == {"99"}


def block_numbers(lines: Lines) -> dict[int, list[int]]:
    """Return N-number -> lines that carry it."""
    found: dict[int, list[int]] = {}
    for match in BLOCK_NUMBER.finditer(lines.data):
        found.setdefault(int(match[1]), []).append(lines.line_at(match.start(1)))
    return found

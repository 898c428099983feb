"""Reads LinuxCNC tool tables: lines like ``T1 P1 Z50 D10 ;comment``, in the unit of the machine."""

from __future__ import annotations

import re
from pathlib import Path

from gcodesim.errors import ModelError
from gcodesim.machine.formats.libraries.library import Library, ToolData

_WORD = re.compile(r"([A-Z])\s*([-+]?(?:\d+(?:\.\d*)?|\.\d+))\s*", re.IGNORECASE)
_LETTERS = "TPXYZABCUVWDIJQ"


def read_tool_tbl(path: Path, text: str, scale: float = 1.0) -> Library:
    """A tool table as the data of a tools file.

    It gives length and diameter only: the flute is a cylinder, and the holder stays unchecked.

    Args:
        path: of the file, for errors.
        text: what it holds.
        scale: millimetres in its unit, which it does not tell.

    Raises:
        ModelError: a line is wrong, or gives a tool a second time.
    """
    library = Library(path, "LinuxCNC tool table")
    for number, line in enumerate(text.splitlines(), start=1):
        words, _, comment = line.partition(";")
        if words.strip():
            library.add(_row(words.strip(), comment.strip(), scale, path, number), number)
    if library.tools:
        library.remarks.append("shapes: a tool is a cylinder of its length, without holder")
        library.remarks.append("pockets, U V W, and angles of turning tools")
    return library


def _row(row: str, comment: str, scale: float, path: Path, line: int) -> ToolData:
    """One line of a tool table."""
    words = {letter.upper(): float(value) for letter, value in _WORD.findall(row)}
    unread = _WORD.sub("", row)
    unknown = unread or "".join(sorted(set(words) - set(_LETTERS)))
    if unknown:
        text = f"cannot read {unknown!r}: write words like T1 P1 Z50 D10 ;comment"
        raise ModelError(text, str(path), line)
    number = words.get("T", -1.0)
    if number < 0 or not number.is_integer():
        raise ModelError("a line needs a tool number: T1 P1 Z50 D10 ;comment", str(path), line)
    words |= {letter: words[letter] * scale for letter in "XYZD" if letter in words}
    length, diameter = words.get("Z", 0.0), abs(words.get("D", 0.0))
    offset = {letter: words[letter] for letter in "XYABC" if words.get(letter)}
    offset |= {"Z": length} if length < 0.0 else {}
    shaped = length > 0.0 and diameter > 0.0
    return {
        "number": int(number),
        "name": comment or None,
        "length": max(length, 0.0),
        "offset": offset,
        "diameter": None if shaped else diameter or None,
        "flute": {"diameter": diameter, "length": length} if shaped else None,
    }

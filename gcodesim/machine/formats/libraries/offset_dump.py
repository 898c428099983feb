"""Reads exports of controls: G10 blocks (Fanuc, Haas) and tool data of Siemens, lengths only."""

from __future__ import annotations

import math
import re
from pathlib import Path

from gcodesim.constants import LARGEST_NUMBER
from gcodesim.errors import ModelError
from gcodesim.machine.formats.libraries.library import Library, ToolData

_G10 = re.compile(
    r"^\s*(?:N\d+\s*)?(?:G90\s*)?G10\s*L(\d{1,9})\s*((?:[A-Z]\s*[-+]?[\d.]+\s*)+)", re.I
)
_WORD = re.compile(r"([A-Z])\s*([-+]?(?:\d+(?:\.\d*)?|\.\d+))", re.I)
_COMMENT = re.compile(r"\(([^)]*)\)")
_SIEMENS = re.compile(
    r"^\s*(?:N\d+\s*)?\$TC_(DP|TP)(\d{1,9})\[(\d{1,9})(?:,\s*(\d{1,9}))?\]\s*=\s*(.+?)\s*$"
)
_FRAME = re.compile(r"\$P_UIFR\[(\d{1,9})\]\s*=\s*(.*)")
_TRANSLATION = re.compile(r"C(?:TRANS|FINE)\(([^)]*)\)")

SIEMENS_TYPES = {
    range(110, 112): "ball", range(140, 141): "face", range(200, 210): "drill",
    range(220, 221): "drill", range(230, 232): "countersink", range(240, 243): "tap",
}  # fmt: skip
"""$TC_DP1 -> type of ours; left out: a mill."""

MILLS_AND_DRILLS = range(100, 300)
SHARP_POINT = "without the angle of its point: a flat end is assumed"


def is_dump(text: str) -> bool:
    """Whether a text holds G10 blocks or tool data of Siemens."""
    return any(_G10.match(line) or _SIEMENS.match(line) for line in text.splitlines())


def read_dump(path: Path, text: str) -> Library:
    """An export of a control as the data of a tools file: lengths, and shapes where it has some.

    Raises:
        ModelError: a number cannot be read.
    """
    siemens = "$TC_" in text or "$P_UIFR" in text
    library = Library(path, "tool data of Siemens" if siemens else "offset dump of G10 blocks")
    if siemens:
        _read_siemens(library, text)
    else:
        _read_g10(library, text)
    return library


def _read_g10(library: Library, text: str) -> None:
    lengths: dict[int, float] = {}
    places: dict[int, tuple[int, str]] = {}
    scale, others = 1.0, set()
    for number, line in enumerate(text.splitlines(), start=1):
        bare = _COMMENT.sub("", line)
        scale = (
            25.4 if re.search(r"\bG20\b", bare) else 1.0 if re.search(r"\bG21\b", bare) else scale
        )
        block = _G10.match(bare)
        if block is None:
            continue
        kind, words = int(block[1]), {k.upper(): float(v) for k, v in _WORD.findall(block[2])}
        register = words.get("P", -1.0)
        if register < 0.0 or not register.is_integer():
            raise ModelError("G10 needs a P, a whole number", str(library.path), number)
        if kind in (2, 20):
            _work_offset(library, kind, int(register), words, scale)
        elif kind in (10, 11) and "R" in words:
            lengths[int(register)] = lengths.get(int(register), 0.0) + words["R"] * scale
            said = " ".join(_COMMENT.findall(line)).strip()
            places.setdefault(int(register), (number, said))
        else:
            others.add(kind)
    for register, length in lengths.items():
        line_number, comment = places[register]
        library.add(_length_row(register, comment, length), line_number)
    if others & {12, 13}:
        text = "L12 and L13: a parameter of the control says whether D is a radius or a diameter"
        library.remarks.append(text)
    library.remarks += [f"G10 L{kind}" for kind in sorted(others - {12, 13})]
    library.remarks.append("shapes: add `flute`, `shank` and `holder` to every tool")


def _length_row(register: int, name: str, length: float) -> ToolData:
    """A tool of which only the length is known."""
    offset = {"Z": length} if length < 0.0 else {}
    row: ToolData = {"number": register, "name": name or None, "length": max(length, 0.0)}
    return row | {"offset": offset}


def _work_offset(
    library: Library, kind: int, register: int, words: dict[str, float], scale: float
) -> None:
    """Note a work offset: L2 P1 is G54, L20 P1 is G54.1 P1."""
    if kind == 2 and not 1 <= register <= 6:
        library.remarks.append(f"G10 L2 P{register}: a shift of all work offsets")
        return
    name = f"G{53 + register}" if kind == 2 else f"G54.1 P{register}"
    values = {k: words[k] * (1.0 if k in "ABC" else scale) for k in "XYZABC" if k in words}
    library.offsets[name] = values


def _read_siemens(library: Library, text: str) -> None:
    edges: dict[tuple[int, int], dict[int, float]] = {}
    names: dict[int, str] = {}
    lines: dict[int, int] = {}
    for number, line in enumerate(text.splitlines(), start=1):
        if frame := _FRAME.search(line):
            _frame(library, int(frame[1]), frame[2], number)
        found = _SIEMENS.match(line.partition(";")[0])
        if found is None:
            continue
        family, index, tool, value = found[1], int(found[2]), int(found[3]), found[5]
        lines.setdefault(tool, number)
        if family == "TP" and index == 2:
            names[tool] = value.strip('"')
        elif family == "DP":
            data = edges.setdefault((tool, int(found[4] or 1)), {})
            data[index] = _number(library, f"$TC_DP{index}", value, number)
    for (tool, edge), data in edges.items():
        if edge == 1:
            _add_edge(library, tool, names.get(tool, ""), data, lines[tool])
        else:
            library.remarks.append(f"T{tool}: edge D{edge}")
    library.remarks.append("holders; a flute is as long as its tool, for the data do not say it")


def _add_edge(library: Library, tool: int, name: str, data: dict[int, float], line: int) -> None:
    """Take in the first edge: length 1 with wear and adapter, radius with wear, corner."""
    length = data.get(3, 0.0) + data.get(12, 0.0) + data.get(21, 0.0)
    radius = data.get(6, 0.0) + data.get(15, 0.0)
    entry, kind = _length_row(tool, name, length), int(data.get(1, 0.0))
    if kind not in MILLS_AND_DRILLS or length <= 0.0 or radius <= 0.0:
        library.remark(entry, f"type {kind} without length and radius of a mill: it has no shape")
    else:
        named = next((t for kinds, t in SIEMENS_TYPES.items() if kind in kinds), "mill")
        if named in ("drill", "countersink"):
            library.remark(entry, SHARP_POINT)
            named = "mill"
        corner = data.get(7, 0.0) if named in ("mill", "face") else 0.0
        flute: ToolData = {"diameter": 2.0 * radius, "length": length}
        flute |= {"corner_radius": corner} if corner > 0.0 else {}
        if named == "tap":
            flute["inscribed"] = [[radius / 2.0, 0.0], [radius / 2.0, length]]
        entry |= {"type": named, "flute": flute}
    library.add(entry, line)


def _number(library: Library, name: str, text: str, line: int) -> float:
    """A finite number; ModelError where the text is none."""
    try:
        value = float(text)
    except ValueError:
        value = math.inf
    if abs(value) <= LARGEST_NUMBER:
        return value
    raise ModelError(f"{name}: expected a number, not {text[:40]!r}", str(library.path), line)


def _frame(library: Library, number: int, text: str, line: int) -> None:
    """Note a settable frame: $P_UIFR[1] is G54; turns are not carried over."""
    values: dict[str, float] = {}
    for words in _TRANSLATION.findall(text):
        parts = [part.strip() for part in words.split(",")]
        for letter, value in zip(parts[::2], parts[1::2], strict=False):
            values[letter] = values.get(letter, 0.0) + _number(library, "$P_UIFR", value, line)
    name = f"G{53 + number}" if number <= 4 else f"G{500 + number}"
    if "CROT" in text and re.search(r"CROT\([^)]*[1-9]", text):
        library.remarks.append(f"{name}: its turn (CROT)")
    library.offsets[name] = {k: v for k, v in values.items() if k in "XYZABC"}

"""Reads Heidenhain tool tables (TOOL.T): columns whose places the header line gives."""

from __future__ import annotations

import re
from pathlib import Path

from gcodesim.errors import ModelError
from gcodesim.machine.formats.libraries.library import Library, ToolData

TYPES = {
    "1": "drill", "DRILL": "drill", "2": "tap", "TAP": "tap", "3": "reamer", "REAM": "reamer",
    "4": "drill", "CENT": "drill", "5": "countersink", "CSINK": "countersink", "7": "boring",
    "BOR": "boring", "14": "face", "MILL_FACE": "face", "15": "thread", "GF": "thread",
    "21": "probe", "TCHP": "probe", "TCHPROBE": "probe", "22": "ball", "BALL": "ball",
}  # fmt: skip
"""Column TYP -> type of ours; left out: a mill."""

TURNING = {"29", "TURN"}
MM_PER = {"MM": 1.0, "INCH": 25.4}


def read_tool_t(path: Path, text: str) -> Library:
    """A tool table of a Heidenhain control as the data of a tools file.

    Raises:
        ModelError: the table has no header, or a row holds no numbers.
    """
    library = Library(path, "Heidenhain tool table")
    lines = text.splitlines()
    begin = re.match(r"\s*BEGIN\s+\S+\s+(MM|INCH)\b", lines[0] if lines else "", re.IGNORECASE)
    if begin is None:
        raise ModelError("expected BEGIN TOOL.T MM, or INCH, in the first line", str(path), 1)
    columns = _columns(lines[1] if len(lines) > 1 else "")
    missing = {"T", "L", "R"} - columns.keys()
    if missing:
        text = f"the header has no column {', '.join(sorted(missing))}: expected T NAME L R R2 ..."
        raise ModelError(text, str(path), 2)
    empty = 0
    for number, line in enumerate(lines[2:], start=3):
        if line.strip().upper().startswith("[END]"):
            break
        cells = {name: line[start:end].strip() for name, (start, end) in columns.items()}
        if any(cells.values()):
            empty += not _add(library, cells, MM_PER[begin[1].upper()], number)
    if empty:
        library.remarks.append(f"{empty} rows without length and radius, or for index tools")
    library.remarks.append("holders, necks, life, breakage and the columns of cutting data")
    return library


def _columns(header: str) -> dict[str, tuple[int, int]]:
    """Name of every column -> where it begins and ends in a line."""
    found = [(match[0], match.start()) for match in re.finditer(r"\S+", header)]
    ends = [start for _, start in found[1:]] + [10_000]
    return {name: (start, end) for (name, start), end in zip(found, ends, strict=False)}


def _add(library: Library, cells: dict[str, str], scale: float, line: int) -> bool:
    """Take in a row; whether it holds a tool."""

    def number(name: str, unit: float = scale) -> float:
        text = cells.get(name, "").replace(",", ".")
        try:
            return float(text) * unit if text else 0.0
        except ValueError:
            message = f"column {name}: expected a number, not {text!r}"
            raise ModelError(message, str(library.path), line) from None

    tool = number("T", 1.0)
    length, radius = number("L") + number("DL"), number("R") + number("DR")
    if tool < 0.0 or not tool.is_integer() or (length == 0.0 and radius == 0.0):
        return False
    kind = "turning" if cells.get("TYP") in TURNING else TYPES.get(cells.get("TYP", ""), "mill")
    entry: ToolData = {"number": int(tool), "name": cells.get("NAME") or None}
    entry["length"] = max(length, 0.0)
    entry["offset"] = {"Z": length} if length < 0.0 else {}
    if kind == "turning" or length <= 0.0 or radius <= 0.0:
        entry["diameter"] = 2.0 * radius if radius > 0.0 and kind != "turning" else None
        library.remark(entry, "it has no shape")
    else:
        corner = number("R2") + number("DR2")
        flute = _flute(kind, 2.0 * radius, min(number("LCUTS") or length, length), corner)
        angle = number("T-ANGLE", 1.0)
        if flute.pop("pointed", False):
            kind = "drill" if 0.0 < angle < 180.0 else "mill"
            flute |= {"point_angle": angle} if kind == "drill" else {}
        entry |= {"type": kind, "flute": flute}
    library.add(entry, line)
    return True


def _flute(kind: str, diameter: float, length: float, corner: float) -> ToolData:
    """A flute; of taps and thread mills half of the diameter surely cuts."""
    flute: ToolData = {"diameter": diameter, "length": length}
    if kind == "probe":
        return flute | {"length": diameter}
    if kind in ("drill", "countersink"):
        return flute | {"pointed": True}
    if kind in ("tap", "thread"):
        return flute | {"inscribed": [[diameter / 4.0, 0.0], [diameter / 4.0, length]]}
    return flute | ({"corner_radius": corner} if corner > 0.0 and kind in ("mill", "face") else {})

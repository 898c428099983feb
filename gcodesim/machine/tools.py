"""Tools: reads a tools file or a LinuxCNC tool table, and mounts tools at the gauge point."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

from gcodesim.constants import TOUCHING_MM
from gcodesim.errors import ModelError, UsageError
from gcodesim.input_file import read_text
from gcodesim.machine import shapes
from gcodesim.machine.bodies import PartReader
from gcodesim.machine.kinematics import rotation_from_z
from gcodesim.machine.model import Part, Tool, ToolMount
from gcodesim.machine.schema import FluteSpec, ToolsFile, ToolSpec, TurnedSpec
from gcodesim.machine.yaml_lines import read_yaml

_WORD = re.compile(r"([A-Z])\s*([-+]?(?:\d+(?:\.\d*)?|\.\d+))\s*", re.IGNORECASE)
_TABLE_LETTERS = "TPXYZABCUVWDIJQ"


def read_tools(path: str, *, allow_outside: bool = False) -> dict[int, Tool]:
    """Tools by number, from a tools file (.yaml, .yml) or a LinuxCNC tool table (.tbl).

    Raises:
        UsageError: the file is missing.
        ModelError: it is wrong; names file, line and key.
    """
    if Path(path).suffix.lower() == ".tbl":
        return read_tool_table(Path(path))
    source = read_yaml(Path(path))
    file = source.parse(ToolsFile)
    reader = PartReader(source, file.units, allow_outside)
    tools: dict[int, Tool] = {}
    for i, entry in enumerate(file.tools):
        if entry.number in tools:
            raise source.error(f"tool {entry.number} is given twice", "tools", i, "number")
        tools[entry.number] = _tool(entry, reader, i)
    return tools


def _tool(entry: ToolSpec, reader: PartReader, index: int) -> Tool:
    parts: list[Part] = []
    if entry.flute is not None:
        parts.append(_flute(entry.flute, entry.length, reader, index))
    for role, turned in (("shank", entry.shank), ("holder", entry.holder)):
        if turned is not None:
            parts.append(_turned(turned, role, reader, index))
    return Tool(
        number=entry.number,
        name=entry.name,
        length=entry.length,
        diameter=(entry.flute and entry.flute.diameter) or 0.0,
        offset=(0.0, 0.0, entry.length, 0.0, 0.0, 0.0),
        parts=tuple(parts),
        unchecked=_missing_parts(parts),
    )


def _flute(flute: FluteSpec, length: float, reader: PartReader, index: int) -> Part:
    """The cutting part, its tip at (0, 0, -length)."""
    key = ("tools", index, "flute")
    if flute.mesh is not None:
        return reader.mesh(flute, "flute", "flute", *key)
    diameter, height = flute.diameter or 0.0, flute.length or 0.0  # the schema requires both
    try:
        profile = shapes.cutter_profile(diameter, height, flute.corner_radius, flute.taper)
        triangles = shapes.revolve([(r, z - length) for r, z in profile])
    except ValueError as error:
        raise reader.source.error(str(error), *key) from None
    return Part("flute", triangles, True, "flute", f"revolve, {shapes.SIDES} sides")


def _turned(turned: TurnedSpec, role: str, reader: PartReader, index: int) -> Part:
    """A shank or holder; the file measures z from the gauge face towards the tip."""
    key = ("tools", index, role)
    if turned.mesh is not None:
        return reader.mesh(turned, role, role, *key)
    try:
        triangles = shapes.revolve([(r, -z) for r, z in turned.profile or []])
    except ValueError as error:
        raise reader.source.error(str(error), *key) from None
    return Part(role, triangles, True, role, f"revolve, {shapes.SIDES} sides")


def _missing_parts(parts: list[Part]) -> tuple[str, ...]:
    """Names of the parts without a shape; a shank counts only where the tool has a gap for it."""
    by_name = {part.name: part.triangles[..., 2] for part in parts}
    if not by_name:
        return ()
    missing = [name for name in ("flute", "holder") if name not in by_name]
    if "shank" not in by_name and not missing:
        gap = float(by_name["holder"].min() - by_name["flute"].max())
        missing += ["shank"] if gap > TOUCHING_MM else []
    return tuple(missing)


def read_tool_table(path: Path) -> dict[int, Tool]:
    """A LinuxCNC tool table in millimetres: ``T1 P1 Z50 D10 ;comment``.

    It gives length and diameter only: the flute is a cylinder, and the holder stays unchecked.
    """
    try:
        text = read_text(path)
    except OSError as error:
        raise UsageError(f"{path}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise ModelError(f"not UTF-8 text: byte {error.start}", str(path)) from error
    tools: dict[int, Tool] = {}
    for number, line in enumerate(text.splitlines(), start=1):
        words, _, comment = line.partition(";")
        if words.strip():
            tool = _table_row(words.strip(), comment.strip(), path, number)
            if tool.number in tools:
                raise ModelError(f"tool {tool.number} is given twice", str(path), number)
            tools[tool.number] = tool
    return tools


def _table_row(row: str, comment: str, path: Path, line: int) -> Tool:
    """One line of a tool table."""
    words = {letter.upper(): float(value) for letter, value in _WORD.findall(row)}
    unread = _WORD.sub("", row)
    unknown = unread or "".join(sorted(set(words) - set(_TABLE_LETTERS)))
    if unknown:
        text = f"cannot read {unknown!r}: write words like T1 P1 Z50 D10 ;comment"
        raise ModelError(text, str(path), line)
    number = words.get("T", -1.0)
    if number < 0 or number != int(number):
        raise ModelError("a line needs a tool number: T1 P1 Z50 D10 ;comment", str(path), line)
    x, y, z, a, b, c = (words.get(letter, 0.0) for letter in "XYZABC")
    diameter = abs(words.get("D", 0.0))
    parts: tuple[Part, ...] = ()
    if z > 0.0 and diameter > 0.0:
        triangles = shapes.revolve([(diameter / 2.0, -z), (diameter / 2.0, 0.0)])
        source = f"tool table, {shapes.SIDES} sides"
        parts = (Part("flute", triangles, True, "flute", source),)
    unchecked = ("holder",) if parts else ()
    return Tool(int(number), comment, z, diameter, (x, y, z, a, b, c), parts, unchecked)


def mount(parts: tuple[Part, ...], tool: ToolMount) -> tuple[Part, ...]:
    """Tool parts put into the spindle: world coordinates at the zero pose of the machine."""
    turn = rotation_from_z(tool.axis)
    return tuple(
        replace(part, triangles=shapes.place(part.triangles, turn, tool.gauge_point))
        for part in parts
    )

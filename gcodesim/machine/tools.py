"""Tools: makes them of a tools file or a foreign library, and mounts them at the gauge point."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from gcodesim.constants import TOUCHING_MM
from gcodesim.machine import shapes
from gcodesim.machine.bodies import PartReader
from gcodesim.machine.cutters import cutter
from gcodesim.machine.kinematics import rotation_from_z
from gcodesim.machine.model import Part, Tool, ToolMount, Turned
from gcodesim.machine.tool_files import read_tool_source
from gcodesim.machine.tool_schema import FluteSpec, ToolsFile, ToolSpec, TurnedSpec


def read_tools(path: str, *, allow_outside: bool = False) -> dict[int, Tool]:
    """Tools by number, from a tools file or a library of another program or control.

    Raises:
        UsageError: the file is missing.
        ModelError: it is wrong; names file, line and key.
    """
    source = read_tool_source(Path(path))
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
    flute = None
    if entry.flute is not None:
        flute = _flute(entry.type, entry.flute, entry.length, reader, index)
        parts.append(flute)
    for role, turned in (("shank", entry.shank), ("holder", entry.holder)):
        if turned is not None:
            parts.append(_turned(turned, role, reader, index))
    offset = entry.offset
    length = entry.length if offset.Z is None else offset.Z
    return Tool(
        number=entry.number,
        name=entry.name,
        length=length if entry.length == 0.0 else entry.length,
        diameter=entry.diameter or _diameter(entry.flute),
        offset=(offset.X, offset.Y, length, offset.A, offset.B, offset.C),
        parts=tuple(parts),
        unchecked=_missing_parts(parts),
        type=entry.type,
    )


def _diameter(flute: FluteSpec | None) -> float:
    """The cutting diameter [mm], 0 where it is not known."""
    if flute is None:
        return 0.0
    return flute.diameter or 2.0 * max((r for r, _ in flute.profile or []), default=0.0)


def _flute(kind: str, flute: FluteSpec, length: float, reader: PartReader, index: int) -> Part:
    """The cutting part, its tip at (0, 0, -length)."""
    key = ("tools", index, "flute")
    if flute.mesh is not None:
        return reader.mesh(flute, "flute", "flute", *key)
    try:
        return _revolved("flute", cutter(kind, flute).moved(-length))
    except ValueError as error:
        raise reader.source.error(str(error), *key) from None


def _turned(turned: TurnedSpec, role: str, reader: PartReader, index: int) -> Part:
    """A shank or holder; the file measures z from the gauge face towards the tip."""
    key = ("tools", index, role)
    if turned.mesh is not None:
        return reader.mesh(turned, role, role, *key)
    points = tuple((r, 0.0 - z) for r, z in turned.profile or [])
    upwards = points if points[0][1] <= points[-1][1] else points[::-1]
    try:
        return _revolved(role, Turned(upwards, upwards))
    except ValueError as error:
        raise reader.source.error(str(error), *key) from None


def _revolved(role: str, turned: Turned) -> Part:
    triangles = shapes.revolve(turned.outer)
    return Part(role, triangles, True, role, f"revolve, {shapes.SIDES} sides", turned=turned)


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


def mount(parts: tuple[Part, ...], tool: ToolMount) -> tuple[Part, ...]:
    """Tool parts put into the spindle: world coordinates at the zero pose of the machine."""
    turn = rotation_from_z(tool.axis)
    return tuple(
        replace(part, triangles=shapes.place(part.triangles, turn, tool.gauge_point))
        for part in parts
    )

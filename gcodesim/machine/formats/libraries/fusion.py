"""Reads tool libraries of Autodesk Fusion: JSON, or a .tools file, which is a zip of it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

from gcodesim.machine.formats.libraries.fusion_flutes import FLUTES, SAME_MM, FusionTool
from gcodesim.machine.formats.libraries.json_items import JsonItem, items_of
from gcodesim.machine.formats.libraries.library import Library, ToolData

MM_PER = {"millimeters": 1.0, "inches": 25.4}
NO_MILLING = ("turning", "waterjet", "laser", "plasma", "wire", "depos", "block", "holder")
"""How types begin that no spindle of a milling machine turns."""

Contour = list[tuple[float, float]]

UNCARRIED = "feeds, speeds, materials, coolant, vendors and links"


def read_fusion(path: Path, whole: JsonItem) -> Library:
    """A Fusion library as the data of a tools file.

    Raises:
        ModelError: it is no such library; names file, line and key.
    """
    library = Library(path, "Fusion tool library")
    left_out: dict[str, int] = {}
    for item in items_of(whole, "data"):
        kind = item.text_at("type")
        if not kind:
            raise item.error('a tool needs its `type`, such as "flat end mill"')
        if kind.startswith(NO_MILLING):
            left_out[kind] = left_out.get(kind, 0) + 1
            continue
        tool = FusionTool(item, scale_of(item))
        number = item.number("post-process", "number")
        if not number.is_integer() or number < 0:
            raise item.error(f"expected a whole number, not {number:g}", "post-process", "number")
        _add(library, tool, int(number))
    for kind, count in left_out.items():
        library.remarks.append(f"{count} of type {kind}: no tool of a milling spindle")
    library.add_lengths()
    library.remarks.append(UNCARRIED)
    return library


def scale_of(item: JsonItem, *keys: str) -> float:
    """Mm per unit of a tool or of a section of it; a section may leave the unit to the tool."""
    unit = item.text_at(*keys, "unit") or (item.text_at("unit") if keys else "")
    if unit not in MM_PER:
        text = f"expected `unit` to be {' or '.join(MM_PER)}, not {unit!r}"
        raise item.error(text, *keys, "unit")
    return MM_PER[unit]


def _add(library: Library, tool: FusionTool, number: int) -> None:
    """Take in one tool with all that its numbers say."""
    item = tool.item
    name = item.text_at("description") or item.text_at("product-id") or tool.kind
    entry: ToolData = {"number": number, "name": name}
    make = FLUTES.get(tool.kind)
    kind, flute, note = make(tool) if make else ("mill", None, f"type {tool.kind!r} is not known")
    body = tool.mm("LB")
    gauge = item.number("holder", "gaugeLength") * _holder_scale(item)
    length = tool.mm("assemblyGaugeLength") or body + gauge
    entry |= {"type": kind, "length": length}
    if note:
        library.remark(entry, note)
    if body <= 0.0 or length <= 0.0:
        library.remark(entry, "no length below the holder (LB): it has no shape")
        entry["length"] = 0.0
    else:
        if gauge and abs(body + gauge - length) > 10.0 * SAME_MM:
            text = f"assemblyGaugeLength {length:g} mm is not LB and holder, {body + gauge:g} mm"
            library.remark(entry, f"{text}: the first is taken as its length")
        entry["flute"] = flute
        # A flute that reaches into the holder leaves no shank to be seen.
        top = flute.get("length", 0.0) if flute else 0.0
        entry["shank"] = _hanging(_shank(tool, top, body), length) if flute else None
        holder = _hanging(_holder(item, body), length)
        entry["holder"] = holder
        if not holder:
            library.remark(entry, "no holder: what is above the shank is not checked")
    register = item.number("post-process", "length-offset")
    entry["length_register"] = int(register) or number
    library.add(entry, item.line, once=True)


def _holder_scale(item: JsonItem) -> float:
    return scale_of(item, "holder") if item.section("holder") else 1.0


def _shank(tool: FusionTool, top: float, body: float) -> Contour:
    """Points (r, h above the tip) from the top of the flute to the holder."""
    if top >= body:
        return []
    shoulder = min(max(tool.mm("shoulder-length"), top), body)
    neck = tool.neck / 2.0 if tool.mm("shoulder-diameter") else tool.mm("DC") / 2.0
    points: Contour = [(neck, top), (neck, shoulder)] if shoulder > top else []
    segments = list(_segments(tool.item, "shaft", shoulder, tool.scale))
    points += segments
    above = segments[-1][1] if segments else shoulder
    radius = (tool.mm("SFDM") or tool.neck) / 2.0
    points += [(radius, above), (radius, body)] if above < body else []
    return _below(points, body)


def _holder(item: JsonItem, body: float) -> Contour:
    """Points (r, h above the tip) of the holder, from its lower end."""
    if not item.section("holder"):
        return []
    return list(_segments(item, "holder", body, scale_of(item, "holder")))


def _segments(
    item: JsonItem, section: str, height: float, scale: float
) -> Iterator[tuple[float, float]]:
    """Yield the points of cones that stand on each other, the first one at a height [mm]."""
    for segment in item.objects(section, "segments"):
        numbers = [segment.get(key, 0.0) for key in ("lower-diameter", "upper-diameter", "height")]
        if not all(isinstance(n, int | float) and 0.0 <= n < math.inf for n in numbers):
            text = "a segment needs height, lower-diameter and upper-diameter, numbers from 0"
            raise item.error(text, section, "segments")
        lower, upper, rise = (n * scale for n in numbers)
        if rise > 0.0:
            yield lower / 2.0, height
            yield upper / 2.0, height + rise
            height += rise


def _below(points: Contour, limit: float) -> Contour:
    """The points up to a height, cut there."""
    kept: Contour = []
    for i, (r, h) in enumerate(points):
        if h <= limit:
            kept.append((r, h))
        elif kept and kept[-1][1] < limit:
            r0, h0 = points[i - 1]
            kept.append((r0 + (r - r0) * (limit - h0) / (h - h0), limit))
    return kept if len(kept) > 1 and kept[-1][1] > kept[0][1] else []


def _hanging(points: Contour, length: float) -> list[list[float]] | None:
    """Contour [r, z] from the gauge face down, without what is above it, inside the spindle."""
    below = _below(points, length)
    return [[r, length - h] for r, h in reversed(below)] or None

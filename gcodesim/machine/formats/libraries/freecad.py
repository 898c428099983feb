"""Reads tool bits (.fctb) and libraries (.fctl) of FreeCAD's CAM workbench."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gcodesim.errors import ModelError, UsageError
from gcodesim.input_file import read_text
from gcodesim.machine.formats.libraries.json_items import JsonItem, items_of, read_json
from gcodesim.machine.formats.libraries.library import Library, Made, ToolData

UNITS = {
    "": 1.0, "mm": 1.0, "cm": 10.0, "m": 1000.0, "um": 0.001, "µm": 0.001, "in": 25.4,
    '"': 25.4, "ft": 304.8, "'": 304.8, "deg": 1.0, "°": 1.0, "rad": 180.0 / math.pi,
}  # fmt: skip
"""Unit -> mm or deg."""

QUANTITY = re.compile(r"([-+]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][-+]?\d+)?)\s*(\D*)")
BIT_FOLDERS = ("", "../Bit", "../bit", "Bit", "bit")
"""Where the bits of a library lie, from its own folder."""

NO_GAUGE = "how far a bit stands out of its holder is not in the file: its whole Length is assumed"


@dataclass(frozen=True)
class Bit:
    """One tool bit in mm.

    Attributes:
        item: its JSON.
    """

    item: JsonItem

    @property
    def shape(self) -> str:
        """Its kind in lower case letters: endmill, ballend, vbit, ..."""
        named = self.item.text_at("shape-type") or Path(self.item.text_at("shape")).stem
        return re.sub(r"[^a-z]", "", named.lower())

    def get(self, *names: str) -> float:
        """The first of some parameters that is given [mm or deg], 0 where none is."""
        for name in names:
            value = self.item.section("parameter").get(name)
            if isinstance(value, int | float) and not isinstance(value, bool):
                return self.item.in_range(value, "parameter", name)
            if isinstance(value, str) and value.strip():
                return self._quantity(name, value.strip())
        return 0.0

    def _quantity(self, name: str, text: str) -> float:
        found = QUANTITY.fullmatch(text)
        if found is None or found[2].strip() not in UNITS:
            units = "mm, cm, m, in, deg"
            message = f"expected a number with its unit ({units}), not {text!r}"
            raise self.item.error(message, "parameter", name)
        value = float(found[1].replace(",", ".")) * UNITS[found[2].strip()]
        return self.item.in_range(value, "parameter", name)


def read_freecad(path: Path, whole: JsonItem) -> Library:
    """A library of FreeCAD, or a single bit as tool 1, as the data of a tools file.

    Raises:
        ModelError: a file is wrong, or a bit of the library is not there.
        UsageError: a bit cannot be read.
    """
    if "tools" not in whole.value:
        library = Library(path, "FreeCAD tool bit")
        library.remarks.append("a bit has no number: it is T1 here")
        _add(library, Bit(whole), 1, 1)
    else:
        library = Library(path, "FreeCAD tool library")
        for entry in items_of(whole, "tools"):
            number = entry.number("nr")
            if not number.is_integer() or number < 0:
                raise entry.error(f"expected a whole number, not {number:g}", "nr")
            _add(library, _bit(path, entry), int(number), entry.line)
    library.remarks.append(NO_GAUGE)
    library.remarks.append("holders, feeds, speeds and materials")
    return library


def bits_of(path: Path, whole: JsonItem) -> Iterator[Path]:
    """Yield the files of the bits that a library names."""
    for entry in items_of(whole, "tools"):
        found = _bit_file(path, entry)
        if found is not None:
            yield found


def _bit(path: Path, entry: JsonItem) -> Bit:
    file = _bit_file(path, entry)
    if file is None:
        name = entry.text_at("path")
        looked = ", ".join(str(path.parent / folder) for folder in BIT_FOLDERS[:2])
        raise entry.error(f"no tool bit {name!r} in {looked}: copy it there", "path")
    try:
        return Bit(read_json(file, read_text(file)))
    except OSError as error:
        raise UsageError(f"{file}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise ModelError(f"not UTF-8 text: byte {error.start}", str(file)) from error


def _bit_file(path: Path, entry: JsonItem) -> Path | None:
    name = entry.text_at("path")
    files = (path.parent / folder / name for folder in BIT_FOLDERS)
    return next((file for file in files if name and file.is_file()), None)


def _add(library: Library, bit: Bit, number: int, line: int) -> None:
    name = bit.item.text_at("name") or bit.shape
    entry: ToolData = {"number": number, "name": name}
    make = SHAPES.get(bit.shape)
    length = bit.get("Length")
    if make is None or length <= 0.0:
        why = "has no Length" if make else f"shape {bit.shape!r} is not known"
        library.add(entry | {"length": 0.0}, line)
        library.remark(entry, f"{why}: it has no shape")
        return
    kind, flute, remark = make(bit)
    if remark:
        library.remark(entry, remark)
    numbers = {k: v for k, v in (flute or {}).items() if v}
    entry |= {"type": kind, "length": length, "flute": numbers}
    entry["shank"] = _shank(bit, numbers.get("length", 0.0), length)
    library.add(entry, line)


def _shank(bit: Bit, top: float, length: float) -> list[list[float]] | None:
    """Points [r, z] from the end of the shank down to the flute: neck and shank."""
    neck, height = bit.get("NeckDiameter") / 2.0, bit.get("NeckLength", "NeckHeight")
    shank = (bit.get("ShankDiameter", "ShaftDiameter") or bit.get("Diameter")) / 2.0
    foot = min(top + height, length) if neck else top
    points = [[shank, 0.0], [shank, length - foot]] if foot < length else []
    points += [[neck, length - foot], [neck, length - top]] if foot > top else []
    return points or None


def _height(bit: Bit) -> float:
    """Height of the cutting part; a bit without one may cut along all of it."""
    return bit.get("CuttingEdgeHeight", "CuttingEdgeLength") or bit.get("Length")


def _size(bit: Bit, **numbers: Any) -> ToolData:
    return {"diameter": bit.get("Diameter"), "length": _height(bit)} | numbers


def _endmill(bit: Bit) -> Made:
    return "mill", _size(bit), ""


def _reamer(bit: Bit) -> Made:
    return "reamer", _size(bit), ""


def _ball(bit: Bit) -> Made:
    return "ball", _size(bit), ""


def _bull(bit: Bit) -> Made:
    """Older bits give the flat of the tip instead of the corner."""
    flat = bit.get("FlatRadius")
    corner = bit.get("CornerRadius") or (bit.get("Diameter") / 2.0 - flat if flat else 0.0)
    return "mill", _size(bit, corner_radius=corner), ""


def _tapered_ball(bit: Bit) -> Made:
    return "ball", _size(bit, taper=bit.get("TaperAngle") / 2.0), ""


def _pointed(kind: str) -> Callable[[Bit], Made]:
    """A cone of a full angle; the edge may reach above it, or end with it: above is assumed."""

    def make(bit: Bit) -> Made:
        angle, tip = bit.get("CuttingEdgeAngle"), bit.get("TipDiameter")
        if not 0.0 < angle < 180.0:
            return "mill", _size(bit), "no CuttingEdgeAngle: a flat end is assumed"
        cone = (bit.get("Diameter") - tip) / 2.0 / math.tan(math.radians(angle / 2.0))
        length = min(cone + _height(bit), max(bit.get("Length"), cone))
        return kind, _size(bit, length=length, point_angle=angle, tip_diameter=tip), ""

    return make


def _drill(bit: Bit) -> Made:
    angle = bit.get("TipAngle")
    if not 0.0 < angle < 180.0:
        return "mill", _size(bit), "no TipAngle: a flat end is assumed"
    return "drill", _size(bit, point_angle=angle), ""


def _tap(bit: Bit) -> Made:
    flute = _size(bit, pitch=bit.get("Pitch"))
    if not flute["pitch"]:
        flute["inscribed"] = _cylinder(bit.get("Diameter") / 2.0, flute["length"])
    return "tap", flute, ""


def _thread(bit: Bit) -> Made:
    """One tooth: its height follows from its angle and the neck."""
    neck, crest = bit.get("NeckDiameter"), bit.get("Crest")
    angle = bit.get("cuttingAngle", "CuttingAngle") or 60.0
    depth = max(bit.get("Diameter") - neck, 0.0) / 2.0
    height = crest + 2.0 * depth * math.tan(math.radians(angle / 2.0))
    flute = _size(bit, length=height)
    flute["inscribed"] = _cylinder(neck, height) if neck else None
    return "thread", flute, ""


def _dovetail(bit: Bit) -> Made:
    flute = _size(bit)
    radius, neck = bit.get("Diameter") / 2.0, bit.get("NeckDiameter") / 2.0
    flute["inscribed"] = [[radius, 0.0], [neck, flute["length"]]] if 0.0 < neck < radius else None
    return (
        "mill",
        flute,
        "a dovetail, whose side is not followed: the cylinder around it is checked",
    )


def _saw(bit: Bit) -> Made:
    """A blade above the head of its screw."""
    cap, height = bit.get("CapDiameter") / 2.0, bit.get("CapHeight")
    blade, top = bit.get("Diameter") / 2.0, height + bit.get("BladeThickness")
    screw = [[cap, 0.0], [cap, height]] if cap and height else []
    return "form", {"length": top, "profile": [*screw, [blade, height], [blade, top]]}, ""


def _radius(bit: Bit) -> Made:
    """A corner rounding bit; whether Diameter is that of its tip is not sure."""
    widest = bit.get("Diameter") + 2.0 * bit.get("CuttingRadius")
    flute = _size(bit, diameter=widest)
    flute["inscribed"] = _cylinder(max(bit.get("Diameter") - 2.0 * bit.get("CuttingRadius"), 0.1),
                                   flute["length"])  # fmt: skip
    return "mill", flute, "its hollow corner is not followed: the cylinder around it is checked"


def _probe(bit: Bit) -> Made:
    radius = bit.get("Diameter") / 2.0
    neck = min(bit.get("ShaftDiameter", "ShankDiameter") / 2.0, 0.999 * radius)
    length = radius + math.sqrt(max(radius * radius - neck * neck, 0.0))
    return "probe", {"diameter": 2.0 * radius, "length": length}, ""


def _cylinder(diameter: float, height: float) -> list[list[float]]:
    return [[diameter / 2.0, 0.0], [diameter / 2.0, height]]


SHAPES: Mapping[str, Callable[[Bit], Made]] = {
    "endmill": _endmill,
    "ballend": _ball,
    "bullnose": _bull,
    "torus": _bull,
    "taperedballnose": _tapered_ball,
    "chamfer": _pointed("chamfer"),
    "vbit": _pointed("chamfer"),
    "drill": _drill,
    "reamer": _reamer,
    "tap": _tap,
    "threadmill": _thread,
    "dovetail": _dovetail,
    "slittingsaw": _saw,
    "radius": _radius,
    "fillet": _radius,
    "probe": _probe,
}
"""Shape of FreeCAD -> what makes a flute of its parameters."""

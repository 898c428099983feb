"""Flutes of the tools of a Fusion library: what each of its types means in numbers of ours."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from gcodesim.machine.cutters import cutter
from gcodesim.machine.formats.libraries.json_items import JsonItem
from gcodesim.machine.formats.libraries.library import Made, ToolData
from gcodesim.machine.tool_schema import FluteSpec

SAME_MM = 1e-3
"""Numbers of a library that are nearer than this [mm] are equal: inches are rounded."""


@dataclass(frozen=True)
class FusionTool:
    """One tool of a library in mm.

    Attributes:
        item: its JSON.
        scale: mm per unit of its lengths.
    """

    item: JsonItem
    scale: float

    @property
    def kind(self) -> str:
        """Its type, in Fusion's words."""
        return self.item.text_at("type")

    def mm(self, key: str) -> float:
        """A length of its geometry [mm], 0 where it is not given."""
        return self.item.number("geometry", key) * self.scale

    def degrees(self, key: str) -> float:
        """An angle of its geometry [deg], 0 where it is not given."""
        return self.item.number("geometry", key)

    @property
    def widest(self) -> float:
        """Largest cutting diameter [mm]."""
        return max(self.mm("DC"), self.mm("DCX"))

    @property
    def neck(self) -> float:
        """Diameter just above the flute [mm]."""
        return self.mm("shoulder-diameter") or self.mm("SFDM") or self.mm("DC")


def _size(tool: FusionTool, **numbers: float) -> ToolData:
    """A flute of the usual numbers and others, those that are 0 left out."""
    usual = {"diameter": tool.mm("DC"), "length": tool.mm("LCF")} | numbers
    return {key: value for key, value in usual.items() if value}


def _mill(tool: FusionTool) -> Made:
    taper, corner = tool.degrees("TA"), tool.mm("RE")
    if taper > 0.0 and abs(2.0 * corner - tool.mm("DC")) < SAME_MM:
        return "ball", _size(tool, taper=taper), ""
    return "mill", _size(tool, corner_radius=corner, taper=taper), ""


def _ball(tool: FusionTool) -> Made:
    return "ball", _size(tool, taper=tool.degrees("TA")), ""


def _chamfer(tool: FusionTool) -> Made:
    return _pointed(tool, "chamfer", 2.0 * tool.degrees("TA"))


def _countersink(tool: FusionTool) -> Made:
    return _pointed(tool, "countersink", tool.degrees("SIG") or 2.0 * tool.degrees("TA"))


def _drill(tool: FusionTool) -> Made:
    return _pointed(tool, "drill", tool.degrees("SIG"))


def _pointed(tool: FusionTool, kind: str, angle: float) -> Made:
    """A point of a full angle [deg]; the flute is at least as long as the point."""
    if not 0.0 < angle < 180.0:
        return "mill", _size(tool), "no angle of its point: a flat end is assumed"
    tip = min(tool.mm("tip-diameter"), tool.mm("DC"))
    point = (tool.mm("DC") - tip) / 2.0 / math.tan(math.radians(angle / 2.0))
    length = max(tool.mm("LCF"), point)
    return kind, _size(tool, length=length, point_angle=angle, tip_diameter=tip), ""


def _reamer(tool: FusionTool) -> Made:
    return _drill(tool) if 0.0 < tool.degrees("SIG") < 180.0 else ("reamer", _size(tool), "")


def _boring(tool: FusionTool) -> Made:
    return "boring", _size(tool), ""


def _centre_drill(tool: FusionTool) -> Made:
    """A pilot with a point, a cone above it, and the body."""
    radius, pilot, height = (
        tool.mm("DC") / 2.0,
        tool.mm("tip-diameter") / 2.0,
        tool.mm("tip-length"),
    )
    point, cone = tool.degrees("SIG"), tool.degrees("TA")
    if not (0.0 < pilot < radius and 0.0 < point < 180.0 and 0.0 < cone < 180.0):
        return "mill", _size(tool), "its pilot is not known: a cylinder is assumed"
    tip = pilot / math.tan(math.radians(point / 2.0))
    foot = max(height, tip)
    top = foot + (radius - pilot) / math.tan(math.radians(cone / 2.0))
    profile = [[0.0, 0.0], [pilot, tip], [pilot, foot], [radius, top]]
    profile += [[radius, tool.mm("LCF")]] if tool.mm("LCF") > top else []
    return "form", {"length": profile[-1][1], "profile": profile}, ""


def _face(tool: FusionTool) -> Made:
    angle, corner = tool.degrees("TA"), tool.mm("RE")
    if angle > 0.0 and tool.widest > tool.mm("DC"):
        tip = tool.mm("DC")
        numbers = {"tip_diameter": tip, "point_angle": 2.0 * angle, "corner_radius": corner}
        return "face", _size(tool, diameter=tool.widest, **numbers), ""
    numbers = {"corner_radius": corner, "taper": angle}
    return "face", _size(tool, diameter=tool.widest, **numbers), ""


def _slot(tool: FusionTool) -> Made:
    """A disc; its upper corner may be round too, so that only a round one surely cuts."""
    flute = _size(tool, corner_radius=tool.mm("RE"))
    round_too = flute | {"upper_radius": tool.mm("RE")}
    try:
        inner = cutter("slot", FluteSpec.model_validate(round_too)).inner
    except ValueError:
        return "slot", flute, ""
    return "slot", flute | ({"inscribed": [list(p) for p in inner]} if tool.mm("RE") else {}), ""


def _dovetail(tool: FusionTool) -> Made:
    return "dovetail", _size(tool, corner_radius=tool.mm("RE"), taper=-tool.degrees("TA")), ""


def _lollipop(tool: FusionTool) -> Made:
    return "lollipop", _to_neck(tool), ""


def _probe(tool: FusionTool) -> Made:
    return "probe", _to_neck(tool), ""


def _to_neck(tool: FusionTool) -> ToolData:
    """A ball up to where its neck begins, or where it cuts no more."""
    radius = tool.mm("DC") / 2.0
    neck = min(tool.neck / 2.0, 0.999 * radius)
    length = radius + math.sqrt(radius * radius - neck * neck)
    return _size(tool, length=min(max(length, tool.mm("LCF")), 2.0 * radius))


def _radius(tool: FusionTool) -> Made:
    tip, corner = tool.mm("tip-length"), tool.mm("RE")
    numbers = {"corner_radius": corner, "tip_length": tip}
    return "radius", _size(tool, length=max(tool.mm("LCF"), tip + corner), **numbers), ""


def _thread(tool: FusionTool) -> Made:
    """A cylinder around all teeth; what surely cuts ends at their root."""
    pitch = max(tool.mm("TP"), tool.mm("TPX"))
    flute = _size(tool, pitch=pitch)
    if not pitch and flute.get("diameter"):
        core = tool.mm("shoulder-diameter") or flute["diameter"] / 2.0
        flute["inscribed"] = _cylinder(min(core, flute["diameter"]), flute.get("length", 0.0))
    return "thread", flute, ""


def _tap(tool: FusionTool) -> Made:
    flute = _size(tool, pitch=tool.mm("TP"))
    if not tool.mm("TP") and flute.get("diameter"):
        flute["inscribed"] = _cylinder(flute["diameter"] / 2.0, flute.get("length", 0.0))
    return "tap", flute, ""


def _cylinder(diameter: float, height: float) -> list[list[float]]:
    return [[diameter / 2.0, 0.0], [diameter / 2.0, height]]


def _segment_mill(tool: FusionTool) -> Made:
    """A barrel, lens, oval or taper: the cylinder around it, and a cone that is surely in it."""
    neck = min(tool.neck, tool.mm("DC")) / 2.0
    flute = _size(tool, diameter=tool.widest)
    flute["inscribed"] = [[0.0, 0.0], [neck, flute.get("length", 0.0)]]
    return "mill", flute, "its large arcs are not followed: the cylinder around them is checked"


def _corner_chamfer(tool: FusionTool) -> Made:
    flute = _size(tool)
    core = tool.mm("DC") - 2.0 * tool.mm("chamfer-width")
    if flute.get("diameter") and core > 0.0:
        flute["inscribed"] = _cylinder(core, flute.get("length", 0.0))
    return "mill", flute, "the chamfer of its corner is filled"


def _form(tool: FusionTool) -> Made:
    """A contour of lines and arcs; without arcs it is taken as it is."""
    contour = tool.item.objects("geometry", "profile")
    ends = [step.get("end") for step in contour]
    good = [e for e in ends if isinstance(e, list) and len(e) == 2]
    straight = len(good) == len(contour) > 1 and not any(step.get("arc") for step in contour)
    profile = [[float(r) * tool.scale, float(z) * tool.scale] for r, z in good] if straight else []
    widest = max((r for r, _ in profile), default=0.0)
    if not straight or abs(2.0 * widest - tool.widest) > SAME_MM or min(z for _, z in profile) < 0:
        text = "its contour is not followed: draw it as `profile`; the flute is not checked"
        return "form", None, text
    return "form", {"length": profile[-1][1], "profile": profile}, ""


FLUTES: Mapping[str, Callable[[FusionTool], Made]] = {
    "flat end mill": _mill,
    "ball end mill": _ball,
    "bull nose end mill": _mill,
    "tapered mill": _mill,
    "corner chamfer end mill": _corner_chamfer,
    "chamfer mill": _chamfer,
    "engraving cutter": _chamfer,
    "face mill": _face,
    "slot mill": _slot,
    "dovetail mill": _dovetail,
    "lollipop mill": _lollipop,
    "radius mill": _radius,
    "thread mill": _thread,
    "form mill": _form,
    "circle segment barrel": _segment_mill,
    "circle segment lens": _segment_mill,
    "circle segment oval": _segment_mill,
    "circle segment taper": _segment_mill,
    "drill": _drill,
    "spot drill": _drill,
    "center drill": _centre_drill,
    "counter sink": _countersink,
    "counter bore": _boring,
    "boring bar": _boring,
    "reamer": _reamer,
    "tap right hand": _tap,
    "tap left hand": _tap,
    "probe": _probe,
}
"""Type of Fusion -> what makes a flute of its numbers."""

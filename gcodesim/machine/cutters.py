"""True outlines of cutting parts, from the numbers of a tools file: one function per family."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from gcodesim.constants import CORNER_RADIUS_SLACK
from gcodesim.machine.kinematics import sincosd
from gcodesim.machine.model import Turned
from gcodesim.machine.outlines import Arc, Outline, OutlinePoints, around, inside
from gcodesim.machine.tool_schema import FluteSpec

SAME_MM = 1e-9
"""Heights of numbers of a file that are nearer than this [mm] are equal."""

USES: Mapping[str, frozenset[str]] = {
    kind: frozenset(keys.split())
    for kind, keys in {
        "mill": "corner_radius taper point_angle tip_diameter",
        "ball": "taper",
        "face": "corner_radius taper point_angle tip_diameter",
        "slot": "corner_radius upper_radius",
        "dovetail": "corner_radius taper",
        "lollipop": "",
        "radius": "corner_radius tip_length",
        "chamfer": "corner_radius taper point_angle tip_diameter",
        "thread": "pitch",
        "drill": "corner_radius point_angle tip_diameter",
        "countersink": "point_angle tip_diameter",
        "tap": "pitch point_angle tip_diameter",
        "reamer": "corner_radius taper point_angle tip_diameter",
        "boring": "corner_radius",
        "form": "",
        "probe": "",
    }.items()
}
"""Type of a tool -> the numbers of its flute besides `diameter` and `length`."""

NEEDS = {
    "chamfer": ("point_angle", 90),
    "drill": ("point_angle", 118),
    "countersink": ("point_angle", 90),
    "dovetail": ("taper", -30),
    "radius": ("corner_radius", 3),
}
"""Type -> a number it must give, with an example."""


def cutter(kind: str, flute: FluteSpec) -> Turned:
    """The cutting part of a tool, standing on its tip at z = 0.

    Args:
        kind: type of the tool, a key of USES.
        flute: without a mesh.

    Raises:
        ValueError: a shape that does not exist; the message says why.
    """
    given = flute.model_fields_set
    others = given & frozenset().union(*USES.values()) - USES[kind]
    if others:
        known = ", ".join(sorted({"diameter", "length", *USES[kind]}))
        text = f"`{min(others)}` is no number of `type: {kind}`"
        raise ValueError(f"{text}, which has {known}" if kind != "form" else text)
    if flute.profile is not None:
        outer = tuple(flute.profile)
        return Turned(outer, tuple(flute.inscribed or flute.profile))
    if kind == "form":
        raise ValueError("`type: form` needs `profile: [[r, z], ...]` from the tip up")
    needed, example = NEEDS.get(kind, ("diameter", 0))
    if needed not in given:
        raise ValueError(f"`type: {kind}` needs `{needed}`, such as {example}")
    outline = OUTLINES.get(kind, _mill)(flute)
    inner = inside(outline)
    if flute.inscribed is not None:
        inner = tuple(flute.inscribed)
    elif flute.pitch is not None:
        inner = _down_to_root(inner, flute)
    whole = flute.inscribed is None and flute.pitch is None
    return Turned(around(outline), inner, _tip_ball(outline) if whole else None)


def _tip_ball(outline: Outline) -> tuple[float, float] | None:
    """Centre height and radius of a ball at the tip with a straight side above it."""
    arc, after = outline[0], outline[1:]
    if not isinstance(arc, Arc) or len(after) != 1 or isinstance(after[0], Arc):
        return None
    is_half = (arc.start, arc.end) == (-90.0, 0.0) and abs(arc.centre[0]) <= SAME_MM
    straight = abs(after[0][0] - arc.radius) <= SAME_MM
    return (arc.centre[1], arc.radius) if is_half and straight else None


def _mill(flute: FluteSpec) -> Outline:
    """Flat, bull nose, tapered, pointed: a tip, its corner, a cone if any, and the side."""
    diameter, length = _size(flute)
    if flute.point_angle is None:
        return [*_corner(diameter, length, flute.corner_radius, flute.taper)]
    half = flute.point_angle / 2.0
    tip, rise = flute.tip_diameter / 2.0, math.tan(math.radians(half))
    height = (diameter / 2.0 - tip) / rise
    if height < 0.0:
        raise ValueError(f"tip_diameter is larger than the diameter {diameter:g}")
    if height > length + SAME_MM:
        raise ValueError(f"the point alone is {height:g} high: give that `length`, or a longer one")
    height = min(height, length)
    cone = _corner(flute.tip_diameter, height, flute.corner_radius, half)
    cone[-1] = (diameter / 2.0, height)
    top = diameter / 2.0 + (length - height) * math.tan(math.radians(flute.taper))
    if top < 0.0:
        raise ValueError("the flute closes before its end: check length and taper")
    return [*cone, (top, length)] if length > height else cone


def _corner(
    diameter: float, length: float, corner_radius: float, taper: float
) -> list[tuple[float, float] | Arc]:
    """A tip with a round corner and a straight side above it."""
    sine, cosine = (float(v) for v in sincosd(taper))
    slope, radius = sine / cosine, diameter / 2.0
    top = radius + length * slope
    middle = radius + corner_radius * (slope - 1.0 / cosine)  # radius of the centre of the arc
    if middle < -CORNER_RADIUS_SLACK * radius:
        raise ValueError(f"corner_radius is larger than the diameter {diameter:g} allows")
    if top < 0.0 or corner_radius * (1.0 - sine) > length:
        raise ValueError("the flute is too short or closes before its end: check length and taper")
    if corner_radius == 0.0:
        return [(radius, 0.0), (top, length)]
    return [Arc((middle, corner_radius), corner_radius, -90.0, -taper), (top, length)]


def _ball(flute: FluteSpec) -> Outline:
    """A ball nose, whose diameter is that of the ball; a tapered side touches it."""
    diameter, length = _size(flute)
    sine, cosine = (float(v) for v in sincosd(flute.taper))
    radius = diameter / 2.0
    at_tip = diameter if flute.taper == 0.0 else diameter * (1.0 - sine) / cosine
    return _corner(at_tip, length, radius, flute.taper)


def _slot(flute: FluteSpec) -> Outline:
    """The disc of a T-slot or keyseat cutter, round at both corners."""
    diameter, length = _size(flute)
    radius, lower, upper = diameter / 2.0, flute.corner_radius, flute.upper_radius
    if max(lower, upper) > radius or lower + upper > length:
        raise ValueError("corner_radius and upper_radius are larger than the disc allows")
    outline = _corner(diameter, length - upper, lower, 0.0)
    return [*outline, Arc((radius - upper, length - upper), upper, 0.0, 90.0)] if upper else outline


def _lollipop(flute: FluteSpec) -> Outline:
    """A ball to above its middle: `length` is where the neck begins."""
    diameter, length = _size(flute)
    radius = diameter / 2.0
    if not radius < length <= diameter:
        text = (
            f"the ball is cut off above its middle: give a length from {radius:g} to {diameter:g}"
        )
        raise ValueError(text)
    end = math.degrees(math.asin(min((length - radius) / radius, 1.0)))
    return [Arc((0.0, radius), radius, -90.0, end)]


def _radius(flute: FluteSpec) -> Outline:
    """A corner rounding cutter: `diameter` of the tip, above it a hollow quarter of an arc."""
    diameter, length = _size(flute)
    radius, hollow, tip = diameter / 2.0, flute.corner_radius, flute.tip_length
    if tip + hollow > length + SAME_MM:
        raise ValueError(
            f"tip_length and corner_radius alone are {tip + hollow:g} high: check them"
        )
    arc = Arc((radius + hollow, tip), hollow, 180.0, 90.0)
    top = [(radius + hollow, length)] if length > tip + hollow else []
    return [(radius, 0.0), arc, *top]


OUTLINES: Mapping[str, Callable[[FluteSpec], Outline]] = {
    "ball": _ball,
    "slot": _slot,
    "lollipop": _lollipop,
    "probe": _lollipop,
    "radius": _radius,
}
"""Type -> its outline; left out: that of a mill."""


def _down_to_root(points: OutlinePoints, flute: FluteSpec) -> OutlinePoints:
    """What a tap or thread mill is down to the root of a sharp thread of 60 degrees."""
    root = _size(flute)[0] / 2.0 - math.sqrt(0.75) * (flute.pitch or 0.0)
    if root <= 0.0:
        raise ValueError(f"pitch is larger than the diameter {flute.diameter:g} allows")
    below = [i for i, (r, _) in enumerate(points) if r <= root]
    first = below[-1] + 1 if below else 0
    (r0, z0), (r1, z1) = points[first - 1] if below else points[0], points[first]
    height = z0 if not below else z0 + (z1 - z0) * (root - r0) / (r1 - r0)
    return (*points[:first], (root, height), (root, points[-1][1]))


def _size(flute: FluteSpec) -> tuple[float, float]:
    """Diameter and length, which the schema requires."""
    assert flute.diameter is not None
    assert flute.length is not None
    return flute.diameter, flute.length

"""Cutting parts: drawn around they hold the true shape, drawn inside they lie in it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from gcodesim.machine import shapes
from gcodesim.machine.cutters import cutter
from gcodesim.machine.mesh import merge_corners, open_edge_count, signed_volume
from gcodesim.machine.tool_schema import FluteSpec

Array = NDArray[np.float64]
Radius = Callable[[Array], Array]


def corner(diameter: float, radius: float, taper: float) -> Radius:
    """Radius of a bull nose at heights above the tip, closed form."""
    t = np.radians(taper)
    middle = diameter / 2 + radius * (np.tan(t) - 1 / np.cos(t))

    def at(z: Array) -> Array:
        arc = middle + np.sqrt(np.clip(radius**2 - (radius - z) ** 2, 0, None))
        return np.where(z < radius * (1 - np.sin(t)), arc, diameter / 2 + z * np.tan(t))

    return at


def cone(tip: float, diameter: float, angle: float) -> Radius:
    return lambda z: np.minimum(tip / 2 + z * np.tan(np.radians(angle / 2)), diameter / 2)


def sphere(radius: float) -> Radius:
    return lambda z: np.sqrt(np.clip(radius**2 - (z - radius) ** 2, 0, None))


def slot(z: Array) -> Array:
    """A disc of 20 by 4, corners of 0.5 below and 1 above."""
    low = 10 - 0.5 + np.sqrt(np.clip(0.25 - (0.5 - np.minimum(z, 0.5)) ** 2, 0, None))
    high = 10 - 1 + np.sqrt(np.clip(1 - (np.maximum(z, 3.0) - 3.0) ** 2, 0, None))
    return np.minimum(low, high)


def hollow(z: Array) -> Array:
    """A tip of 6, 1 high, and above it a hollow arc of 4."""
    arc = 7 - np.sqrt(np.clip(16 - (np.clip(z, 1, 5) - 1) ** 2, 0, None))
    return np.where(z < 1, 3.0, arc)


CASES: dict[str, tuple[str, dict[str, float], Radius]] = {
    "flat": ("mill", {"diameter": 10, "length": 30}, corner(10, 0, 0)),
    "ball": ("ball", {"diameter": 10, "length": 30}, corner(10, 5, 0)),
    "bull": ("mill", {"diameter": 10, "length": 30, "corner_radius": 2}, corner(10, 2, 0)),
    "tapered bull": (
        "mill", {"diameter": 6, "length": 40, "corner_radius": 2, "taper": 7}, corner(6, 2, 7),
    ),
    "tapered ball": (
        "ball", {"diameter": 3, "length": 20, "taper": 5},
        corner(3 * (1 - np.sin(np.radians(5))) / np.cos(np.radians(5)), 1.5, 5),
    ),
    "dovetail": (
        "dovetail", {"diameter": 20, "length": 12, "corner_radius": 1, "taper": -15},
        corner(20, 1, -15),
    ),
    "chamfer": (
        "chamfer", {"diameter": 12, "length": 18, "tip_diameter": 2, "point_angle": 90},
        cone(2, 12, 90),
    ),
    "drill": ("drill", {"diameter": 8, "length": 40, "point_angle": 118}, cone(0, 8, 118)),
    "face mill": (
        "face", {"diameter": 63, "length": 10, "tip_diameter": 50, "point_angle": 90, "taper": 0},
        cone(50, 63, 90),
    ),
    "lollipop": ("lollipop", {"diameter": 12, "length": 11}, sphere(6)),
    "probe": ("probe", {"diameter": 6, "length": 5.5}, sphere(3)),
    "T-slot": (
        "slot", {"diameter": 20, "length": 4, "corner_radius": 0.5, "upper_radius": 1}, slot,
    ),
    "corner rounding": (
        "radius", {"diameter": 6, "length": 8, "corner_radius": 4, "tip_length": 1}, hollow,
    ),
    "reamer": ("reamer", {"diameter": 6, "length": 20}, corner(6, 0, 0)),
}  # fmt: skip


@pytest.mark.parametrize(("kind", "numbers", "radius"), CASES.values(), ids=CASES)
def test_a_cutter_lies_between_its_two_outlines(
    kind: str, numbers: dict[str, float], radius: Radius
) -> None:
    turned = cutter(kind, FluteSpec.model_validate(numbers))
    length = numbers["length"]
    # Steps of a radius have two values at one height: look beside them.
    z = np.linspace(0, length, 2001)[1:-1] + length * 1e-7
    outer, inner = (np.array(points) for points in (turned.outer, turned.inner))
    assert (np.interp(z, outer[:, 1], outer[:, 0]) >= radius(z) - 1e-9).all()
    assert (np.interp(z, inner[:, 1], inner[:, 0]) <= radius(z) + 1e-9).all()
    assert outer[0, 1] == inner[0, 1] == 0.0
    assert outer[-1, 1] == inner[-1, 1] == length
    triangles = shapes.revolve(turned.outer)
    assert open_edge_count(merge_corners(triangles)) == 0
    ideal = float(np.pi * np.trapezoid(radius(z) ** 2, z))
    drawn = [np.pi * np.trapezoid(np.interp(z, p[:, 1], p[:, 0]) ** 2, z) for p in (inner, outer)]
    assert drawn[0] == pytest.approx(ideal, rel=0.003)
    assert drawn[1] == pytest.approx(ideal, rel=0.02)
    assert signed_volume(triangles) >= ideal


@pytest.mark.parametrize("kind", ["tap", "thread"])
def test_of_a_tap_and_a_thread_mill_the_core_surely_cuts(kind: str) -> None:
    flute = FluteSpec.model_validate({"diameter": 10, "length": 20, "pitch": 1.5})
    turned = cutter(kind, flute)
    assert turned.outer == ((5.0, 0.0), (5.0, 20.0))
    root = 5.0 - 1.5 * np.sqrt(3) / 2
    assert np.allclose(turned.inner, [(root, 0), (root, 20)])


def test_the_core_of_a_pointed_tap_begins_on_its_point() -> None:
    numbers = {"diameter": 10, "length": 20, "pitch": 1.5, "point_angle": 90}
    turned = cutter("tap", FluteSpec.model_validate(numbers))
    root = 5.0 - 1.5 * np.sqrt(3) / 2
    assert np.allclose(turned.inner, [(0, 0), (root, root), (root, 20)])


def test_a_form_is_drawn_by_its_points() -> None:
    profile, inscribed = [(0.0, 0.0), (4.0, 5.0)], [(0.0, 0.0), (3.0, 5.0)]
    turned = cutter("form", FluteSpec(profile=profile, inscribed=inscribed))
    assert (turned.outer, turned.inner) == (tuple(profile), tuple(inscribed))


@pytest.mark.parametrize(
    ("kind", "numbers", "text"),
    [
        ("mill", {"diameter": 10, "length": 30, "corner_radius": 6}, "corner_radius is larger"),
        ("mill", {"diameter": 10, "length": 3, "corner_radius": 4}, "flute is too short"),
        ("mill", {"diameter": 10, "length": 30, "taper": -20}, "closes before its end"),
        ("drill", {"diameter": 10, "length": 30}, "needs `point_angle`, such as 118"),
        ("drill", {"diameter": 10, "length": 2, "point_angle": 90}, "the point alone is 5 high"),
        ("chamfer", {"diameter": 4, "length": 9, "point_angle": 90, "tip_diameter": 5}, "larger"),
        ("lollipop", {"diameter": 10, "length": 4}, "give a length from 5 to 10"),
        ("slot", {"diameter": 10, "length": 1, "corner_radius": 2}, "larger than the disc"),
        ("radius", {"diameter": 4, "length": 2, "corner_radius": 3}, "alone are 3 high"),
        ("tap", {"diameter": 1, "length": 9, "pitch": 2}, "pitch is larger"),
        ("ball", {"diameter": 4, "length": 9, "pitch": 1}, "`pitch` is no number of `type: ball`"),
        ("form", {"diameter": 4, "length": 9}, "needs `profile"),
    ],
)
def test_impossible_cutters_say_what_would_be_right(
    kind: str, numbers: dict[str, float], text: str
) -> None:
    with pytest.raises(ValueError, match=text):
        cutter(kind, FluteSpec.model_validate(numbers))

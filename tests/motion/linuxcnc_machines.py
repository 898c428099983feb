"""Five-axis machines as LinuxCNC's kinematics modules have them: YAML, and formulas of their own.

The formulas are written down from the modules' documentation, with rotation matrices of their own:
they share nothing with gcodesim.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
CENTRE = np.array([5.0, -7.0, 11.0])
"""Rotation point of the tables."""
TILT = {"A": np.array([0.0, 12.0, 30.0]), "B": np.array([12.0, 0.0, 30.0])}
"""Offset of the tilting axis from it."""
PIVOT = 180.0
"""Pivot of the heads above the spindle face, `pivot-length`."""
LENGTH = 120.0
"""Length of the tool."""


def about_x(deg: float) -> Array:
    s, c = np.sin(np.radians(deg)), np.cos(np.radians(deg))
    return np.array([[1, 0, 0], [0, c, -s], [0, s, c]])


def about_y(deg: float) -> Array:
    s, c = np.sin(np.radians(deg)), np.cos(np.radians(deg))
    return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])


def about_z(deg: float) -> Array:
    s, c = np.sin(np.radians(deg)), np.cos(np.radians(deg))
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


UP = np.array([0.0, 0.0, 1.0])


def xyzac(p: Array, tilt: float, c: float) -> Array:
    """Slides of the tilting table A, C: both links turn as the command grows."""
    centre, first = CENTRE, CENTRE + TILT["A"]
    return first + about_x(tilt) @ (centre - first + about_z(c) @ (p - centre)) + LENGTH * UP


def xyzbc(p: Array, tilt: float, c: float) -> Array:
    """The same of B, C."""
    centre, first = CENTRE, CENTRE + TILT["B"]
    return first + about_y(tilt) @ (centre - first + about_z(c) @ (p - centre)) + LENGTH * UP


def fiveaxis(p: Array, tilt: float, c: float) -> Array:
    """Head C, B: C about +z, B about -y."""
    reach = PIVOT + LENGTH
    return p + LENGTH * UP + reach * (about_z(c) @ about_y(-tilt) @ UP - UP)


def maxkins(p: Array, tilt: float, c: float) -> Array:
    """Head B about -y, table C about -z through the origin."""
    reach = PIVOT + LENGTH
    return about_z(-c) @ p + LENGTH * UP + reach * (about_y(-tilt) @ UP - UP)


@dataclass(frozen=True)
class Module:
    """One kinematics module.

    Attributes:
        tilt: letter of the tilting axis; the other one is C.
        joints: rotary joints of the YAML.
        slides: slides X Y Z [mm] for a tip in the part and the two angles [deg].
        work, tool: links.
        pins: its HAL pins, as written in a HAL file.
    """

    name: str
    tilt: str
    joints: str
    slides: Callable[[Array, float, float], Array]
    work: str
    tool: str
    pins: dict[str, float]

    @property
    def yaml(self) -> str:
        """The machine file; X Y Z move the tool, their zero is where the gauge point is 0 0 0."""
        rotary = self.joints.format(
            centre=CENTRE.tolist(), tilt=(CENTRE + TILT[self.tilt]).tolist(), pivot=[0, 0, PIVOT]
        )
        return YAML.format(tilt=self.tilt, joints=rotary, work=self.work, tool=self.tool)


YAML = """\
name: linuxcnc
links: {{bed: {{}}, X: {{}}, Y: {{}}, Z: {{}}, {tilt}: {{}}, C: {{}}}}
joints:
  X: {{type: linear, parent: bed, child: X, axis: [1, 0, 0], limits: [-900, 900], rapid: 60000}}
  Y: {{type: linear, parent: X, child: Y, axis: [0, 1, 0], limits: [-900, 900], rapid: 60000}}
  Z: {{type: linear, parent: Y, child: Z, axis: [0, 0, 1], limits: [-900, 900], rapid: 60000}}
{joints}
tool: {{link: {tool}, gauge_point: [0, 0, 0], axis: [0, 0, 1]}}
work: {{link: {work}, offsets: {{G54: {{X: 0, Y: 0, Z: 0}}}}}}
"""

TURN = "  {0}: {{{{type: rotary, parent: {1}, child: {0}, axis: {2}, point: {3}, rapid: 36000}}}}"
_TABLE_PINS = {f"{axis}-rot-point": value for axis, value in zip("xyz", CENTRE, strict=True)}
MODULES = [
    Module(
        "xyzac-trt-kins", "A",
        "\n".join([TURN.format("A", "bed", "[1, 0, 0]", "{tilt}"),
                   TURN.format("C", "A", "[0, 0, 1]", "{centre}")]),
        xyzac, "C", "Z", {**_TABLE_PINS, "y-offset": 12.0, "z-offset": 30.0},
    ),
    Module(
        "xyzbc-trt-kins", "B",
        "\n".join([TURN.format("B", "bed", "[0, 1, 0]", "{tilt}"),
                   TURN.format("C", "B", "[0, 0, 1]", "{centre}")]),
        xyzbc, "C", "Z", {**_TABLE_PINS, "x-offset": 12.0, "z-offset": 30.0},
    ),
    Module(
        "5axiskins", "B",
        "\n".join([TURN.format("C", "Z", "[0, 0, 1]", "{pivot}"),
                   TURN.format("B", "C", "[0, -1, 0]", "{pivot}")]),
        fiveaxis, "bed", "B", {"pivot-length": PIVOT + LENGTH},
    ),
    Module(
        "maxkins", "B",
        "\n".join([TURN.format("B", "Z", "[0, -1, 0]", "{pivot}"),
                   TURN.format("C", "bed", "[0, 0, -1]", "[0, 0, 0]")]),
        maxkins, "C", "B", {"pivot-length": PIVOT + LENGTH},
    ),
]  # fmt: skip

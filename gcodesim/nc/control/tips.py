"""Asks the kinematics of a machine about one position: where the tip is, and how the tool stands.

Positions are X Y Z [mm], A B C [deg]; every function may raise OrientationError.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from gcodesim.nc.control.frames import ROUNDING, UNIT, Matrix, Placement
from gcodesim.nc.control.supply import Kinematics
from gcodesim.nc.program import Floats

NO_TOOL = [0.0, 0.0, 0.0]


def tip_position(kinematics: Kinematics, axes: list[float], tool: list[float]) -> list[float]:
    """Return the tip and the rotary positions, as Frame.WORK counts them."""
    tip = kinematics.tips(_row(axes), _row(tool[:3]))[0]
    return [*tip.tolist(), *axes[3:]]


def axis_positions(kinematics: Kinematics, position: list[float], tool: list[float]) -> list[float]:
    """Return the axis positions that hold a tip with the rotary axes as the position says."""
    tip, rotary = _row(position[:3]), _row(position[3:])
    linear = kinematics.axes_at(tip, rotary, _row(tool[:3]))[0, :3]
    return [*linear.tolist(), *position[3:]]


def carried_point(kinematics: Kinematics, point: list[float], rotary: list[float]) -> list[float]:
    """Return where the work link has carried a point (x, y, z) that stood so at rotary zero."""
    point = kinematics.carried(_row(point), _row(rotary))[0].tolist()
    return point


def work_placement(kinematics: Kinematics, rotary: list[float]) -> Placement:
    """Return how far the work link has moved from where it stands at rotary zero."""
    shift, *ends = kinematics.carried(np.array([NO_TOOL, *UNIT]), _row(rotary).repeat(4, axis=0))
    return Placement(_columns([end - shift for end in ends]), shift.tolist())


def tool_turn(kinematics: Kinematics, rotary: list[float]) -> Matrix:
    """Return the axes of the tool's link as seen from the part, in columns."""
    axes = _row([0.0, 0.0, 0.0, *rotary]).repeat(4, axis=0)
    gauge, *ends = kinematics.tips(axes, np.array([NO_TOOL, *UNIT]))
    return _columns([gauge - end for end in ends])


def tool_direction(kinematics: Kinematics, rotary: list[float]) -> list[float]:
    """Return the tool axis, from the tip towards the spindle, as seen from the part."""
    direction = kinematics.directions(_row(rotary))[0].tolist()
    return direction


def way_back(kinematics: Kinematics, rotary: list[float]) -> list[float]:
    """Return how X, Y and Z move while the tool goes back by 1 mm along itself."""
    direction = kinematics.directions(_row(rotary))
    # Between slides that are not square, a direction of length 1 in X Y Z is longer or shorter.
    length = math.hypot(*(row[2] for row in tool_turn(kinematics, rotary)))
    if abs(length - 1.0) > ROUNDING:
        direction = direction * length
    along = kinematics.axis_directions(direction, _row(rotary))[0].tolist()
    return along


def rotary_for(
    kinematics: Kinematics, direction: list[float], previous: list[float], prefer: int = 0
) -> list[float]:
    """Return the rotary positions for a direction of the tool, as a control chooses them."""
    rotary = kinematics.rotary_at(np.array(direction), np.array(previous), prefer).tolist()
    return rotary


def _row(values: Sequence[float]) -> Floats:
    return np.array([values])


def _columns(vectors: list[Floats]) -> Matrix:
    rows = np.stack(vectors, axis=1).tolist()
    return tuple((row[0], row[1], row[2]) for row in rows)

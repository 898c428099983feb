"""Frames of foreign files: where a part stands in the world, and the angles that say so."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gcodesim.machine.kinematics import rotation

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LinkPose:
    """Pose of a link's frame in the world at the zero pose: rotation (3, 3) and origin (3,)."""

    turn: Array
    origin: Array

    def at(self, xyz: Array, rpy: Array) -> LinkPose:
        """The frame at a place in this one, turned by `rpy` [rad]; see `turn_of`."""
        return LinkPose(self.turn @ turn_of(rpy), self.origin + self.turn @ xyz)


def turn_of(rpy: Array) -> Array:
    """Rotation about fixed X, then Y, then Z by (3,) angles [rad]."""
    about_x, about_y, about_z = (
        rotation(axis, math.degrees(angle)) for axis, angle in zip(np.eye(3), rpy, strict=True)
    )
    return np.asarray(about_z @ about_y @ about_x)


def angles_of(turn: Array) -> Array:
    """The angles (3,) [deg] about fixed X, Y, Z of a rotation, good near every pitch."""
    yaw = math.atan2(turn[1, 0], turn[0, 0])
    pitch = math.atan2(-turn[2, 0], math.hypot(turn[0, 0], turn[1, 0]))
    sine, cosine = math.sin(yaw), math.cos(yaw)
    roll = math.atan2(
        sine * turn[0, 2] - cosine * turn[1, 2], cosine * turn[1, 1] - sine * turn[0, 1]
    )
    return np.degrees([roll, pitch, yaw])

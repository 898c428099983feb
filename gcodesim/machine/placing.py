"""Where bodies of a setup stand: in the world, at a zero point of the program, or on each other.

A zero point is a place of the machine: the axis positions of a work offset bring the gauge point
there. Seen from the link that carries a body it is one coordinate system, whatever carries what.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gcodesim.machine.kinematics import poses_of, rotation, transform
from gcodesim.machine.model import Body, Joint, Machine, Part, ToolMount, ZeroPoint

Array = NDArray[np.float64]

AXES = "XYZABC"
OTHERS = {"X": ("Y", "Z"), "Y": ("Z", "X"), "Z": ("X", "Y")}
DIRECTION_DECIMALS = 12
"""Of directions that are differences of positions: what is beyond is rounding."""

PARALLEL = 1e-6
"""Two directions whose cosine is below this are square to each other."""


class PlaceError(Exception):
    """A frame that a machine does not have; the message says why. The reader adds the line."""


@dataclass(frozen=True)
class WorkFrames:
    """The coordinate systems of a machine.

    Attributes:
        links: of the machine.
        joints: parents before children.
        tool: where tools are carried, None for a machine without.
        bodies: of the links.
        offsets: work offsets by number.
        start: where joints stand; that counts for those that no program moves.
    """

    links: Sequence[str]
    joints: Sequence[Joint]
    tool: ToolMount | None
    bodies: Mapping[str, Body]
    offsets: Mapping[int, ZeroPoint]
    start: Mapping[str, float]

    @staticmethod
    def of(machine: Machine) -> WorkFrames:
        """The coordinate systems of a machine that is loaded."""
        where = machine.links, machine.joints, machine.tool, machine.bodies
        return WorkFrames(*where, machine.offsets, machine.start)

    def zero_point(self, number: int, link: str) -> Array:
        """The frame of a work offset in world coordinates of a link at the zero pose, (4, 4).

        Raises:
            PlaceError: the machine carries no tool, or has fewer than two of X, Y and Z.
        """
        offset = self.offsets[number]
        return self._program_frame(link, offset.value, offset.rotation)

    def table(self, link: str) -> Array:
        """The frame of a link's mount face, (4, 4): program directions, origin on top of it.

        The origin is where the axis of a rotary table meets its face, or the middle of the face.

        Raises:
            PlaceError: the link has no shape, or the machine no such directions.
        """
        frame = self._program_frame(link, (0.0,) * 6, 0.0)
        up = self.up(link)
        parts = self.mounting(link)
        low, high = _box(parts)
        turning = self._turning(link)
        middle = turning.point if turning else (low + high) / 2.0
        frame[:3, 3] = middle + (top_of(parts, up) - middle @ up) * up
        return frame

    def mounting(self, link: str) -> tuple[Part, ...]:
        """What things are mounted on: the part of a link that is named `table`, or all of it."""
        body = self.bodies.get(link)
        if body is None:
            raise PlaceError(f"link {link} has no shape, so no face to mount on")
        return tuple(part for part in body.parts if part.name == "table") or body.parts

    def up(self, link: str) -> Array:
        """The direction in which things stand on a link, a unit vector (3,).

        It is the axis of the rotary joint that turns the link, towards the spindle, or else
        towards Y; without such a joint, and where the link carries another rotary joint (the
        cradle of a trunnion), the axis of the tool.
        """
        joint = self._turning(link)
        spindle = self.tool.axis if self.tool else np.array([0.0, 0.0, 1.0])
        if joint is None:
            return np.asarray(spindle)
        side = float(joint.axis @ spindle)
        if abs(side) < PARALLEL:
            side = float(joint.axis @ self._program_frame(link, (0.0,) * 6, 0.0)[:3, 1])
        return np.asarray(joint.axis if side >= 0.0 else -joint.axis) + 0.0

    def _turning(self, link: str) -> Joint | None:
        """The rotary joint whose last link it is, None where there is none."""
        rotary = [joint for joint in self.joints if joint.rotary]
        if any(joint.parent == link for joint in rotary):
            return None
        return next((joint for joint in rotary if joint.child == link), None)

    def _program_frame(self, link: str, value: Sequence[float], turn: float) -> Array:
        """Where the gauge point is at axis positions, and how X, Y and Z move it, from a link."""
        at = dict(zip(AXES, value, strict=True))
        origin = self._gauge_point(link, at)
        slides = {joint.name for joint in self.joints if not joint.rotary} & set("XYZ")
        if len(slides) < 2:
            raise PlaceError("the machine has fewer than two of the axes X, Y and Z")
        columns = {
            name: np.round(self._gauge_point(link, at | {name: at[name] + 1.0}) - origin,
                           DIRECTION_DECIMALS)
            for name in slides
        }  # fmt: skip
        for name in set("XYZ") - slides:
            before, after = OTHERS[name]
            columns[name] = np.cross(columns[before], columns[after])
        frame = np.eye(4)
        frame[:3, :3] = np.stack([columns[name] for name in "XYZ"], axis=1) + 0.0
        frame[:3, :3] = frame[:3, :3] @ rotation([0.0, 0.0, 1.0], turn)
        frame[:3, 3] = origin
        return frame

    def _gauge_point(self, link: str, at: Mapping[str, float]) -> Array:
        """The gauge point at axis positions, in world coordinates of a link at the zero pose."""
        if self.tool is None:
            raise PlaceError("the machine file says nothing of a `tool`, so that no zero is known")
        stand = {**self.start, **at}
        poses = poses_of(self.links, self.joints, [stand[joint.name] for joint in self.joints])
        world = transform(poses[self.tool.link], self.tool.gauge_point)
        return transform(_inverse(poses[link]), world)


def top_of(parts: Sequence[Part], up: Array) -> float:
    """Height [mm] of the highest point of some parts in a direction."""
    return max(float((part.triangles @ up).max()) for part in parts)


def foot_of(parts: Sequence[Part], up: Array) -> float:
    """Height [mm] of the lowest point of some parts in a direction."""
    return min(float((part.triangles @ up).min()) for part in parts)


def extent(parts: Sequence[Part], frame: Array) -> tuple[Array, Array]:
    """Lowest and highest coordinates (3,) of some parts in a frame (4, 4)."""
    return _box(parts, _inverse(frame))


def _box(parts: Sequence[Part], pose: Array | None = None) -> tuple[Array, Array]:
    points = np.concatenate([part.triangles.reshape(-1, 3) for part in parts])
    points = points if pose is None else transform(pose, points)
    return points.min(axis=0), points.max(axis=0)


def _inverse(pose: Array) -> Array:
    """The inverse of a pose (4, 4), without the rounding of a solver."""
    inverse = np.eye(4)
    inverse[:3, :3] = pose[:3, :3].T
    inverse[:3, 3] = -(pose[:3, :3].T @ pose[:3, 3])
    return inverse

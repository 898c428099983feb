"""Which rotary axes point the tool where the part wants it: one or two joints, any axes.

``R(w1, q1) R(w2, q2) a = b``: w1 is the axis next to the part, w2 the one next to the tool, a the
tool axis at the zero pose and b the wanted direction seen from the part. This is Paden-Kahan's
second subproblem, solved here by the spherical triangle w1, w2, a with half angles: nothing
cancels, so that joints are exact to rounding down to the pole.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gcodesim.constants import TRAVEL_SLACK
from gcodesim.errors import OrientationError
from gcodesim.machine.kinematics import cross_matrix, turned
from gcodesim.machine.model import Joint
from gcodesim.nc.program import AXES

Array = NDArray[np.float64]

REACH_SLACK = 1.0e-12
"""Directions this far outside the cone a pair of axes reaches count as on its edge (k2 of
kinematics.md section 4, square of a sine). Larger would turn tools beyond what was programmed."""

POLE = 1.0e-9
"""Nearer than this [rad] to the axis next to the part, a direction leaves that joint free."""

ONE_AXIS_SLACK = 1.0e-6
"""A machine with one rotary axis misses a direction by at most this [rad]: I J K with 6 digits."""

TIE = 1.0e-9
"""Two choices whose travel differs by less than this part are equally far."""


@dataclass(frozen=True)
class RotaryAxes:
    """The rotary joints between part and tool, the one next to the part first.

    Attributes:
        joints: one or two joints of the machine.
        axes: their unit axes, turned round where the joint carries the work, shape (k, 3).
        tool_axis: from the tip towards the spindle at the zero pose, shape (3,).
    """

    joints: tuple[Joint, ...]
    axes: Array
    tool_axis: Array

    def directions(self, degrees: Array) -> Array:
        """Tool axis seen from the part, (n, 3), for joint positions (n, k) [deg]."""
        seen = np.broadcast_to(self.tool_axis, (len(degrees), 3))
        for k in reversed(range(len(self.joints))):
            seen = turned(seen, self.axes[k], degrees[:, k])
        return seen

    def pole_angles(self, directions: Array) -> Array:
        """Angle [rad] of directions (n, 3) to the nearer end of the axis next to the part."""
        angles = self.first_angles(directions)
        return np.minimum(angles, np.pi - angles)

    def solutions(self, directions: Array) -> tuple[Array, Array]:
        """Joint positions that give unit directions (n, 3).

        Returns:
            Positions within +-180, shape (n, 2, k) [deg]: both solutions, NaN where a direction
            cannot be reached; and the square of a sine (n,) that is 0 where both are the same.
            At a pole the joint next to the part is 0.
        """
        if len(self.joints) == 1:
            return self._single(directions)
        w1, w2 = self.axes
        phi, apart = self.second_angles(self.first_angles(directions))
        second = _within_half_turn(self._base + np.degrees(np.stack([phi, -phi], axis=1)))
        first = np.empty_like(second)
        pole = self.pole_angles(directions) < POLE
        for k in range(2):
            tool = turned(np.broadcast_to(self.tool_axis, directions.shape), w2, second[:, k])
            first[:, k] = np.where(pole, 0.0, np.degrees(_turn(w1, tool, directions)))
        found = np.stack([first, second], axis=2)
        found[apart < -REACH_SLACK] = np.nan
        return found, np.where(pole, 0.0, np.maximum(apart, 0.0))

    def first_angles(self, directions: Array) -> Array:
        """Angle [rad] from the axis next to the part to directions (n, 3), shape (n,)."""
        across = np.linalg.norm(directions @ cross_matrix(self.axes[0]).T, axis=1)
        return np.arctan2(across, directions @ self.axes[0])

    def second_angles(self, delta: Array) -> tuple[Array, Array]:
        """Turn of the second joint from where the tool is nearest to the first axis, for an angle.

        By the spherical law of cosines in half angles.

        Args:
            delta: angle from the first axis to the tool [rad], shape (n,).

        Returns:
            The turn [rad] from 0 to pi, both also beyond what the joints reach; and k2 of
            kinematics.md section 4, below 0 there.
        """
        sigma, tau = self.shape
        sine2 = np.sin((delta + sigma - tau) / 2) * np.sin((delta - sigma + tau) / 2)
        cosine2 = np.sin((sigma + tau + delta) / 2) * np.sin((sigma + tau - delta) / 2)
        sine, cosine = np.sqrt(np.maximum(sine2, 0.0)), np.sqrt(np.maximum(cosine2, 0.0))
        return 2.0 * np.arctan2(sine, cosine), 4.0 * sine2 * cosine2 / np.sin(sigma) ** 4

    def tilts(self, degrees: Array) -> Array:
        """That turn with its sign [deg] of positions (n, 2): > 0 on the first solution, (n,)."""
        return _within_half_turn(degrees[:, 1] - self._base)

    @cached_property
    def shape(self) -> tuple[float, float]:
        """Angles [rad] between both axes, and between the second and the tool."""
        w1, w2 = self.axes
        return _angle(w1, w2), _angle(w2, self.tool_axis)

    @cached_property
    def _base(self) -> float:
        """Position [deg] of the second joint at which the tool is nearest to the first axis."""
        turn = _turn(self.axes[1], self.tool_axis[None, :], self.axes[:1])
        return float(np.degrees(turn[0]))

    def _single(self, directions: Array) -> tuple[Array, Array]:
        axis = self.axes[0]
        ends = np.broadcast_to(self.tool_axis, directions.shape)
        angle = np.degrees(_turn(axis, ends, directions))
        angle = np.where(self.pole_angles(directions) < POLE, 0.0, angle)
        missed = np.linalg.norm(turned(ends, axis, angle) - directions, axis=1)
        angle = np.where(missed <= ONE_AXIS_SLACK, angle, np.nan)
        return np.repeat(angle[:, None, None], 2, axis=1), np.zeros(len(directions))

    def chosen(self, direction: Array, previous: Array, prefer: int = 0) -> Array:
        """The joint positions (k,) [deg] that a control takes for one unit direction.

        Both solutions, every joint plus whole turns; the one whose slowest joint is there first.
        Tie: the joint next to the tool (the tilt of most machines) is not negative. At a pole the
        joint next to the part stays where it is.

        Args:
            direction: unit vector (3,).
            previous: joint positions before (k,) [deg].
            prefer: +1 or -1: the joint next to the tool must not be negative, or positive.

        Raises:
            OrientationError: no position reaches the direction, or none within the travel.
        """
        vector = "({:.6g}, {:.6g}, {:.6g})".format(*direction)
        both, apart = self.solutions(direction[None, :])
        if np.isnan(both).any():
            message = f"the rotary axes cannot point the tool along {vector}"
            raise OrientationError("direction_unreachable", message)
        if float(self.pole_angles(direction[None, :])[0]) < POLE:
            both[0, :, 0] = previous[0]
        candidates = [
            positions
            for solution in both[0, : 2 if apart[0] > 0.0 else 1]
            if np.isfinite(positions := self._nearest(solution, previous)).all()
            and prefer * positions[-1] >= -TIE
        ]
        if not candidates:
            names = " and ".join(joint.name for joint in self.joints)
            wish = " and the sign asked for" if prefer else ""
            message = f"{names} cannot point the tool along {vector} within their travel{wish}"
            raise OrientationError("orientation_out_of_travel", message)
        rates = np.array([joint.rapid for joint in self.joints])
        times = [float(np.max(np.abs(q - previous) / rates)) for q in candidates]
        limit = min(times) * (1.0 + TIE) + TIE
        nearest = [q for q, time in zip(candidates, times, strict=True) if time <= limit]
        return max(nearest, key=lambda q: float(q[-1]) >= 0.0)

    def _nearest(self, degrees: Array, previous: Array) -> Array:
        """Positions plus whole turns, nearest to the previous within the travel, or NaN; (k,)."""
        slack = TRAVEL_SLACK
        lower = np.array([joint.lower for joint in self.joints])
        upper = np.array([joint.upper for joint in self.joints])
        low = np.ceil((lower - slack - degrees) / 360.0)
        high = np.floor((upper + slack - degrees) / 360.0)
        turns = np.clip(np.rint((previous - degrees) / 360.0), low, high)
        return np.where(low <= high, degrees + 360.0 * turns, np.nan)


def _angle(a: Array, b: Array) -> float:
    return float(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))


def _turn(axis: Array, start: Array, end: Array) -> Array:
    """Angle [rad] about `axis` from vectors `start` (n, 3) to `end` (n, 3)."""
    flat = cross_matrix(axis).T
    start, end = start @ flat, end @ flat
    across = np.sum((start @ flat) * end, axis=1)
    return np.arctan2(across, np.sum(start * end, axis=1))


def _within_half_turn(degrees: Array) -> Array:
    return degrees - 360.0 * np.ceil(degrees / 360.0 - 0.5)


def columns_of(joints: tuple[Joint, ...]) -> list[int]:
    """Columns of the joints among X Y Z A B C."""
    return [AXES.index(joint.name) for joint in joints]

"""Where the tool stands, seen from the link of the stock, and how far it leaves straight ways.

All is float64 on the host; the frame of a link is the world at the zero pose, moved with the link.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gcodesim.collision.geometry.poses import joints_between
from gcodesim.machine.kinematics import turned
from gcodesim.machine.model import Joint, Machine
from gcodesim.motion.path import Path, path_fraction

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class ToolWay:
    """The tool of a machine on a path, seen from one link."""

    machine: Machine
    path: Path
    link: str

    @property
    def chain(self) -> list[tuple[int, int]]:
        """Joints (column, sign) from the link to the tool."""
        assert self.machine.tool is not None
        return joints_between(self.machine.joints, self.link, self.machine.tool.link)

    def placed(self, q: Array) -> tuple[Array, Array]:
        """Gauge points and tool axes, each (n, 3), at joint positions (n, joints)."""
        mount = self.machine.tool
        assert mount is not None
        points = np.broadcast_to(mount.gauge_point, (len(q), 3))
        axes = np.broadcast_to(mount.axis, (len(q), 3))
        for column, sign in reversed(self.chain):
            points, axes = moved(self.machine.joints[column], sign, q[:, column], points, axes)
        return points, axes

    def at(self, piece: Ints, time_ps: Ints) -> tuple[Array, Array, Array]:
        """Gauge points, tool axes and fractions of the piece at times within pieces."""
        bounds = self.path.bounds_ps
        tau = (time_ps - bounds[piece]) / (bounds[piece + 1] - bounds[piece])
        s = path_fraction(self.path.law[piece], tau)
        return *self.placed(self.path.positions_on(piece, s)), s

    def turns(self) -> NDArray[np.bool_]:
        """Whether the tool turns in a piece, seen from the link, shape (n,)."""
        columns = [c for c, _ in self.chain if self.machine.joints[c].rotary]
        return np.asarray((self.path.q0[:, columns] != self.path.q1[:, columns]).any(axis=1))

    def bends(self, piece: Ints, heights: tuple[float, float, float]) -> tuple[Array, Array]:
        """Bounds on second derivatives in pieces, as s goes from 0 to 1 over all of each.

        From the tool inwards, for a point with |x'| <= v and |x''| <= b: a slide by d makes them
        v + d and b; a joint that turns by d, with rho the largest distance of the point from its
        axis, makes them v + rho d and b + 2 d v + rho d^2. The distance is convex but for b / 8.
        The tool axis is such a point, about axes through the origin. Arcs add what their slides
        bend, once where nothing turns, else sqrt(3) times.

        Args:
            piece: numbers of pieces, shape (m,).
            heights: lowest and highest point of the tool along its axis, and its radius [mm].

        Returns:
            Of the points of the tool [mm], and of its axis, shape (m,) each.
        """
        mount, joints = self.machine.tool, self.machine.joints
        assert mount is not None
        low, high, radius = heights
        points = [mount.gauge_point + z * mount.axis for z in (low, high)]
        ends = [np.broadcast_to(p, (len(piece), 3)) for p in points for _ in (0, 1)]
        axes = [np.broadcast_to(mount.axis, (len(piece), 3))] * 4
        q = [self.path.q0[piece], self.path.q1[piece]] * 2
        step, arc_bend = self._steps(piece)
        still = np.zeros(len(piece))
        point, axis = (still, still), (still, still)
        for column, sign in reversed(self.chain):
            joint, d = joints[column], step[:, column]
            if joint.rotary:
                arms = [np.cross(joint.axis, p - joint.point) for p in ends]
                point = _turned_bend(point, _longest(arms) + radius, d)
                axis = _turned_bend(axis, _longest([np.cross(joint.axis, a) for a in axes]), d)
            else:
                point = point[0] + d, point[1]
            placed = [
                moved(joint, sign, p[:, column], e, a)
                for p, e, a in zip(q, ends, axes, strict=True)
            ]
            ends, axes = [e for e, _ in placed], [a for _, a in placed]
        return point[1] + arc_bend * np.where(axis[0] > 0.0, np.sqrt(3.0), 1.0), axis[1]

    def _steps(self, piece: Ints) -> tuple[Array, Array]:
        """How far every joint goes in pieces [mm, rad], at most; how much arcs bend [mm]."""
        path = self.path
        scale = np.array([np.pi / 180.0 if j.rotary else 1.0 for j in self.machine.joints])
        step = np.abs(path.q1[piece] - path.q0[piece]) * scale
        bend = np.zeros(len(piece))
        on_arc = np.flatnonzero(path.arc[piece] >= 0)
        if len(on_arc):
            arcs = path.arcs[path.arc[piece[on_arc]]]
            sweep, grown = np.radians(np.abs(arcs["sweep"])), np.abs(arcs["r1"] - arcs["r0"])
            wide = np.maximum(arcs["r0"], arcs["r1"])
            along = wide * sweep + grown + np.linalg.norm(arcs["lift"], axis=1)
            for column in path.xyz:
                if column >= 0:
                    step[on_arc, column] = along
            bend[on_arc] = wide * sweep**2 + 2.0 * grown * sweep
        return step, bend


def _longest(vectors: list[Array]) -> Array:
    return np.asarray(np.max([np.linalg.norm(v, axis=1) for v in vectors], axis=0))


def _turned_bend(known: tuple[Array, Array], lever: Array, d: Array) -> tuple[Array, Array]:
    """Bounds on first and second derivative of a point that a joint turns by d besides."""
    speed, bend = known
    lever = lever + bend / 8.0
    return speed + lever * d, bend + 2.0 * d * speed + lever * d * d


def moved(joint: Joint, sign: int, q: Array, points: Array, axes: Array) -> tuple[Array, Array]:
    """Points and directions (n, 3), moved by a joint at positions q (n,), or back for sign -1."""
    if joint.rotary:
        turned_points = turned(points - joint.point, joint.axis, sign * q) + joint.point
        return turned_points, turned(axes, joint.axis, sign * q)
    return points + (sign * q)[:, None] * joint.axis, axes

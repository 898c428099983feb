"""Advancing by the directed bound: from pose to pose, each as late as nothing can touch before."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gcodesim.collision.baseline.exhaustive import Work
from gcodesim.constants import PS_PER_S
from gcodesim.machine.kinematics import transform, world_from_link
from gcodesim.machine.model import Joint
from gcodesim.motion.path import Path
from gcodesim.study.kernels.directed_bound import free_time
from gcodesim.study.scenes import Scene

Floats = NDArray[np.float64]

MOST_POSES = 10_000
"""Poses after which an approach counts as a contact that was not resolved."""


@dataclass(frozen=True)
class PointMotion:
    """How the points of the moving body move at one instant.

    Attributes:
        velocity: of its vertices, (m, 3, 3) [mm/s].
        curvature: largest acceleration of a point of each triangle up to the piece's end, (m,).
        across: projection onto the space in which points accelerate, (3, 3).
    """

    velocity: Floats
    curvature: Floats
    across: Floats


def advance(scene: Scene, tolerance_mm: float, work: Work) -> int | None:
    """First instant at which the gap is down to the tolerance [ps], None when it never is.

    For scenes whose first body stands, and whose second is moved by linear joints or by one rotary
    one. A step leaves half the tolerance, so that the last one ends below the whole.
    """
    path, end = scene.path, scene.path.duration_ps
    fixed, moved = (_triangles(scene, body) for body in scene.pair)
    link = scene.machine.bodies[scene.pair[1]].link
    time = 0
    for _ in range(MOST_POSES):
        q = path.positions(np.array([time]))[0]
        posed = transform(world_from_link(scene.machine, q)[link], moved)
        piece = int(path.piece_at(np.array([min(time + 1, end)]))[0])
        motion = _motion(path, scene.machine.joints, piece, time, posed)
        step_s, gap = free_time(
            fixed, posed, motion.velocity, motion.curvature, motion.across, tolerance_mm / 2.0
        )
        work.counts += np.array([1, 0, len(fixed) * len(moved)])
        step = int(step_s * PS_PER_S)
        if gap <= tolerance_mm or step == 0:
            return time
        if time == end:
            return None
        time = min(time + step, int(path.bounds_ps[piece + 1]))
    return time


def _triangles(scene: Scene, body: str) -> Floats:
    return np.concatenate([part.triangles for part in scene.machine.bodies[body].parts])


def _motion(
    path: Path, joints: tuple[Joint, ...], piece: int, time_ps: int, posed: Floats
) -> PointMotion:
    """Velocity now, and bounds of the acceleration during the rest of a piece."""
    start, end = (int(t) for t in path.bounds_ps[piece : piece + 2])
    seconds, tau = (end - start) / PS_PER_S, (time_ps - start) / (end - start)
    c1, c2, c3 = path.law[piece].tolist()
    s = tau * (c1 + tau * (c2 + tau * c3))
    rate = (c1 + tau * (2.0 * c2 + 3.0 * tau * c3)) / seconds
    most_rate = (abs(c1) + 2.0 * abs(c2) + 3.0 * abs(c3)) / seconds
    most_bend = max(abs(2.0 * c2 + 6.0 * c3 * t) for t in (tau, 1.0)) / seconds**2
    if joints[0].rotary:
        (turning,) = joints
        arm = posed - turning.point
        turn = np.radians(float(path.q1[piece, 0] - path.q0[piece, 0]))
        spin = np.cross(turning.axis, arm)
        lever = np.linalg.norm(spin, axis=2).max(axis=1)
        curvature = lever * ((turn * most_rate) ** 2 + abs(turn) * most_bend)
        return PointMotion(turn * rate * spin, curvature, np.eye(3) - np.outer(*[turning.axis] * 2))
    way, bend, across = _way(path, joints, piece, s, most_rate, most_bend)
    return PointMotion(np.broadcast_to(rate * way, posed.shape), np.full(len(posed), bend), across)


def _way(
    path: Path, joints: tuple[Joint, ...], piece: int, s: float, most_rate: float, most_bend: float
) -> tuple[Floats, float, Floats]:
    """Derivative of the position by s, largest acceleration, and the space in which it lies."""
    axes = np.array([joint.axis for joint in joints])
    if path.arc[piece] < 0:
        way = (path.q1[piece] - path.q0[piece]) @ axes
        length = float(np.linalg.norm(way))
        along = way / max(length, 1e-300)
        return way, length * most_bend, np.outer(along, along)
    arc = path.arcs[path.arc[piece]]
    sweep, radius = np.radians(float(arc["sweep"])), max(float(arc["r0"]), float(arc["r1"]))
    phase = sweep * s
    along = -np.sin(phase) * arc["u"] + np.cos(phase) * arc["v"]
    way = radius * sweep * along + arc["lift"]
    bend = radius * (sweep * most_rate) ** 2 + float(np.linalg.norm(way)) * most_bend
    normal = np.cross(arc["u"], arc["v"])
    flat = most_bend == 0.0
    return way, bend, np.eye(3) - np.outer(normal, normal) * flat

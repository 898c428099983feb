"""Motion bounds: how far a body can leave the chord between two poses.

Theorem (chord certificate). Let the joints go along a straight line in joint space, by D in all,
and let n be a fixed unit vector. The height n.x(s) of a point, s in 0..1, has two derivatives with

    |n.x''| <= K = sum_(k rotary) rho_k D_k^2 + 2 sum_(j < k, j rotary) |D_j| lam_k |D_k|,

j nearer the base than k, lam_k = 1 for a linear joint and rho_k for a rotary one, rho_k = largest
distance of the point from axis k during the move. (x'' = sum_jk D_j D_k d2x/dq_j dq_k; the mixed
derivative vanishes when the inner joint j is linear, and is a rotation of dx/dq_k when it turns.)
Linear interpolation errs by at most K/8, so the gap of two bodies along n stays above

    min(gap at both ends) - (K_a + K_b) / 8.

If the path leaves the straight line by at most dev_j in joint j, each point leaves it by at most
sum_(rotary) rho_j dev_j + sum_(linear) |dev_j|, which is subtracted as well. The frame may stand
anywhere on the chain between the bodies: each then has the joints of its own side.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gcodesim.collision.bodies.reach import sweep, triangle_boxes
from gcodesim.collision.bodies.trees import Tree
from gcodesim.collision.geometry.poses import joints_between
from gcodesim.machine.kinematics import rotation
from gcodesim.machine.model import Joint
from gcodesim.motion.overtravel import position_ranges
from gcodesim.motion.path import Path

Floats = NDArray[np.float64]

SWEEP_STEPS = 24
"""Positions of an outer rotary joint at which levers are measured; the rest is added as a chord."""


@dataclass(frozen=True)
class MotionTables:
    """Displacements and deviations of dyadic runs of pieces, level by level.

    Attributes:
        level_first: first row of each level, shape (levels,).
        moved: absolute joint displacement over the run, shape (rows, joints) [mm, rad].
        deviation: largest distance of the path from the chord of the run, same shape.
    """

    level_first: NDArray[np.int32]
    moved: Floats
    deviation: Floats


def common_frame(joints: tuple[Joint, ...], a: str, b: str) -> str:
    """The link on the chain from a to b in whose frame the bound is tightest.

    Curvature comes from rotary joints that carry others; the best frame has the fewest linear
    joints, then the fewest rotary ones, beyond a rotary joint.
    """
    candidates = [a]
    link = a
    for column, sign in joints_between(joints, a, b):
        link = joints[column].child if sign > 0 else joints[column].parent
        candidates.append(link)
    return min(candidates, key=lambda frame: _carried(joints, frame, (a, b)))


def _carried(joints: tuple[Joint, ...], frame: str, ends: tuple[str, str]) -> tuple[int, int]:
    linear = rotary = 0
    for end in ends:
        turning = 0
        for column, _ in joints_between(joints, frame, end):
            if joints[column].rotary:
                rotary += turning
                turning += 1
            else:
                linear += turning
    return linear, rotary


def travelled(joints: tuple[Joint, ...], path: Path) -> tuple[Joint, ...]:
    """The joints with their limits replaced by what the path really travels."""
    if not len(path):
        return joints
    ranges = [position_ranges(path, column) for column in range(len(joints))]
    return tuple(
        replace(joint, lower=float(low.min()), upper=float(high.max()))
        for joint, (low, high) in zip(joints, ranges, strict=True)
    )


def levers(
    joints: tuple[Joint, ...], chain: list[tuple[int, int]], triangles: Floats, tree: Tree
) -> Floats:
    """Largest distance of each node from every rotary axis of its chain, shape (nodes, axes) [mm].

    Joints beyond an axis may stand anywhere within the given limits.
    """
    rows = []
    for step, (column, _) in enumerate(chain):
        if joints[column].rotary:
            rows.append(tree.highest(axis_distances(joints, column, chain[step + 1 :], triangles)))
    return np.stack(rows, axis=1) if rows else np.zeros((len(tree.left), 0))


def axis_distances(
    joints: tuple[Joint, ...], column: int, beyond: list[tuple[int, int]], triangles: Floats
) -> Floats:
    """Largest distance of each triangle from the axis of joint `column`, shape (n,) [mm].

    The joints `beyond` the axis may stand anywhere within the given limits.
    """
    axis, point = joints[column].axis, joints[column].point
    moving = [step for step in beyond if joints[step[0]].upper > joints[step[0]].lower]
    if not moving and all(joints[c].upper == joints[c].lower == 0.0 for c, _ in beyond):
        return _from_axis(triangles, axis, point).max(axis=1)
    if len(beyond) == 1 and joints[beyond[0][0]].rotary:
        return _distances_turned(joints[beyond[0][0]], axis, point, triangles)
    boxes = sweep(triangle_boxes(triangles), joints, beyond)
    corners = np.stack(
        [
            np.stack([boxes[:, i, 0], boxes[:, j, 1], boxes[:, k, 2]], axis=1)
            for i in (0, 1)
            for j in (0, 1)
            for k in (0, 1)
        ],
        axis=1,
    )
    return _from_axis(corners, axis, point).max(axis=1)


def _distances_turned(outer: Joint, axis: Floats, point: Floats, triangles: Floats) -> Floats:
    """The same when one rotary joint lies beyond: a full turn of it, in steps plus their chord."""
    points, across = triangles.reshape(-1, 3) - outer.point, _across(axis)
    squared = np.zeros(len(points))
    angles = np.arange(SWEEP_STEPS) * (360.0 / SWEEP_STEPS)
    for turn in rotation(outer.axis, angles):
        flat = points @ (turn.T @ across) + (outer.point - point) @ across
        squared = np.maximum(squared, np.einsum("ij,ij->i", flat, flat))
    farthest = np.sqrt(squared).reshape(-1, 3).max(axis=1)
    radius = _from_axis(triangles, outer.axis, outer.point).max(axis=1)
    return farthest + 2.0 * radius * np.sin(np.pi / SWEEP_STEPS / 2.0)


def _from_axis(points: Floats, axis: Floats, point: Floats) -> Floats:
    return np.asarray(np.linalg.norm((points - point) @ _across(axis), axis=-1))


def _across(axis: Floats) -> Floats:
    """Two unit vectors at right angles to a unit vector and to each other, shape (3, 2)."""
    least = np.eye(3)[np.argmin(np.abs(axis))]
    first = np.cross(axis, least)
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(axis, first)], axis=1)


def piece_motion(
    path: Path, joints: tuple[Joint, ...], first: int, end: int
) -> tuple[Floats, Floats]:
    """Displacement and deviation of single pieces, each of shape (end - first, joints).

    On an arc the deviation from the chord is at most (r dtheta^2 + 2 |dr| dtheta) / 8, and never
    more than the diameter.
    """
    scale = np.array([np.pi / 180.0 if joint.rotary else 1.0 for joint in joints])
    moved = np.abs(path.q1[first:end] - path.q0[first:end]) * scale
    deviation = np.zeros_like(moved)
    on_arc = np.flatnonzero(path.arc[first:end] >= 0)
    if len(on_arc):
        arcs = path.arcs[path.arc[first:end][on_arc]]
        sag = arc_sagitta(arcs)
        for axis, column in enumerate(path.xyz):
            if column >= 0:
                in_plane = (arcs["u"][:, axis] != 0.0) | (arcs["v"][:, axis] != 0.0)
                deviation[on_arc, column] = np.where(in_plane, sag, 0.0)
    return moved, deviation


def arc_sagitta(arcs: NDArray[np.void]) -> Floats:
    """Largest distance of each arc from its chord, bounded from above [mm]."""
    angle = np.radians(np.abs(arcs["sweep"]))
    radius = np.maximum(arcs["r0"], arcs["r1"])
    grown = np.abs(arcs["r1"] - arcs["r0"])
    return np.minimum((radius * angle**2 + 2.0 * grown * angle) / 8.0, 2.0 * radius)


def piece_ways(path: Path, joints: tuple[Joint, ...], levers: list[tuple[int, float]]) -> Floats:
    """How far two bodies move against each other from the start to the end of each piece [mm].

    Args:
        path: with n pieces.
        joints: of the path's columns.
        levers: joint and lever of every joint between the bodies, 1 for a linear one.

    Returns:
        Bounds from above, 0 at the start, shape (n + 1,).
    """
    moved, _ = piece_motion(path, joints, 0, len(path))
    on_arc = np.flatnonzero(path.arc >= 0)
    if len(on_arc):
        arcs = path.arcs[path.arc[on_arc]]
        turned = np.maximum(arcs["r0"], arcs["r1"]) * np.radians(np.abs(arcs["sweep"]))
        along = turned + np.abs(arcs["r1"] - arcs["r0"]) + np.linalg.norm(arcs["lift"], axis=1)
        for column in path.xyz:
            if column >= 0:
                moved[on_arc, column] = along
    ways = sum((lever * moved[:, joint] for joint, lever in levers), np.zeros(len(path)))
    return np.concatenate([[0.0], np.cumsum(ways)])


def dyadic_motion(
    path: Path, joints: tuple[Joint, ...], first: int, end: int, top: int
) -> MotionTables:
    """Tables of all dyadic runs of the pieces first..end up to 2^top pieces, padded at rest.

    The deviation of a run is that of its halves plus the distance of its middle from its chord.
    """
    moved, deviation = piece_motion(path, joints, first, end)
    count = ((end - first + (1 << top) - 1) >> top) << top
    scale = np.array([np.pi / 180.0 if joint.rotary else 1.0 for joint in joints])
    knots = np.vstack([path.q0[first:end], path.q1[end - 1 : end]]) * scale
    knots = np.concatenate([knots, np.repeat(knots[-1:], count + 1 - len(knots), axis=0)])
    pad = np.zeros((count - len(moved), moved.shape[1]))
    all_moved, all_deviation = [np.vstack([moved, pad])], [np.vstack([deviation, pad])]
    level_first = [0]
    for level in range(1, top + 1):
        ends = knots[:: 1 << level]
        middles = knots[1 << (level - 1) :: 1 << level]
        halves = all_deviation[-1]
        bent = np.abs(middles - 0.5 * (ends[:-1] + ends[1:]))
        level_first.append(level_first[-1] + len(all_moved[-1]))
        all_moved.append(np.abs(np.diff(ends, axis=0)))
        all_deviation.append(np.maximum(halves[::2], halves[1::2]) + bent)
    return MotionTables(
        np.array(level_first, np.int32), np.vstack(all_moved), np.vstack(all_deviation)
    )

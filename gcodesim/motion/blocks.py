"""What a block allows: its length in joint space, its limits along the path, and its corners.

A length counts the joints alike, a degree as a millimetre (what it moves at a radius of 57 mm), so
that the direction of the path is defined for every move and a corner for every two.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gcodesim.constants import LONGEST_S, TANGENT_DEG
from gcodesim.machine.model import Machine
from gcodesim.motion.joint_moves import Moves, arc_lengths, sub_arcs

Floats = NDArray[np.float64]

CENTRIPETAL_SHARE = 0.75**0.5
"""Share of the acceleration that an arc may take across the path; half of it is left along it, for
both are perpendicular: 0.75 + 0.25 = 1."""

SMALLEST_RADIUS = 1e-3
"""A spiral counts with this share of its larger radius at least: at radius 0 it could not move."""


@dataclass(frozen=True)
class Blocks:
    """n moves as the look-ahead sees them.

    Attributes:
        length: in joint space, shape (n,).
        cap: largest speed, so that feed, rates and the curvature of arcs are kept, shape (n,).
        a, j: limits of acceleration and jerk along the path; j may be infinite.
        begin, end: directions at both ends, shape (n, joints), of length 1.
    """

    length: Floats
    cap: Floats
    a: Floats
    j: Floats
    begin: Floats
    end: Floats


def blocks(moves: Moves, machine: Machine) -> Blocks:
    """Lengths, limits and directions of moves, none of which stands still."""
    way = np.abs(moves.q1 - moves.q0)
    length = np.linalg.norm(way, axis=1)
    begin = end = moves.q1 - moves.q0
    on_arc = np.flatnonzero(moves.arc >= 0)
    if len(on_arc):
        arcs = moves.arcs[moves.arc[on_arc]]
        other = np.array([c for c in range(way.shape[1]) if c not in moves.xyz], np.intp)
        rotary = np.linalg.norm(way[on_arc][:, other], axis=1)
        length[on_arc] = np.hypot(arc_lengths(arcs)[1], rotary)
        begin, end = begin.copy(), begin.copy()
        _set_tangents(begin, end, moves, on_arc)
    share = way / length[:, None]
    a = _along(share, [joint.max_acceleration for joint in machine.joints])
    j = np.full(len(moves), np.inf)
    if machine.time == "jerk":
        j = _along(share, [joint.max_jerk for joint in machine.joints])
    cap = length / np.minimum(moves.seconds, LONGEST_S)
    if len(on_arc):
        others = share[on_arc]
        others[:, [column for column in moves.xyz if column >= 0]] = 0.0
        cap[on_arc], a[on_arc], j[on_arc] = _arc_limits(
            arcs, machine, length[on_arc], cap[on_arc], others
        )
    return Blocks(length, cap, a, j, _directed(begin), _directed(end))


def _directed(vectors: Floats) -> Floats:
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def _along(share: Floats, limits: list[float | None]) -> Floats:
    """The largest value along the path that keeps every joint within its limit, shape (n,)."""
    most = np.array([limit or np.inf for limit in limits])
    ratio = np.divide(most, share, out=np.full_like(share, np.inf), where=share > 0.0)
    return np.asarray(ratio.min(axis=1, initial=np.inf))


def _set_tangents(begin: Floats, end: Floats, moves: Moves, on_arc: NDArray[np.intp]) -> None:
    """Directions of arcs at both ends, by the whole arc, written over the chords."""
    arcs = moves.arcs[moves.arc[on_arc]]
    last = sub_arcs(arcs, np.ones(len(arcs)), np.ones(len(arcs)))
    sweep = np.radians(arcs["sweep"])[:, None]
    grown = (arcs["r1"] - arcs["r0"])[:, None]
    for directions, at in ((begin, arcs), (end, last)):
        tangent = at["r0"][:, None] * sweep * at["v"] + grown * at["u"] + arcs["lift"]
        for axis, column in enumerate(moves.xyz):
            if column >= 0:
                directions[on_arc, column] = tangent[:, axis]


def _arc_limits(
    arcs: NDArray[np.void], machine: Machine, length: Floats, cap: Floats, others: Floats
) -> tuple[Floats, Floats, Floats]:
    """Limits of speed, acceleration and jerk along arcs, whose direction turns with the way.

    Along an arc of radius r the acceleration is (v', v^2/r) and the jerk
    (v'' - v^3/r^2, 3 v v'/r), along and across. With v^2/r <= 0.87 a and v' <= a/2 its vector is
    at most a; with v^3/r^2 <= j/4, v'' <= j/4 and v v'/r <= j/6 the jerk is at most j. No axis of
    the plane sees more. A spiral counts as a circle of its smaller radius: controls let the radii
    differ by hundredths of a millimetre.

    Args:
        arcs: rows of ARC_PIECE, shape (n,).
        machine: its joints.
        length: of the moves in joint space, shape (n,).
        cap: largest speeds otherwise, shape (n,).
        others: way of the joints besides X Y Z per length, shape (n, joints).
    """
    reach = np.hypot(arcs["u"], arcs["v"]) + np.abs(arcs["lift"])

    def least(limit: str) -> Floats:
        of = {joint.name: getattr(joint, limit) for joint in machine.joints}
        most = [of.get(letter) or np.inf for letter in "XYZ"]
        return np.asarray(np.where(reach > 0.0, most, np.inf).min(axis=1))

    small, large = np.minimum(arcs["r0"], arcs["r1"]), np.maximum(arcs["r0"], arcs["r1"])
    radius = np.maximum(small, SMALLEST_RADIUS * large)
    flat, whole = (x / length for x in arc_lengths(arcs))
    a, j = least("max_acceleration"), np.full(len(arcs), np.inf)
    speed = np.minimum(cap, np.sqrt(CENTRIPETAL_SHARE * a * radius) / flat)
    along = 0.5 * a
    if machine.time == "jerk":
        j = least("max_jerk")
        speed = np.minimum(speed, np.cbrt(0.25 * j * radius**2) / flat)
        along = np.minimum(along, j * radius / (6.0 * speed * flat))
        j = np.minimum(0.25 * j / whole, _along(others, [x.max_jerk for x in machine.joints]))
    most = _along(others, [joint.max_acceleration for joint in machine.joints])
    return speed, np.minimum(along / whole, most), j


def corner_speeds(
    b: Blocks, machine: Machine, tolerance: Floats, stops: NDArray[np.bool_]
) -> Floats:
    """Largest speed from each move to the next, shape (n - 1,).

    A stop is 0. With a tolerance d the corner may be rounded by a circle that leaves it by d:
    v^2 = a d s/(1 - s), s the sine of half the angle between the legs. A corner within
    TANGENT_DEG is passed as the curve that it approximates: it turns within half of both moves,
    which asks each joint for an acceleration that it has.

    Args:
        b: the moves.
        machine: its joints.
        tolerance: how far each move may leave its path [mm], shape (n,).
        stops: the move ends in a stop, shape (n,).
    """
    turn, straight = b.begin[1:] - b.end[:-1], b.begin[1:] + b.end[:-1]
    angle = 2.0 * np.arctan2(np.linalg.norm(turn, axis=1), np.linalg.norm(straight, axis=1))
    room = np.minimum(tolerance[1:], tolerance[:-1])
    a = np.minimum(b.a[1:], b.a[:-1])
    sharp = 2.0 * np.sin(angle / 4.0) ** 2
    with np.errstate(divide="ignore", over="ignore"):
        rounded = np.sqrt(a * room * np.cos(angle / 2.0) / np.where(room > 0.0, sharp, 1.0))
    most = np.array([joint.max_acceleration or np.inf for joint in machine.joints])
    jump = np.max(np.abs(turn) / most, axis=1, initial=0.0)
    between = 0.5 * (b.length[1:] + b.length[:-1])
    curved = np.sqrt(np.divide(between, jump, out=np.full_like(jump, np.inf), where=jump > 0.0))
    passed = np.where(angle <= np.radians(TANGENT_DEG), curved, 0.0)
    speed = np.minimum(np.maximum(rounded, passed), np.minimum(b.cap[1:], b.cap[:-1]))
    return np.where(stops[:-1], 0.0, speed)

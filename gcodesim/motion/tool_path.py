"""Moves of the tool's tip, cut into pieces straight in the joints, with a proved deviation.

The tip runs straight or along an arc in the part while the rotary joints run linearly in the same
parameter s, 0 to 1 over the block (great_circle.py: as the tool axis asks). The slides l(s) then
follow a curve, which is cut into N pieces that are straight in all joints and exact at their ends.

Theorem. Let the slides be the columns of a constant matrix J (they stand together in the chain of
tool_centre.py), so that J l(s) = r(s) = P(s) x(s) - T(s) z: x the tip in the part, P the turns of
the joints that carry the work, z the tip at the zero pose, T the turns of those that carry the
tool. Between the ends of a piece of length h = 1/N no point of any link stands farther than

    d = h^2/8 * c * R    from where it would on the true curve at the same s,

R the largest |r''| of the block; c = 1 for slides at right angles, else sqrt(3) |J^-1|.

Proof. The rotary joints are the same on both. For any fixed unit vector n the chord of n.r misses
n.r by at most h^2/8 max|n.r''|, hence |dr| <= h^2/8 R and |dl| <= |J^-1| |dr|. A link is moved by
the slides between it and the base, each in a direction of length 1 that the joints before it turn
rigidly: by at most sum |dl_i| <= sqrt(3) |dl|, and for slides at right angles by a part of the
orthogonal sum J dl, so by at most |dr|. The same holds between any two links, since every slide
counts once. QED

R is found by a lemma. Let y(s) be a point with |y'| <= d1, |y''| <= d2 that stays within rho of the
axis of a joint turning at the rate w [rad], |w'| <= b. Turned by it, it has |.'| <= d1 + rho w and
|.''| <= d2 + 2 w d1 + rho (w^2 + b). Applied from the tip outwards, on both sides of the slides,
and added. The distance of x to an axis is convex in x: on a straight line it is largest at an end,
on an arc not larger than at the ends of the centre's way plus the radius. Behind the first joint
the distance to the second is at most that to a point c of the first axis, which the turn keeps,
plus the distance from c to the second axis. QED

Rotary joints between the slides turn k = 1 or 2 columns of J. With W the sum of their rates, B that
of their bends, v the least |det J| of a stretch of half length g, and t the turned slides in its
middle, the theorem holds with c R replaced there by sqrt(3) L, L the largest |l''|:

    |l'| <= e = u (|r'| + a |t|) / (1 - a u g),   L = u (|r''| + 2 a e + a'' (|t| + e g)),
    a = sqrt(k) W,   a'' = sqrt(k) (W^2 + B),   1/u = 2 cos((pi + arccos v) / 3).

Proof. J l = r gives J l' = r' - J'l and J l'' = r'' - 2J'l' - J''l. Turned unit vectors have
|c'| <= W and |c''| <= W^2 + B by the lemma above with rho <= 1, so |J'l| <= a |turned slides|. The
singular values p >= q >= s of J have p^2 + q^2 + s^2 = 3, so v <= pqs <= s (3 - s^2) / 2, which
rises with s up to 1: s >= 1/u, where both are equal, and |J^-1| <= u. The turned slides differ by
at most e g from t. Each joint changes det J, a triple product of unit vectors, at most at its own
rate: v >= |det J| in the middle - W g. QED
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gcodesim.constants import LEAST_VOLUME, RIGHT_ANGLE_COSINE, TCP_DEVIATION_MM
from gcodesim.machine.kinematics import cross_matrix
from gcodesim.machine.tool_centre import ChainJoint, ToolCentre
from gcodesim.motion.path import arc_displacement

Array = NDArray[np.float64]

CHUNK = 16_384
"""Points solved at once: their arrays stay in the cache."""

MAX_PIECES = 20_000_000
"""Pieces that a program may be cut into; they take some 200 bytes each."""

STRETCHES = 16
"""Parts of a move that are bounded apart where a joint turns slides: finer ones bound closer."""


@dataclass(frozen=True)
class TipMoves:
    """n moves of the tip, in the order of execution.

    Attributes:
        row: their commands, shape (n,).
        start, end: tip [mm] and A B C [deg] in the frame of the part, shape (n, 6).
        offset: tool offset in force [mm], shape (n, 3).
        arc: row in arcs, -1 for a straight move, shape (n,).
        arcs: rows of ARC_PIECE, in the frame of the part.
        great: the tool axis runs along the great circle between its directions, shape (n,).
    """

    row: NDArray[np.intp]
    start: Array
    end: Array
    offset: Array
    arc: NDArray[np.int32]
    arcs: NDArray[np.void]
    great: NDArray[np.bool_]

    def taken(self, index: NDArray[np.intp] | slice) -> TipMoves:
        """The moves `index`."""
        return TipMoves(
            self.row[index],
            self.start[index],
            self.end[index],
            self.offset[index],
            self.arc[index],
            self.arcs,
            self.great[index],
        )

    def turns(self, centre: ToolCentre) -> NDArray[np.bool_]:
        """Whether a rotary joint between part and tool moves, shape (n,)."""
        columns = [step.column for step in centre.chain if step.joint.rotary]
        return np.asarray((self.start[:, columns] != self.end[:, columns]).any(axis=1))

    def at(self, move: NDArray[np.intp], s: Array) -> Array:
        """Tip and A B C, these running linearly, at fractions `s` of moves, shape (m, 6)."""
        start = self.start[move]
        points = start + s[:, None] * (self.end[move] - start)
        on_arc = np.flatnonzero(self.arc[move] >= 0)
        arcs = self.arcs[self.arc[move[on_arc]]]
        points[on_arc, :3] = start[on_arc, :3] + arc_displacement(arcs, s[on_arc])
        return points


@dataclass(frozen=True)
class TipPieces:
    """Pieces of tip moves: m pieces in the order of execution.

    Attributes:
        move: which of the tip moves, shape (m,).
        share: part of the time of the move, shape (m,).
        knots: tip and A B C at the start of every piece that is not the first of its move, (k, 6).
        deviation: proved bound on the distance from the true path [mm].
        straightened: moves along a great circle that the joints cannot follow, run as if linear.
    """

    move: NDArray[np.intp]
    share: Array
    knots: Array
    deviation: float
    straightened: tuple[int, ...] = ()

    @property
    def inner(self) -> NDArray[np.intp]:
        """The pieces that are not the first of their move, shape (k,)."""
        return np.flatnonzero(np.diff(self.move, prepend=-1) == 0)


def cut_evenly(
    tips: TipMoves, which: NDArray[np.intp], centre: ToolCentre, tolerance: float = TCP_DEVIATION_MM
) -> TipPieces:
    """Cut the moves `which` into equal pieces, as many as the theorem asks for `tolerance`.

    Moves beyond MAX_PIECES have none.
    """
    chosen = tips.taken(which)
    bound = np.empty(len(which))
    for first in range(0, len(which), CHUNK):
        part = slice(first, first + CHUNK)
        bound[part] = _linear_curvature(chosen.taken(part), centre)
    asked = np.maximum(np.ceil(np.sqrt(bound / (8.0 * tolerance))), 1.0)
    count = np.where(np.cumsum(asked) <= MAX_PIECES, asked, 0.0).astype(np.intp)
    move = np.repeat(np.arange(len(count)), count)
    number = np.arange(len(move)) - np.repeat(np.cumsum(count) - count, count)
    inner = np.flatnonzero(number > 0)
    knots = chosen.at(move[inner], number[inner] / count[move[inner]])
    deviation = float(np.max(bound[move] / (8.0 * count[move] ** 2), initial=0.0))
    return TipPieces(which[move], 1.0 / count[move], knots, deviation)


def _linear_curvature(tips: TipMoves, centre: ToolCentre) -> Array:
    """The bound c R of moves whose rotary joints run linearly, shape (n,); 0 where one is exact."""
    exact = ~tips.turns(centre) & ((tips.arc < 0) | at_right_angles(centre))
    rates = np.abs(np.radians(tips.end[:, 3:] - tips.start[:, 3:]))
    if not centre.between:
        return np.where(exact, 0.0, curvature(tips, centre, rates, np.zeros_like(rates)))
    move = np.repeat(np.arange(len(exact)), STRETCHES)
    s = np.tile((np.arange(STRETCHES) + 0.5) / STRETCHES, len(exact))
    stretches, rates = tips.taken(move), rates[move]
    stretch = MoveStretches(tips.at(move, s), np.full(len(move), 0.5 / STRETCHES))
    bound = curvature(stretches, centre, rates, np.zeros_like(rates), stretch)
    return np.where(exact, 0.0, bound.reshape(-1, STRETCHES).max(axis=1, initial=0.0))


def solved_axes(centre: ToolCentre, points: Array, offset: Array) -> Array:
    """Axis positions (n, 6) for tips and A B C (n, 6) with tool offsets (n, 3)."""
    axes = np.empty_like(points)
    for first in range(0, len(points), CHUNK):
        part = slice(first, first + CHUNK)
        axes[part] = centre.axes_at(points[part, :3], points[part, 3:], offset[part])
    return axes


@dataclass(frozen=True)
class MoveStretches:
    """Stretches of n moves: tip and A B C in the middle, shape (n, 6), and half the length in s."""

    middle: Array
    half: Array


def curvature(
    tips: TipMoves,
    centre: ToolCentre,
    rates: Array,
    bends: Array,
    stretch: MoveStretches | None = None,
) -> Array:
    """The bound c R of the theorem for every move, shape (n,) [mm].

    Args:
        tips: the moves.
        centre: the kinematics.
        rates: bounds on |dA/ds|, |dB/ds|, |dC/ds| [rad], shape (n, 3).
        bends: the same for the second derivatives, which add rho w' each, shape (n, 3).
        stretch: the part of every move that it is for, where joints stand between the slides.
    """
    scale = float(np.linalg.norm(centre.frame, 2))
    ends = [tips.start[:, :3], tips.end[:, :3]]
    speed = np.linalg.norm(ends[1] - ends[0], axis=1)
    bend, radius = np.zeros(len(speed)), np.zeros(len(speed))
    on_arc = np.flatnonzero(tips.arc >= 0)
    if len(on_arc):
        arcs = tips.arcs[tips.arc[on_arc]]
        r, grown = np.maximum(arcs["r0"], arcs["r1"]), np.abs(arcs["r1"] - arcs["r0"])
        sweep, lift = np.abs(np.radians(arcs["sweep"])), arcs["lift"]
        ends = [end.copy() for end in ends]
        ends[0][on_arc] -= arcs["r0"][:, None] * arcs["u"]
        ends[1][on_arc] = ends[0][on_arc] + lift
        speed[on_arc] = np.sqrt((r * sweep) ** 2 + grown**2 + np.sum(lift**2, axis=1))
        bend[on_arc], radius[on_arc] = r * sweep**2 + 2.0 * grown * sweep, r
    point = Bounded(
        [end @ centre.frame.T + centre.gauge for end in ends],
        radius * scale,
        speed * scale,
        bend * scale,
    )
    still = np.zeros(len(speed))
    held = Bounded([centre.tool_points(tips.offset)], still, still, still)
    outwards = (*reversed(centre.chain[centre.slides.stop :]), *reversed(centre.between))
    of_work = _turned_bend(centre.chain[: centre.slides.start], point, rates, bends)
    of_tool = _turned_bend(outwards, held, rates, bends)
    first, second = of_work[0] + of_tool[0], of_work[1] + of_tool[1]
    if stretch is None:
        return np.asarray(slide_factor(centre) * second)
    return _tilted_bend(tips, centre, (first, second), (rates, bends), stretch)


def _tilted_bend(
    tips: TipMoves,
    centre: ToolCentre,
    of_tip: tuple[Array, Array],
    of_joints: tuple[Array, Array],
    stretch: MoveStretches,
) -> Array:
    """The bound sqrt(3) L where joints stand between the slides, shape (n,); inf without one.

    Args:
        tips: the moves.
        centre: the kinematics.
        of_tip: bounds on |r'| and |r''|, shape (n,) each.
        of_joints: rates and bends of A B C, shape (n, 3) each.
        stretch: the part of every move that it is for.
    """
    columns = [step.column - 3 for step in centre.between]
    rate, bend = (values[:, columns].sum(axis=1) for values in of_joints)
    volume = centre.volumes(stretch.middle[:, 3:]) - rate * stretch.half
    found = np.full(len(volume), np.inf)
    k = np.flatnonzero(volume > LEAST_VOLUME)
    axes = solved_axes(centre, stretch.middle[k], tips.offset[k])
    slides = np.linalg.norm(axes[:, centre.tilted], axis=1)
    (first, second), half, rate = (values[k] for values in of_tip), stretch.half[k], rate[k]
    inverse = 0.5 / np.cos((np.pi + np.arccos(np.minimum(volume[k], 1.0))) / 3.0)
    root = float(np.sqrt(len(centre.tilted)))
    a, a2 = root * rate, root * (rate * rate + bend[k])
    left = 1.0 - a * inverse * half
    with np.errstate(divide="ignore"):
        speed = np.where(left > 0.0, inverse * (first + a * slides) / np.maximum(left, 0.0), np.inf)
    found[k] = inverse * (second + 2.0 * a * speed + a2 * (slides + speed * half))
    return np.asarray(np.sqrt(3.0) * found)


def slide_factor(centre: ToolCentre) -> float:
    """The factor c of the theorem: 1 for slides at right angles."""
    if at_right_angles(centre):
        return 1.0
    return float(np.sqrt(3.0) * np.linalg.norm(np.linalg.inv(centre.frame), 2))


def at_right_angles(centre: ToolCentre) -> bool:
    """Whether the slides are orthogonal, so that lengths in the joints are lengths in space."""
    cosines = centre.frame.T @ centre.frame - np.eye(3)
    return not centre.between and bool(np.abs(cosines).max() < RIGHT_ANGLE_COSINE)


@dataclass(frozen=True)
class Bounded:
    """A moving point: within `radius` (n,) of the line between `ends`, each (n, 3), in the world.

    `first` and `second` bound its derivatives, shape (n,).
    """

    ends: Sequence[Array]
    radius: Array
    first: Array
    second: Array


def _turned_bend(
    steps: Sequence[ChainJoint], point: Bounded, rates: Array, bends: Array
) -> tuple[Array, Array]:
    """Bounds on two derivatives of a point carried by rotary joints, the innermost first."""
    first, second = point.first, point.second
    for number, step in enumerate(steps):
        if number == 0:
            reach = point.radius + _largest(_from_axis(end, step) for end in point.ends)
        else:
            kept = _nearest_point(steps[0], step)
            reach = point.radius + _from_axis(kept[None, :], step)
            reach = reach + _largest(np.linalg.norm(end - kept, axis=1) for end in point.ends)
        rate, bend = rates[:, step.column - 3], bends[:, step.column - 3]
        second = second + 2.0 * rate * first + reach * (rate * rate + bend)
        first = first + reach * rate
    return first, second


def _largest(values: Iterable[Array]) -> Array:
    return np.asarray(np.max(np.stack(list(values)), axis=0), np.float64)


def _from_axis(points: Array, step: ChainJoint) -> Array:
    """Distances of points (n, 3) from the axis of a joint, (n,)."""
    arms = (points - step.joint.point) @ cross_matrix(step.axis).T
    return np.asarray(np.linalg.norm(arms, axis=1), np.float64)


def _nearest_point(inner: ChainJoint, outer: ChainJoint) -> Array:
    """The point of the inner axis nearest to the outer one, (3,)."""
    across = np.cross(inner.axis, outer.axis)
    away = np.cross(outer.joint.point - inner.joint.point, outer.axis)
    return np.asarray(inner.joint.point + (away @ across) / (across @ across) * inner.axis)

"""Moves whose tool axis runs along a great circle: rotary joints by the inverse at every cut.

Seen from the part the tool axis d(s) turns at the constant rate W from its first direction to its
last. Between two cuts the joints are straight, as in tool_path.py, and two things deviate: the
slides, because the true rotary joints are not linear in s, and the rotary joints themselves.

Theorem. With |q_i'| <= w_i and |q_i''| <= b_i over a piece of length h no point of any link stands
farther than h^2/8 (c R + sum_i b_i L_i) from where it would on the true curve, c R as in
tool_path.py with these w and b, L_i how far links reach from the axis of joint i.

Proof. The chord of q_i misses q_i by at most h^2/8 b_i, which moves a point by at most L_i times
that; the slides by the theorem there. QED

The rates. R(w1, q1) R(w2, q2) t = d; u = R(w1, q1) w2; sigma, tau, delta the angles of w1 to w2,
w2 to t, w1 to d; phi the angle at w2; V = (w1 x u).d, |V| = sin(sigma) sin(tau) |sin(phi)|. From
d' = q1' w1 x d + q2' u x d, |d'| = W, d'' = -W^2 d and u' = q1' w1 x u follow

    q1' V = -d'.u,   q1'' V = W^2 cos(tau) - q1'^2 m - 2 q1' q2' n,   q2' V = d'.w1,
    q2'' V = -W^2 cos(delta) - q2'^2 n,   m = cos(tau) - cos(sigma) cos(delta),
    n = cos(sigma) cos(tau) - cos(delta)

with |d'.u| <= W sin(tau) and |d'.w1| <= W sin(delta). delta changes at most by W per s; phi is a
monotone function of it, so that |V| is least and |m|, |n| are largest at the ends of its range. QED

At a pole V is 0 and nothing can be bounded: a piece that turns the tool axis by less than
POLE_STEP_RAD has straight rotary joints by definition, is cut as in tool_path.py, and takes the
time they need.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gcodesim.constants import POLE_RAD, POLE_STEP_RAD, SAME_ROTARY_DEG, TCP_DEVIATION_MM
from gcodesim.machine.model import Machine
from gcodesim.machine.tool_centre import ToolCentre
from gcodesim.motion.tool_path import (
    Array,
    MoveStretches,
    TipMoves,
    TipPieces,
    curvature,
    cut_evenly,
)

PARTS_AT_ONCE = 16
"""Parts that a piece is cut into at once; more would make pieces shorter than they must be."""

MAX_HALVES = 20_000
"""Pieces of one circle that are still too coarse: at most so many at once. A circle past a pole has
some ten; one that leaves what the joints reach has no end of them."""

LIMIT_STEP = 1.0e-8
"""Where a circle leaves a pole, its direction is asked this far from it [rad]."""

FREE_TRAVEL_MM = 10_000.0
"""What a slide without limits counts as, for how far links reach."""


@dataclass(frozen=True)
class Circles:
    """n moves whose tool axis runs along a great circle, the shorter way.

    Attributes:
        tips: the moves.
        centre: the kinematics, with two rotary joints.
        first: tool axis at the start, shape (n, 3).
        side: where it turns to, perpendicular to it, shape (n, 3).
        angle: how far it turns [rad], shape (n,).
        branch: which of the two solutions the joints follow, shape (n,).
        start, end: the rotary joints [deg], shape (n, 2).
    """

    tips: TipMoves
    centre: ToolCentre
    first: Array
    side: Array
    angle: Array
    branch: NDArray[np.intp]
    start: Array
    end: Array

    def directions(self, move: NDArray[np.intp], s: Array) -> Array:
        """Tool axis at fractions `s` of moves, shape (m, 3)."""
        turn = (self.angle[move] * s)[:, None]
        return np.asarray(np.cos(turn) * self.first[move] + np.sin(turn) * self.side[move])

    def joints(self, move: NDArray[np.intp], s: Array) -> Array:
        """Rotary joints within +-180 [deg] on the moves' own branch, shape (m, 2).

        At a pole the free joint is what it is just beside it.
        """
        directions = self.directions(move, s)
        at_pole = np.flatnonzero(self.centre.rotary.pole_angles(directions) < POLE_RAD)
        beside = np.where(s[at_pole] < 0.5, 1.0, -1.0) * LIMIT_STEP / self.angle[move[at_pole]]
        directions[at_pole] = self.directions(move[at_pole], s[at_pole] + beside)
        both, _ = self.centre.rotary.solutions(directions)
        return np.asarray(both[np.arange(len(move)), self.branch[move]])


def circles_of(tips: TipMoves, centre: ToolCentre) -> tuple[NDArray[np.intp], Circles]:
    """The moves along great circles that can stay on one solution, and their circles."""
    solver = centre.rotary
    which = np.flatnonzero(tips.great & tips.turns(centre))
    columns = [step.column for step in centre.chain if step.joint.rotary]
    start, end = tips.start[which][:, columns], tips.end[which][:, columns]
    first, last = solver.directions(start), solver.directions(end)
    normal = np.cross(first, last)
    angle = np.arctan2(np.linalg.norm(normal, axis=1), np.sum(first * last, axis=1))
    side = np.cross(normal, first)
    length = np.linalg.norm(side, axis=1)
    side = side / np.where(length > 0.0, length, 1.0)[:, None]
    signs = np.sign(np.stack([solver.tilts(start), solver.tilts(end)]))
    signs[np.abs([solver.tilts(start), solver.tilts(end)]) < SAME_ROTARY_DEG] = 0.0
    whole = (angle > POLE_STEP_RAD) & (angle < np.pi - POLE_STEP_RAD) & (signs[0] * signs[1] >= 0.0)
    branch = (signs.sum(axis=0) < 0.0).astype(np.intp)
    kept = np.flatnonzero(whole)
    circles = Circles(
        tips.taken(which[kept]), centre, first[kept], side[kept], angle[kept], branch[kept],
        start[kept], end[kept],
    )  # fmt: skip
    return which[kept], circles


def cut_moves(tips: TipMoves, centre: ToolCentre, reach: Array) -> TipPieces:
    """Cut all moves: evenly where the rotary joints run linearly, else along the great circle.

    A circle that the joints cannot follow without a jump away from a pole is run as if linear.

    Args:
        tips: the moves.
        centre: the kinematics.
        reach: how far links reach from each rotary joint, see `levers`.
    """
    every = np.arange(len(tips.row))
    if not tips.great.any() or len(centre.rotary.joints) < 2:
        return cut_evenly(tips, every, centre)
    which, circles = circles_of(tips, centre)
    round_cut = cut_circles(which, circles, reach)
    even = cut_evenly(tips, np.setdiff1d(every, round_cut.move), centre)
    moves = np.concatenate([even.move, round_cut.move])
    knots = np.zeros((len(moves), 6))
    knots[even.inner] = even.knots
    knots[len(even.move) + round_cut.inner] = round_cut.knots
    order = np.argsort(moves, kind="stable")
    share = np.concatenate([even.share, round_cut.share])[order]
    cut = TipPieces(moves[order], share, knots[order], max(even.deviation, round_cut.deviation))
    free = next(step.column for step in centre.chain if step.joint.rotary)
    bent = tips.great & (np.abs(tips.end - tips.start)[:, free] > SAME_ROTARY_DEG)
    left = np.setdiff1d(np.flatnonzero(bent), round_cut.move)
    return replace(cut, knots=cut.knots[cut.inner], straightened=tuple(left.tolist()))


def cut_circles(which: NDArray[np.intp], circles: Circles, reach: Array) -> TipPieces:
    """Cut the circles that the joints can follow; `which` are their numbers among all moves."""
    halves = halved(circles, reach)
    # Positions of a move: where it starts, where its circle does, the ends of its pieces, where it
    # ends. The circle starts or ends elsewhere where a joint has to turn on the spot, at a pole.
    count = np.bincount(halves.move, minlength=len(which)) + 3
    owner = np.repeat(np.arange(len(which)), count)
    begin = np.cumsum(count) - count
    final = begin + count - 1
    inside = np.ones(len(owner), bool)
    inside[begin] = inside[final] = False
    on_circle = inside.copy()
    on_circle[begin + 1] = False
    s, free = np.zeros(len(owner)), ~on_circle
    s[final] = 1.0
    s[on_circle], free[on_circle] = halves.end, halves.free
    joints = np.empty((len(owner), 2))
    joints[begin], joints[final] = circles.start, circles.end
    joints[inside] = _unwound(circles, owner[inside], s[inside])

    kept = np.ones(len(owner), bool)
    fits = ~halves.lost
    poles = circles.centre.rotary.pole_angles
    for there, here in ((begin, begin + 1), (final, final - 1)):
        spot = np.abs(joints[there] - joints[here]) > SAME_ROTARY_DEG
        at_pole = poles(circles.directions(owner[there], s[there])) < POLE_RAD
        fits &= ~spot.any(axis=1) | (at_pole & ~spot[:, 1])
        kept[here] = spot.any(axis=1)
    # The end of the circle is used for the end of the move where both are the same.
    free[final] = np.where(kept[final - 1], True, free[final - 1])
    has_free = np.bincount(owner, free & kept & (s > 0.0), minlength=len(which)) > 0.0
    fits &= ~has_free | (circles.tips.arc < 0)
    kept &= fits[owner]
    points = circles.tips.at(owner, s)
    columns = [step.column for step in circles.centre.chain if step.joint.rotary]
    points[:, columns] = joints
    cut = _with_spots(circles, owner[kept], s[kept], points[kept], free[kept])
    return replace(cut, move=which[cut.move], deviation=max(cut.deviation, halves.deviation))


def _with_spots(
    circles: Circles, owner: NDArray[np.intp], s: Array, points: Array, free: NDArray[np.bool_]
) -> TipPieces:
    """Pieces between positions of moves; those that end `free` are cut so that the tip holds."""
    after = np.flatnonzero(np.diff(owner, prepend=-1) == 0)
    spots = after[free[after]]
    moves = circles.tips.taken(owner[spots])
    straight = np.full(len(spots), -1, np.int32)
    moves = replace(moves, start=points[spots - 1], end=points[spots], arc=straight)
    held = cut_evenly(moves, np.arange(len(spots)), circles.centre)
    count = np.ones(len(after), np.intp)
    count[free[after]] = np.bincount(held.move, minlength=len(spots))
    piece = np.repeat(np.arange(len(after)), count)
    knots = points[after[piece] - 1]
    within = np.flatnonzero(np.diff(piece, prepend=-1) == 0)
    knots[within] = held.knots
    share = (s[after] - s[after - 1])[piece] / count[piece]
    cut = TipPieces(owner[after[piece]], share, knots, held.deviation)
    return replace(cut, knots=knots[cut.inner])


def _unwound(circles: Circles, move: NDArray[np.intp], s: Array) -> Array:
    """Joints without jumps along each move, shape (m, 2) [deg], beginning near where it starts."""
    raw = circles.joints(move, s)
    is_first = np.diff(move, prepend=-1) > 0
    step = np.diff(raw, axis=0, prepend=raw[:1])
    step -= 360.0 * np.rint(step / 360.0)
    anchor = raw[is_first]
    anchor = anchor + 360.0 * np.rint((circles.start - anchor) / 360.0)
    way = np.cumsum(step, axis=0)
    return np.asarray(way - way[is_first][move] + anchor[move])


@dataclass(frozen=True)
class Halves:
    """m pieces of n circles, in the order of execution.

    Attributes:
        move: the circle, shape (m,).
        end: where the piece ends, 0 to 1, shape (m,).
        free: the piece turns the tool axis by less than POLE_STEP_RAD and has no bound, shape (m,).
        deviation: the largest bound of the others [mm].
        lost: given up after MAX_HALVES, as a circle that leaves what the joints reach, shape (n,).
    """

    move: NDArray[np.intp]
    end: Array
    free: NDArray[np.bool_]
    deviation: float
    lost: NDArray[np.bool_]


def halved(circles: Circles, reach: Array, tolerance: float = TCP_DEVIATION_MM) -> Halves:
    """Halve circles until every piece is within the tolerance or turns less than POLE_STEP_RAD.

    A bound holds for every part of a piece: where a few equal parts are enough, they are made.
    """
    move = np.arange(len(circles.angle))
    start, length = np.zeros(len(move)), np.ones(len(move))
    moves, ends, free, deviation = [move[:0]], [start[:0]], [move[:0] > 0], 0.0
    lost = np.zeros(len(move), bool)
    while len(move):
        bound = length**2 / 8.0 * _bend(circles, move, start, length, reach)
        parts = np.ceil(np.sqrt(np.minimum(bound / tolerance, 1e12))).astype(np.intp)
        few = parts <= PARTS_AT_ONCE
        parts = np.where(few, np.maximum(parts, 1), 1)
        done = few | (circles.angle[move] * length < POLE_STEP_RAD)
        many = np.repeat(np.flatnonzero(done), parts[done])
        number = np.arange(len(many)) - np.repeat(np.cumsum(parts[done]) - parts[done], parts[done])
        share = (number + 1) / parts[many]
        moves.append(move[many])
        ends.append(start[many] + np.where(share < 1.0, share, 1.0) * length[many])
        free.append(~few[many])
        deviation = max(deviation, float(np.max((bound / parts**2)[few], initial=0.0)))
        half = 0.5 * length[~done]
        start = np.concatenate([start[~done], start[~done] + half])
        move, length = np.tile(move[~done], 2), np.tile(half, 2)
        lost |= np.bincount(move, minlength=len(lost)) > MAX_HALVES
        start, length, move = start[~lost[move]], length[~lost[move]], move[~lost[move]]
    moves.append(np.flatnonzero(lost))
    ends.append(np.ones(len(moves[-1])))
    free.append(moves[-1] < 0)
    owner, end, unbound = np.concatenate(moves), np.concatenate(ends), np.concatenate(free)
    order = np.lexsort((end, owner))
    order = order[~lost[owner[order]] | (end[order] == 1.0)]
    return Halves(owner[order], end[order], unbound[order], deviation, lost)


def _bend(
    circles: Circles, move: NDArray[np.intp], start: Array, length: Array, reach: Array
) -> Array:
    """The bound c R + sum b L of the theorem on a piece of each move, shape (m,); inf at a pole."""
    solver, turn = circles.centre.rotary, circles.angle[move]
    sigma, tau = solver.shape
    middle = solver.first_angles(circles.directions(move, start + 0.5 * length))
    half = 0.5 * turn * length
    ends = np.clip([middle - half, middle + half], 0.0, np.pi)
    cosines = np.cos(ends)
    tilts = [solver.second_angles(delta)[0] for delta in ends]
    volume = np.sin(sigma) * np.sin(tau) * np.abs(np.sin(tilts)).min(axis=0)
    across = np.where((ends < np.pi / 2.0).all(axis=0) | (ends > np.pi / 2.0).all(axis=0), 0.0, 1.0)
    across = np.maximum(across, np.sin(ends).max(axis=0))
    m = np.abs(np.cos(tau) - np.cos(sigma) * cosines).max(axis=0)
    n = np.abs(np.cos(sigma) * np.cos(tau) - cosines).max(axis=0)
    along = np.abs(cosines).max(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        w1, w2 = turn * np.sin(tau) / volume, turn * across / volume
        b1 = (turn**2 * np.abs(np.cos(tau)) + w1**2 * m + 2.0 * w1 * w2 * n) / volume
        b2 = (turn**2 * along + w2**2 * n) / volume
    known = np.flatnonzero(volume > 0.0)
    found = np.full(len(move), np.inf)
    rates, bends = np.zeros((len(known), 3)), np.zeros((len(known), 3))
    columns = [step.column - 3 for step in circles.centre.chain if step.joint.rotary]
    rates[:, columns] = np.stack([w1, w2], axis=1)[known]
    bends[:, columns] = np.stack([b1, b2], axis=1)[known]
    stretch = None
    if circles.centre.between:
        positions = circles.tips.at(move[known], (start + 0.5 * length)[known])
        joints = [step.column for step in circles.centre.chain if step.joint.rotary]
        positions[:, joints] = circles.joints(move[known], (start + 0.5 * length)[known])
        stretch = MoveStretches(positions, 0.5 * length[known])
    tips = circles.tips.taken(move[known])
    found[known] = curvature(tips, circles.centre, rates, bends, stretch)
    found[known] += bends[:, columns] @ reach
    return found


def levers(machine: Machine, centre: ToolCentre) -> Array:
    """How far links and tools reach from the axis of each rotary joint, shape (k,) [mm]."""
    return np.array([_lever(machine, j.child, j.point) for j in centre.rotary.joints])


def _lever(machine: Machine, link: str, point: Array) -> float:
    """How far what a link carries may be from a point that stands still on it [mm].

    Joints beyond it turn about their own points, slides add their travel.
    """
    parts = [part for body in machine.bodies.values() if body.link == link for part in body.parts]
    vertices = [part.triangles.reshape(-1, 3) - point for part in parts]
    far = max((float(np.linalg.norm(v, axis=1).max(initial=0.0)) for v in vertices), default=0.0)
    if machine.tool and machine.tool.link == link:
        arm = float(np.linalg.norm(machine.tool.gauge_point - point))
        tools = [part for tool in (machine.tools or {}).values() for part in tool.parts]
        sizes = [np.linalg.norm(part.triangles, axis=2).max(initial=0.0) for part in tools]
        far = max(far, arm + float(max(sizes, default=0.0)))
    for joint in machine.joints:
        if joint.parent != link:
            continue
        if joint.rotary:
            arm = float(np.linalg.norm(joint.point - point))
            far = max(far, arm + _lever(machine, joint.child, joint.point))
        else:
            travel = max(abs(joint.lower), abs(joint.upper))
            travel = travel if np.isfinite(travel) else FREE_TRAVEL_MM
            far = max(far, travel + _lever(machine, joint.child, point))
    return far

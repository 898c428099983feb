"""Corners cut between two straight blocks: ,R rounds them, ,C breaks the edge.

The corner point is recorded first, as if nothing were cut; the next straight block takes the end
of its neighbour back, puts the arc or the chamfer between them, and goes on from there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from gcodesim.constants import CORNER_REST_MM, STRAIGHT_ON_SINE
from gcodesim.nc.control.state import State
from gcodesim.nc.iso.block import Block
from gcodesim.nc.program import PLANES, Kind

INVERSE_TIME = 930


@dataclass(frozen=True)
class Corner:
    """A corner that waits for the block behind it.

    Attributes:
        row: row of the move to the corner; line, f, mode, speed: columns of that move.
        start: program point the move comes from, shape (6,).
        is_round: an arc is put in, else a chamfer.
        size: radius, or length cut off both blocks [mm].
    """

    row: int
    line: int
    f: float
    mode: int
    speed: float
    start: list[float]
    is_round: bool
    size: float


@dataclass(frozen=True)
class Way:
    """Unit vector in the plane from the corner to a point, and how far it is [mm]."""

    u: float
    v: float
    length: float


def keep_corner(state: State, block: Block, start: list[float], f: float) -> None:
    """Remember the corner at the end of the move just recorded, which came from `start`.

    Raises:
        ProgramError: there was no move, its feed is a time, or the size is not above 0.
    """
    letter, size = block.corner
    modal = state.modal
    if size <= 0.0:
        raise block.error("corner_too_large", f",{letter}{size:g}", letter)
    if state.point == start or modal.feed_mode == INVERSE_TIME:
        raise block.error("corner_not_followed", f",{letter}{size:g}", letter)
    row, length = len(state.recorder) - 1, size * state.scale
    mode = modal.feed_mode // 10
    state.corner = Corner(row, block.row, f, mode, modal.speed, start, letter == "R", length)


def cut_corner(state: State, block: Block, end: list[float]) -> None:
    """Cut the waiting corner at the current point, and stand where the move to `end` begins.

    Raises:
        ProgramError: the two moves do not lie in the plane, or are too short for the corner.
    """
    corner, state.corner = state.corner, None
    assert corner is not None
    at, (u, v, _) = state.point, PLANES[state.modal.plane]
    flat = all(corner.start[i] == at[i] == end[i] for i in range(6) if i not in (u, v))
    back, onward = (_way(at, point, u, v) for point in (corner.start, end))
    cross, dot = back.v * onward.u - back.u * onward.v, back.u * onward.u + back.v * onward.v
    is_straight = abs(cross) < STRAIGHT_ON_SINE
    if not flat or corner.row != len(state.recorder) - 1 or (is_straight and dot > 0.0):
        raise block.error("corner_not_followed", "no straight block in the plane behind a corner")
    if is_straight:
        return
    half = math.atan2(abs(cross), dot) / 2
    length = corner.size / math.tan(half) if corner.is_round else corner.size
    if length > min(back.length, onward.length) + CORNER_REST_MM:
        what = f"{length:.6g} mm of blocks of {back.length:.6g} and {onward.length:.6g} mm"
        raise block.error("corner_too_large", f"the corner takes {what}")
    state.recorder.truncate(corner.row)
    first, last = (_along(at, way, length, u, v) for way in (back, onward))
    if back.length - length > CORNER_REST_MM:
        _record(state, corner, Kind.FEED, first)
    else:
        state.position, state.point = state.frames.machine(first), first
    if onward.length - length <= CORNER_REST_MM:
        last = end
    if corner.is_round:
        chord = math.hypot(back.u + onward.u, back.v + onward.v)
        middle = Way((back.u + onward.u) / chord, (back.v + onward.v) / chord, 0.0)
        centre = _along(at, middle, corner.size / math.sin(half), u, v)
        _record(state, corner, Kind.ARC, last, _arc_row(state, centre, cross > 0.0))
    else:
        _record(state, corner, Kind.FEED, last)


def _way(at: list[float], point: list[float], u: int, v: int) -> Way:
    du, dv = point[u] - at[u], point[v] - at[v]
    length = math.hypot(du, dv)
    return Way(du / length, dv / length, length) if length else Way(0.0, 0.0, 0.0)


def _along(at: list[float], way: Way, length: float, u: int, v: int) -> list[float]:
    point = at.copy()
    point[u], point[v] = at[u] + way.u * length, at[v] + way.v * length
    return point


def _arc_row(state: State, centre: list[float], is_left: bool) -> int:
    """Record centre, normal and sense of the rounding; return its row."""
    frames, w = state.frames, PLANES[state.modal.plane][2]
    normal = frames.turn([float(i == w) for i in range(6)])[:3]
    turns = 1 if is_left != frames.mirrored else -1
    return state.recorder.add_arc_row((tuple(frames.machine(centre)[:3]), tuple(normal), turns))


def _record(state: State, corner: Corner, kind: Kind, point: list[float], arc: int = 0) -> None:
    """Record a move with what was in force at the corner, and stand at its end."""
    state.position, state.point = state.reach(point), point
    f, mode, speed = corner.f, corner.mode, corner.speed
    state.recorder.add(kind, corner.line, state.position, f=f, mode=mode, speed=speed, aux=arc)

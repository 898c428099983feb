"""Corners cut between two straight moves: rounded by an arc, or broken by a chamfer.

The corner point is recorded first, as if nothing were cut; the next straight move takes the end
of its neighbour back, puts the arc or the chamfer between them, and goes on from there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from gcodesim.constants import CORNER_REST_MM, STRAIGHT_ON_SINE
from gcodesim.nc.control.state import Corner, Edge, State
from gcodesim.nc.program import PLANES, FeedMode, Kind


@dataclass(frozen=True)
class Way:
    """Unit vector in the plane from the corner to a point, and how far it is [mm]."""

    u: float
    v: float
    length: float


def keep_corner(state: State, edge: Edge, start: list[float], f: float) -> None:
    """Remember the corner at the end of the move just recorded, which came from `start`.

    Raises:
        ProgramError: there was no move, its feed is a time, or the size is not above 0.
    """
    modal = state.modal
    if edge.size <= 0.0:
        raise state.place.error("corner_too_large", edge.text, edge.at)
    if state.point == start or modal.feed_mode == FeedMode.INVERSE_TIME:
        raise state.place.error("corner_not_followed", edge.text, edge.at)
    row = len(state.recorder) - 1
    state.corner = Corner(row, state.place.row, f, modal.feed_mode, modal.speed, start, edge)


def cut_corner(state: State, end: list[float]) -> None:
    """Cut the waiting corner at the current point, and stand where the move to `end` begins.

    Raises:
        ProgramError: the two moves do not lie in the plane, or are too short for the corner.
    """
    corner, state.corner = state.corner, None
    assert corner is not None
    edge = corner.edge
    at, (u, v, _) = state.point, PLANES[state.modal.plane]
    flat = all(corner.start[i] == at[i] == end[i] for i in range(6) if i not in (u, v))
    back, onward = (_way(at, point, u, v) for point in (corner.start, end))
    cross, dot = back.v * onward.u - back.u * onward.v, back.u * onward.u + back.v * onward.v
    is_straight = abs(cross) < STRAIGHT_ON_SINE
    if not flat or corner.row != len(state.recorder) - 1 or (is_straight and dot > 0.0):
        what = "no straight block in the plane after a corner"
        raise state.place.error("corner_not_followed", what)
    if is_straight:
        return
    half = math.atan2(abs(cross), dot) / 2
    length = edge.size / math.tan(half) if edge.is_round else edge.size
    if length > min(back.length, onward.length) + CORNER_REST_MM:
        what = f"{length:.6g} mm of blocks of {back.length:.6g} and {onward.length:.6g} mm"
        raise state.place.error("corner_too_large", f"the corner takes {what}")
    state.recorder.truncate(corner.row)
    first, last = (_along(at, way, length, u, v) for way in (back, onward))
    if back.length - length > CORNER_REST_MM:
        _record(state, corner, Kind.FEED, first)
    else:
        state.position, state.point = state.frames.machine(first), first
    if onward.length - length <= CORNER_REST_MM:
        last = end
    if edge.is_round:
        chord = math.hypot(back.u + onward.u, back.v + onward.v)
        middle = Way((back.u + onward.u) / chord, (back.v + onward.v) / chord, 0.0)
        centre = _along(at, middle, edge.size / math.sin(half), u, v)
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
    normal = frames.turn([float(i == w) for i in range(3)])
    turns = 1 if is_left != frames.mirrored else -1
    return state.recorder.add_arc_row((tuple(frames.machine(centre)[:3]), tuple(normal), turns))


def _record(state: State, corner: Corner, kind: Kind, point: list[float], arc: int = 0) -> None:
    """Record a move with what was in force at the corner, and stand at its end."""
    state.position, state.point = state.reach(point), point
    f, mode, speed = corner.f, corner.mode, corner.speed
    state.recorder.add(kind, corner.line, state.position, f=f, mode=mode, speed=speed, aux=arc)

"""Holes: a cycle of any language is a list of steps at one point, carried out one by one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

from gcodesim.nc.control.moves import FEED, RAPID, feed_of, move
from gcodesim.nc.control.state import State
from gcodesim.nc.program import PLANES, Kind, Turning


class RapidTo(NamedTuple):
    """Rapid the depth axis to a level [mm] of the program frame."""

    level: float


class FeedTo(NamedTuple):
    """Feed the depth axis to a level [mm] of the program frame."""

    level: float


class Shift(NamedTuple):
    """Rapid sideways by steps along the two axes of the plane [mm]."""

    u: float
    v: float


class Dwell(NamedTuple):
    """Stand still [s]; no time is no step."""

    seconds: float


class ManualStop(NamedTuple):
    """The program stops, and the operator withdraws the tool.

    Attributes:
        code: name of the code that asks for it.
    """

    code: str


Step = RapidTo | FeedTo | Shift | Dwell | ManualStop


class Hole(NamedTuple):
    """What the cycle in force does at every point that plain words name.

    Attributes:
        steps: from the level at which the hole is approached.
        level: the hole is approached at this level of the depth axis [mm], and left no lower;
            None = at the level where the tool stands.
        counted: how many blocks it counts as where blocks are limited.
        kept: letter of a column -> length [mm], or kind of motion, that changes nothing: a line
            with another one needs the language itself, as does one with a letter that is neither
            here nor a place.
        drills: letters of which a line has one where it makes a hole.
        is_upward: the bottom lies above the level of approach.
    """

    steps: Sequence[Step]
    level: float | None
    counted: int = 1
    kept: Mapping[str, float] = MappingProxyType({})
    drills: frozenset[str] = frozenset("XYZABC")
    is_upward: bool = False


def drill(state: State, hole: Hole, point: list[float]) -> None:
    """Go to a hole above the work, then through its steps.

    Args:
        state: of the control.
        hole: what is done there.
        point: program point; the coordinate of the depth axis is not used.
    """
    depth = PLANES[state.modal.plane][2]
    if hole.level is not None and _is_past(hole, hole.level, state.point[depth]):
        _along(state, depth, RAPID, hole.level)
    point = point.copy()
    point[depth] = state.point[depth]
    _rapid(state, point)
    if hole.level is not None:
        _along(state, depth, RAPID, hole.level)
    for step in hole.steps:
        # By type and not by `match`: holes are many, and this is twice as fast.
        if isinstance(step, FeedTo):
            _along(state, depth, FEED, step.level)
        elif isinstance(step, RapidTo):
            _along(state, depth, RAPID, step.level)
        else:
            _stand_or_shift(state, step)


def _is_past(hole: Hole, approach: float, level: float) -> bool:
    """Tell whether a level is nearer to the bottom than that of the approach."""
    return level > approach if hole.is_upward else level < approach


def turned_over(step: Step) -> Step:
    """Return a step of a hole along the other way of the depth axis."""
    return type(step)(-step.level) if isinstance(step, RapidTo | FeedTo) else step


def _along(state: State, depth: int, kind: Kind, level: float) -> None:
    """Move the depth axis to a level."""
    point = state.point.copy()
    point[depth] = level
    f = feed_of(state) if kind is FEED else 0.0
    move(state, kind, state.reach(point), f)
    state.point = point


def _stand_or_shift(state: State, step: Shift | Dwell | ManualStop) -> None:
    """Carry out a step that leaves the depth axis where it is."""
    if isinstance(step, Shift):
        i, j, _ = PLANES[state.modal.plane]
        point = state.point.copy()
        point[i], point[j] = point[i] + step.u, point[j] + step.v
        before = state.recorder.turning
        state.recorder.turn(Turning.TURNED_AWAY)
        _rapid(state, point)
        if before == Turning.TURNED_AWAY:
            # The second shift takes the first one back: the cycle starts the spindle again.
            state.recorder.turn(Turning.MAY_TURN)
    elif isinstance(step, Dwell):
        if step.seconds:
            state.recorder.add(Kind.DWELL, state.place.row, f=step.seconds)
    else:
        state.emit(Kind.STOP)
        state.report("manual_retract", step.code, step.code, subject=step.code)


def _rapid(state: State, point: list[float]) -> None:
    move(state, RAPID, state.reach(point), 0.0)
    state.point = point

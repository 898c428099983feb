"""Holes: a cycle of any language is a list of steps at one point, carried out one by one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from gcodesim.nc.control.moves import feed_of, move
from gcodesim.nc.control.state import State
from gcodesim.nc.program import PLANES, Kind


@dataclass(frozen=True, slots=True)
class RapidTo:
    """Rapid the depth axis to a level [mm] of the program frame."""

    level: float


@dataclass(frozen=True, slots=True)
class FeedTo:
    """Feed the depth axis to a level [mm] of the program frame."""

    level: float


@dataclass(frozen=True, slots=True)
class Shift:
    """Rapid sideways by steps along the two axes of the plane [mm]."""

    u: float
    v: float


@dataclass(frozen=True, slots=True)
class Dwell:
    """Stand still [s]; no time is no step."""

    seconds: float


@dataclass(frozen=True, slots=True)
class ManualStop:
    """The program stops, and the operator withdraws the tool.

    Attributes:
        code: name of the code that asks for it.
    """

    code: str


Step = RapidTo | FeedTo | Shift | Dwell | ManualStop


@dataclass(frozen=True, slots=True)
class Hole:
    """What the cycle in force does at every point that plain words name.

    Attributes:
        steps: from the level at which the hole is approached.
        level: the hole is approached at this level of the depth axis [mm], and left no lower;
            None = at the level where the tool stands.
        counted: how many blocks it counts as where blocks are limited.
        kept: letter of a column -> length [mm], or kind of motion, that changes nothing: a line
            with another one needs the language itself, as does one with a letter that is neither
            here nor a place.
    """

    steps: Sequence[Step]
    level: float | None
    counted: int = 1
    kept: Mapping[str, float] = field(default_factory=dict)


def drill(state: State, hole: Hole, point: list[float]) -> None:
    """Go to a hole above the work, then through its steps.

    Args:
        state: of the control.
        hole: what is done there.
        point: program point; the coordinate of the depth axis is not used.
    """
    depth = PLANES[state.modal.plane][2]
    if hole.level is not None and state.point[depth] < hole.level:
        _along(state, Kind.RAPID, hole.level)
    point = point.copy()
    point[depth] = state.point[depth]
    _rapid(state, point)
    if hole.level is not None:
        _along(state, Kind.RAPID, hole.level)
    for step in hole.steps:
        _carry_out(state, step)


def _carry_out(state: State, step: Step) -> None:
    match step:
        case FeedTo(level):
            _along(state, Kind.FEED, level)
        case RapidTo(level):
            _along(state, Kind.RAPID, level)
        case Dwell(seconds):
            if seconds:
                state.recorder.add(Kind.DWELL, state.place.row, f=seconds)
        case Shift(u, v):
            i, j, _ = PLANES[state.modal.plane]
            point = state.point.copy()
            point[i], point[j] = point[i] + u, point[j] + v
            _rapid(state, point)
        case ManualStop(code):
            state.emit(Kind.STOP)
            state.report("manual_retract", code, code, subject=code)


def _along(state: State, kind: Kind, level: float) -> None:
    """Move the depth axis to a level."""
    point = state.point.copy()
    point[PLANES[state.modal.plane][2]] = level
    f = feed_of(state) if kind == Kind.FEED else 0.0
    move(state, kind, state.reach(point), f)
    state.point = point


def _rapid(state: State, point: list[float]) -> None:
    move(state, Kind.RAPID, state.reach(point), 0.0)
    state.point = point

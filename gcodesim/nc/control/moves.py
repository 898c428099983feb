"""Moves: rapid, feed, arc, probe, by way of a point to axis positions, back along the tool."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from enum import Enum

from gcodesim.nc.control.arcs import ArcError, Point, centre_from_radius, check_centre
from gcodesim.nc.control.corners import cut_corner, keep_corner
from gcodesim.nc.control.modal import TipControl
from gcodesim.nc.control.skips import Skipped
from gcodesim.nc.control.state import Edge, State
from gcodesim.nc.control.tips import rotary_for, tool_direction, way_back
from gcodesim.nc.control.wrap import unwound
from gcodesim.nc.program import AXES, PLANES, FeedMode, Frame, Kind

SQUARE_RAD = 1e-4
"""A tool this near to the normal of a tilted plane stands on it [rad]: angles have 3 decimals."""

# Members of an Enum take many times as long to look up as names of a module.
OFF = TipControl.OFF
INVERSE_TIME, PER_MINUTE = FeedMode.INVERSE_TIME, FeedMode.PER_MINUTE
PER_REVOLUTION = FeedMode.PER_REVOLUTION
RAPID, FEED = Kind.RAPID, Kind.FEED

Words = Mapping[int, float]
"""Index in program.AXES -> value [mm or deg]."""


class How(Enum):
    """What the value of an axis word counts from, and which way a rotary axis turns to it."""

    ABSOLUTE = ""  # as Control.wrap says of a rotary axis
    INCREMENTAL = "incremental"
    SHORTEST = "shortest"
    POSITIVE = "+"
    NEGATIVE = "-"


def point_to(state: State, words: Words, how: Mapping[int, How] | None = None) -> list[float]:
    """Return the program point that axis words name; axes left out keep their value.

    Args:
        state: of the control.
        words: values.
        how: axis index -> how its value is meant, where it is not as Modal.incremental says.
    """
    if state.frames.carried is not None:
        _carry_offset(state, words, how)
    point, wraps = state.point.copy(), state.wraps
    if state.skipped is not None:
        state.tell(i for i in words if _is_own(state, (how or {}).get(i)))
    if how:
        for i, value in words.items():
            point[i] = _meant(state, i, value, how.get(i), point)
    elif state.modal.incremental:
        for i, value in words.items():
            point[i] += value
    elif wraps:
        for i, value in words.items():
            point[i] = _unwound(state, i, value, point) if AXES[i] in wraps else value
    else:
        for i, value in words.items():
            point[i] = value
    return point


def _is_own(state: State, how: How | None) -> bool:
    """Tell whether a value is a position, and not a step."""
    return not state.modal.incremental if how is None else how is not How.INCREMENTAL


def _meant(state: State, i: int, value: float, how: How | None, point: list[float]) -> float:
    """Return the coordinate that one word names."""
    if how is None:
        how = How.INCREMENTAL if state.modal.incremental else How.ABSOLUTE
    match how:
        case How.INCREMENTAL:
            return point[i] + value
        case How.ABSOLUTE:
            return _unwound(state, i, value, point) if AXES[i] in state.wraps else value
        case How.SHORTEST:
            return _unwound(state, i, value, point, "shortest")
    sense = 1.0 if how is How.POSITIVE else -1.0
    return unwound(math.copysign(value % 360.0, sense), point[i], "sign", -math.inf, math.inf)


def _unwound(state: State, i: int, value: float, origin: list[float], wrap: str = "") -> float:
    """Return the angle a rotary word means; origin is the current point in the word's frame."""
    letter, shift = AXES[i], state.position[i] - origin[i]
    lower, upper = state.control.travel.get(letter, (-math.inf, math.inf))
    wrap = wrap or state.wraps[letter]
    return unwound(value, origin[i], wrap, lower - shift, upper - shift)


def _carry_offset(state: State, words: Words, how: Mapping[int, How] | None) -> None:
    """Under a table offset rotary words come first, and the linear ones after them.

    The table carries the work offset along; a linear axis that has no word stays where it is.
    """
    frames = state.frames
    frames.carried = None
    point = point_to(state, {i: value for i, value in words.items() if i > 2}, how)
    state.carry_offset(frames.machine(point)[3:])
    frames.update()
    state.point[:3] = state.frames.program(state.position)[:3]


def machine_point(state: State, words: Words) -> list[float]:
    """Return the axis positions that words in machine coordinates name."""
    axes = state.axes.copy()
    state.tell(words)
    for i, value in words.items():
        axes[i] = _unwound(state, i, value, axes) if AXES[i] in state.wraps else value
    return axes


def aim_tool(state: State, point: list[float], vector: Sequence[float]) -> None:
    """Let a point have the rotary positions that hold the tool along a direction.

    Args:
        state: of the control, which knows the kinematics of the machine.
        point: program point, changed.
        vector: from the tip towards the spindle, in the program frame.
    """
    kinematics = state.control.kinematics
    assert kinematics is not None
    held = state.position[3:]
    turned = rotary_for(kinematics, state.frames.turn(vector), held)
    for i, (angle, before) in enumerate(zip(turned, held, strict=True), start=3):
        point[i] += angle - before


def straight(state: State, kind: Kind, point: list[float], edge: Edge | None = None) -> None:
    """Move straight to a program point.

    Args:
        state: of the control.
        kind: RAPID or FEED.
        point: where to.
        edge: what becomes of the corner at the end of a feed move; None = it stays sharp.
    """
    start = state.point
    if state.corner is not None and kind == FEED:
        cut_corner(state, point)
        start = state.point
    position = state.reach(point)
    tilted = state.frames.tilted and state.modal.tip_control is OFF
    if tilted and position[3:] != state.position[3:]:
        # No tip tracking here: the joints run straight to where the tip is on the plane again.
        straight_to_axes(state, kind, state.axes_of(position))
        return
    f = _feed_to(state, kind, position, state.position)
    move(state, kind, position, f)
    state.point = point
    if edge is not None and kind == FEED:
        keep_corner(state, edge, start, f)


def straight_to_axes(state: State, kind: Kind, axes: list[float]) -> None:
    """Move straight in the joints to axis positions, whatever is switched on."""
    move_axes(state, kind, axes, _feed_to(state, kind, axes, state.axes))


def through(state: State, middle: list[float], ends: Words) -> None:
    """Rapid by way of a program point, then some axes to their positions.

    Args:
        state: of the control.
        middle: program point.
        ends: axis index -> axis position; other axes stay after the program point.
    """
    position = state.reach(middle)
    if state.frame is Frame.MACHINE:
        move(state, RAPID, position, 0.0)
    else:
        move_axes(state, RAPID, state.axes_of(position))
    axes = state.axes.copy()
    state.tell(ends)
    for i, value in ends.items():
        axes[i] = _back_to(state, i, value, axes)
    move_axes(state, RAPID, axes)


def _back_to(state: State, i: int, value: float, axes: list[float]) -> float:
    """Return where an axis comes to stand that returns to a position, perhaps turns away."""
    if AXES[i] not in state.wraps:
        return value
    near = _unwound(state, i, value, axes)
    if near == value or state.reading("g28_rotary") == "unwind":
        return value
    return near


def retract(state: State, distance: float | None) -> None:
    """Rapid back along the tool, the rotary axes standing still.

    Args:
        state: of the control.
        distance: how far [mm]; None = as far as the travel of the slides allows.

    Raises:
        ProgramError: the machine file lacks the travel that is asked for.
    """
    axes, kinematics = state.axes, state.control.kinematics
    along = [0.0, 0.0, 1.0] if kinematics is None else way_back(kinematics, axes[3:])
    if distance is None:
        distance = _room(state, axes, along)
    ends = [a + distance * way for a, way in zip(axes[:3], along, strict=True)]
    move_axes(state, RAPID, [*ends, *axes[3:]])


def _room(state: State, axes: list[float], along: Sequence[float]) -> float:
    """Return how far the slides can go along a direction inside their travel [mm]."""
    room = math.inf
    for letter, at, way in zip(AXES, axes, along, strict=False):
        lower, upper = state.control.travel.get(letter, (-math.inf, math.inf))
        if way:
            room = min(room, ((upper if way > 0.0 else lower) - at) / way)
    if math.isinf(room):
        raise state.place.error("retract_unknown", "a way back to the end of the travel")
    return max(room, 0.0)


def retract_axes(state: State, letters: str) -> None:
    """Rapid some axes to their retract positions together.

    Raises:
        ProgramError: the machine file lacks one of them.
    """
    axes, known = state.axes.copy(), state.control.retract
    for letter in letters:
        if letter not in known:
            raise state.place.error("retract_unknown", f"the retract position of {letter}")
        axes[AXES.index(letter)] = known[letter]
    state.tell(map(AXES.index, letters))
    move_axes(state, RAPID, axes)


def in_step(state: State, point: list[float], pitch: float, *, back: bool) -> None:
    """Feed straight in step with the spindle; a tap comes back the same way.

    How far it runs on while the spindle is reversed is not known, and not in the path.

    Args:
        state: of the control.
        point: program point, where to.
        pitch: way of one turn [mm].
        back: return to where it began.

    Raises:
        ProgramError: the spindle has no speed.
    """
    if not state.modal.speed:
        what = "a move in step with a spindle without speed"
        raise state.place.error("feed_per_rev_no_spindle", what)
    start, position = state.position, state.reach(point)
    mode, state.modal.feed_mode = state.modal.feed_mode, PER_REVOLUTION
    move(state, FEED, position, pitch)
    if back:
        move(state, FEED, start, pitch)
    else:
        state.point = point
    state.modal.feed_mode = mode


def move(state: State, kind: Kind, position: list[float], f: float) -> None:
    """Record a straight move to a position; one of no length is left out."""
    if state.unfollowed:
        raise state.refusal()
    if position != state.position or state.skipped is not None:
        if state.frames.tilted and state.modal.tip_control is OFF:
            check_square(state)
        _record(state, kind, state.position, position, f)
        state.position = position


def move_axes(state: State, kind: Kind, axes: list[float], f: float = 0.0) -> None:
    """Record a move that is straight in the joints, to axis positions, whatever is switched on."""
    if state.unfollowed:
        raise state.refusal()
    start = state.axes
    if axes != start or state.skipped is not None:
        state.recorder.switch(Frame.MACHINE)
        _record(state, kind, start, axes, f)
    state.stand(axes)


def _record(state: State, kind: Kind, start: list[float], end: list[float], f: float) -> None:
    """Record a straight move; after a skip move, as far as it is known where it begins."""
    modal, row, recorder = state.modal, state.place.row, state.recorder
    ends = [end]
    if state.clamped_by and start[3:] != end[3:]:
        turned = next(AXES[i] for i in range(3, 6) if start[i] != end[i])
        code = state.clamped_by
        state.report("clamped_axis", f"{turned} turns after {code}", turned, subject=code)
    if state.skipped is not None:
        ends = _after_skip(state, start, end)
        if ends:
            recorder.may_touch()
    for to in ends:
        recorder.add(kind, row, to, f=f, mode=modal.feed_mode, speed=modal.speed)


def _after_skip(state: State, start: list[float], end: list[float]) -> list[list[float]]:
    """Return the ends of a move after a skip move, of which the first may touch all the way."""
    skipped = state.skipped
    assert skipped is not None
    told = skipped.told & skipped.axes
    if start == end and not told:
        return []
    ends = skipped.way_back(start, end) if state.recorder.frame == skipped.frame else []
    if not ends or (len(ends) > 1 and state.modal.feed_mode == INVERSE_TIME):
        state.report("position_unknown", "a move that begins where a probe has stopped")
        skipped.shift(start, end)
        ends = [end] if start != end else []
    skipped.axes -= told
    skipped.told.clear()
    if not skipped.axes:
        state.skipped = None
    return ends


def check_square(state: State) -> None:
    """Report a tool that does not stand square on the tilted plane it moves in."""
    kinematics = state.control.kinematics
    if state.on_plane is None and kinematics is not None:
        normal = state.frames.turn([0.0, 0.0, 1.0])
        held = tool_direction(kinematics, state.position[3:])
        state.on_plane = math.dist(normal, held) < SQUARE_RAD
    if not state.on_plane:
        what = "move in a tilted plane with the tool not square on it"
        state.report("tilted_plane_not_square", what)


def _feed_to(state: State, kind: Kind, end: list[float], start: list[float]) -> float:
    """Return the feed of a straight move, 0 for a rapid one."""
    return feed_of(state, end[:3] == start[:3]) if kind == FEED else 0.0


def feed_of(state: State, rotary_only: bool = False, *, cutting: bool = True) -> float:
    """Return the feed of a move as the feed mode counts it, lengths in mm.

    Raises:
        ProgramError: it is missing, or a feed per revolution has no spindle speed.
    """
    modal, place, mode = state.modal, state.place, state.modal.feed_mode
    feed = modal.feed if rotary_only else (modal.feed or 0.0) * modal.feed_scale
    if mode == INVERSE_TIME:
        feed = state.line_feed
        if not feed:
            raise place.error("inverse_feed_missing", "inverse time feed without F")
    elif not feed and mode == PER_MINUTE and not modal.feed_given:
        feed = state.control.feed
    if not feed:
        raise place.error("feed_missing", "feed move without F")
    if rotary_only and modal.tip_control is not OFF and mode == PER_MINUTE:
        feed = state.control.readings.tcp_rotary_feed or feed
    if mode == PER_REVOLUTION and not modal.speed:
        raise place.error("feed_per_rev_no_spindle", "feed per revolution without a spindle speed")
    if cutting and not modal.spindle_turns and not state.has_reported("spindle_off_feed"):
        state.report("spindle_off_feed", "feed move with the spindle off")
    return feed


def arc(
    state: State,
    end: list[float],
    *,
    clockwise: bool,
    centre: Point | None = None,
    radius: float = 0.0,
    turns: int = 1,
) -> None:
    """Move along an arc of the active plane, or a helix.

    Args:
        state: of the control.
        end: program point.
        clockwise: as seen from the positive end of the plane's normal.
        centre: u and v of the plane [mm]; None = the radius decides.
        radius: [mm], below 0 for the way beyond 180 degrees.
        turns: turns begun, 1 for an arc below or of a full turn.

    Raises:
        ProgramError: the arc cannot be traced, or nothing is known that it needs.
    """
    frames, modal = state.frames, state.modal
    tilted = frames.tilted and modal.tip_control is OFF
    if tilted and end[3:] != state.point[3:]:
        raise state.place.error("rotary_arc_in_tilted_plane", "an arc with rotary words")
    u, v, w = PLANES[modal.plane]
    try:
        centre_u, centre_v = _centre(state, end, clockwise, centre, radius)
    except ArcError as error:
        raise state.place.error(error.meaning, str(error)) from None
    middle, normal = end.copy(), [0.0] * 3
    middle[u], middle[v], normal[w] = centre_u, centre_v, 1.0
    sense = -turns if clockwise != frames.mirrored else turns
    row = tuple(frames.machine(middle)[:3]), tuple(frames.turn(normal)), sense
    if state.unfollowed:
        raise state.refusal()
    if tilted:
        check_square(state)
    f = feed_of(state)
    start, state.position = state.position, state.reach(end)
    state.point = end
    if state.skipped is not None:
        _after_skip(state, start, state.position)
        state.recorder.may_touch()
    state.recorder.add(
        Kind.ARC,
        state.place.row,
        state.position,
        f=f,
        mode=modal.feed_mode,
        speed=modal.speed,
        aux=state.recorder.add_arc_row(row),
    )


def _centre(
    state: State, end: list[float], clockwise: bool, centre: Point | None, radius: float
) -> Point:
    """Return the centre (u, v) [mm] of an arc that can be traced."""
    u, v, _ = PLANES[state.modal.plane]
    first, last = (state.point[u], state.point[v]), (end[u], end[v])
    tolerance = state.control.readings.arc
    if centre is None:
        return centre_from_radius(first, last, radius, clockwise, tolerance)
    try:
        check_centre(first, last, centre, tolerance, state.modal.inch)
    except ArcError as error:
        if error.meaning != "arc_radius_mismatch" or state.reading("arc_radii") == "alarm":
            raise
    return centre


def probe(state: State, point: list[float], feed: float = 0.0) -> None:
    """Feed to a program point with a probe, which may touch and stop on the way.

    Args:
        state: of the control.
        point: where to.
        feed: [mm/min]; 0 = the one in force.
    """
    start, position = state.position, state.reach(point)
    rotary_only = position[:3] == start[:3]
    f = feed or feed_of(state, rotary_only, cutting=False)
    if state.unfollowed:
        raise state.refusal()
    moved = {i for i in range(6) if point[i] != state.point[i]}
    state.point = point
    if not moved:
        return
    modal, known = state.modal, state.skipped
    mode = PER_MINUTE if feed else modal.feed_mode
    state.recorder.may_touch()
    state.recorder.add(FEED, state.place.row, position, f=f, mode=mode, speed=modal.speed)
    state.position = position
    if known is not None and known.go_on(position, moved):
        return
    if known is not None:
        state.report("position_unknown", "a skip move that begins where another has stopped")
    state.skipped = Skipped(start, position, state.recorder.frame, moved)

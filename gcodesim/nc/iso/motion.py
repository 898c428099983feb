"""What moves the axes: rapids, feeds, arcs, and the return to the reference point."""

from __future__ import annotations

import math

from gcodesim.nc.control.arcs import CENTRE_WORDS, ArcError, Point, centre_from_radius, check_centre
from gcodesim.nc.control.corners import cut_corner, keep_corner
from gcodesim.nc.control.state import State
from gcodesim.nc.control.tips import rotary_for, tool_direction
from gcodesim.nc.control.wrap import unwound
from gcodesim.nc.iso.block import Block
from gcodesim.nc.iso.offsets import axis_values
from gcodesim.nc.program import AXES, PLANES, Frame, Kind

INDEX = {letter: i for i, letter in enumerate(AXES)}

VECTORS = 435

MOST_TURNS = 1_000_000
"""Largest P of an arc; nobody cuts a thread of more turns."""

SQUARE_RAD = 1e-4
"""A tool this near to the normal of a tilted plane stands on it [rad]: angles have 3 decimals."""


def target(state: State, block: Block) -> list[float]:
    """Return the program point the axis words name; letters left out keep their value."""
    if state.frames.carried is not None:
        _carry_offset(state, block)
    point = state.point.copy()
    incremental = state.modal.distance == 910
    scale, wraps = state.scale, state.wraps
    for letter, value in block.values.items():
        if letter in INDEX:
            i = INDEX[letter]
            length = value * scale if i < 3 else value
            if incremental:
                point[i] += length
            else:
                point[i] = _unwound(state, i, value, point) if letter in wraps else length
    if state.modal.polar == 160:
        _apply_polar(state, block, point)
    if state.modal.tcp == VECTORS:
        _apply_vector(state, block, point)
    return point


def _carry_offset(state: State, block: Block) -> None:
    """Under a table offset (G254) rotary words come first, and the linear ones behind them.

    The table carries the work offset along; a linear axis that has no word stays where it is.
    """
    rotary = state.point.copy()
    for letter in "ABC":
        if letter in block.values:
            i = INDEX[letter]
            value = block.values[letter]
            if state.modal.distance == 910:
                rotary[i] += value
            else:
                rotary[i] = _unwound(state, i, value, rotary) if letter in state.wraps else value
    state.carry_offset(state.frames.machine(rotary)[3:])
    state.frames.update()
    state.point[:3] = state.frames.program(state.position)[:3]


def _apply_vector(state: State, block: Block, point: list[float]) -> None:
    """G43.5: I J K is the direction of the tool in the program frame, and rotary words are none."""
    words, kinematics = block.values, state.control.kinematics
    if rotary := next((letter for letter in "ABC" if letter in words), ""):
        raise block.error("unused_word", f"{rotary} under G43.5, which takes I J K", rotary)
    if kinematics is None or not words.keys() & set(CENTRE_WORDS):
        return
    vector = [words.get(letter, 0.0) for letter in CENTRE_WORDS]
    if not any(vector):
        raise block.error("direction_zero", "I, J and K are 0", "I")
    direction = state.frames.turn([*vector, 0.0, 0.0, 0.0])[:3]
    held = state.position[3:]
    turned = rotary_for(kinematics, direction, held)
    for i, (angle, before) in enumerate(zip(turned, held, strict=True), start=3):
        point[i] += angle - before


def _apply_polar(state: State, block: Block, point: list[float]) -> None:
    """G16: the first word of the plane is a radius, the second an angle, and replace the point.

    A radius in G91 makes the current point the pole; one in G90 takes program zero.
    """
    modal, words = state.modal, block.values
    u, v, _ = PLANES[modal.plane]
    incremental = modal.distance == 910
    if AXES[u] not in words and AXES[v] not in words:
        return
    if AXES[u] in words:
        modal.pole = (state.point[u], state.point[v]) if incremental else (0.0, 0.0)
        modal.radius = words[AXES[u]] * state.scale
    if AXES[v] in words:
        modal.angle = words[AXES[v]] + (modal.angle if incremental else 0.0)
    angle = math.radians(modal.angle)
    point[u] = modal.pole[0] + modal.radius * math.cos(angle)
    point[v] = modal.pole[1] + modal.radius * math.sin(angle)


def set_polar(state: State, block: Block, number: int) -> None:
    """G15 G16: polar words begin at the current point."""
    modal = state.modal
    modal.polar = number
    u, v, _ = PLANES[modal.plane]
    modal.pole = (0.0, 0.0)
    modal.radius = math.hypot(state.point[u], state.point[v])
    modal.angle = math.degrees(math.atan2(state.point[v], state.point[u]))


def plane_target(state: State, block: Block) -> list[float]:
    """Return the program point the words of the active plane name: where a cycle makes a hole."""
    point, w = target(state, block), PLANES[state.modal.plane][2]
    point[w] = state.point[w]
    return point


def _unwound(state: State, i: int, value: float, origin: list[float]) -> float:
    """Return the angle a rotary word means; origin is the current point in the word's frame."""
    letter, shift = AXES[i], state.position[i] - origin[i]
    lower, upper = state.control.travel.get(letter, (-math.inf, math.inf))
    return unwound(value, origin[i], state.wraps[letter], lower - shift, upper - shift)


def straight(state: State, block: Block, number: int) -> None:
    """G0 G1, with G53 in machine coordinates; without axis words only the mode changes."""
    state.modal.motion, state.modal.cycle = number, 0
    if not block.moves:
        return
    kind = Kind.FEED if number else Kind.RAPID
    if block.has("G", 530):
        axes = _machine_target(state, block)
        move_axes(state, block, kind, axes, _feed_to(state, block, kind, axes, state.axes))
        return
    start = state.point
    point = target(state, block)
    if state.corner is not None and number:
        cut_corner(state, block, point)
        start = state.point
    position = state.reach(point)
    tilted = state.frames.tilt is not None and not state.modal.tcp
    if tilted and position[3:] != state.position[3:]:
        # No tip tracking here: the joints run straight to where the tip is on the plane again.
        axes = state.axes_of(position)
        move_axes(state, block, kind, axes, _feed_to(state, block, kind, axes, state.axes))
        return
    f = _feed_to(state, block, kind, position, state.position)
    move(state, block, kind, position, f)
    state.point = point
    if block.corner[0] and number:
        keep_corner(state, block, start, f)


def _feed_to(state: State, block: Block, kind: Kind, end: list[float], start: list[float]) -> float:
    """Return the feed of a straight move, 0 for a rapid one."""
    return feed_of(state, block, end[:3] == start[:3]) if kind == Kind.FEED else 0.0


def move(state: State, block: Block, kind: Kind, position: list[float], f: float) -> None:
    """Record a straight move to a position; one of no length is left out."""
    if state.unfollowed:
        raise state.refusal(block)
    if position != state.position:
        if state.frames.tilt is not None and not state.modal.tcp:
            _look_at_plane(state, block)
        modal = state.modal
        mode = modal.feed_mode // 10
        state.recorder.add(kind, block.row, position, f=f, mode=mode, speed=modal.speed)
        state.position = position


def move_axes(state: State, block: Block, kind: Kind, axes: list[float], f: float = 0.0) -> None:
    """Record a move that is straight in the joints, to axis positions, whatever is switched on."""
    if state.unfollowed:
        raise state.refusal(block)
    if axes != state.axes:
        modal = state.modal
        mode = modal.feed_mode // 10
        state.recorder.switch(Frame.MACHINE)
        state.recorder.add(kind, block.row, axes, f=f, mode=mode, speed=modal.speed)
    state.stand(axes)


def _look_at_plane(state: State, block: Block) -> None:
    """Report a tool that does not stand square on the tilted plane it moves in."""
    kinematics = state.control.kinematics
    if state.on_plane is None and kinematics is not None:
        normal = state.frames.turn([0.0, 0.0, 1.0, 0.0, 0.0, 0.0])[:3]
        held = tool_direction(kinematics, state.position[3:])
        state.on_plane = math.dist(normal, held) < SQUARE_RAD
    if not state.on_plane:
        what = "move in a tilted plane with the tool not square on it"
        state.report(block.finding("tilted_plane_not_square", what))


def _machine_target(state: State, block: Block) -> list[float]:
    if state.modal.distance == 910:
        raise block.error("g53_incremental", "G53 under G91", "G53")
    axes = state.axes.copy()
    for i, value in axis_values(state, block).items():
        wraps = AXES[i] in state.wraps
        axes[i] = _unwound(state, i, value, axes) if wraps else value
    return axes


def feed_of(
    state: State, block: Block, rotary_only: bool = False, *, cutting: bool = True
) -> float:
    """Return the feed of a move as the feed mode counts it, lengths in mm.

    Raises:
        ProgramError: it is missing, or G95 has no spindle speed.
    """
    modal = state.modal
    feed = modal.feed if rotary_only else (modal.feed or 0.0) * modal.feed_scale
    if modal.feed_mode == 930:
        feed = block.values.get("F")
        if not feed:
            raise block.error("inverse_feed_missing", "no F in a G93 block")
    elif not feed and modal.feed_mode == 940 and not modal.feed_given:
        feed = state.control.feed
    if not feed:
        raise block.error("feed_missing", "feed move without F")
    if rotary_only and modal.tcp and modal.feed_mode == 940:
        feed = state.control.readings.tcp_rotary_feed or feed
    if modal.feed_mode == 950 and not modal.speed:
        raise block.error("feed_per_rev_no_spindle", "G95 with S0")
    if cutting and modal.spindle not in (30, 40) and not state.has_reported("spindle_off_feed"):
        what = "feed move with the spindle off"
        state.report(block.finding("spindle_off_feed", what))
    return feed


def arc(state: State, block: Block, number: int) -> None:
    """G2 G3 in the active plane, with centre words or R, P turns and a helix."""
    state.modal.motion, state.modal.cycle = number, 0
    if not block.moves:
        return
    if block.has("G", 530):
        raise block.error("axis_without_motion", "G53 with an arc", "G53")
    u, v, w = PLANES[state.modal.plane]
    end = target(state, block)
    if state.frames.tilt is not None and not state.modal.tcp and end[3:] != state.point[3:]:
        raise block.error("rotary_arc_in_tilted_plane", "an arc with rotary words")
    clockwise = number == 20
    turns = _turns(block)
    try:
        centre_u, centre_v = _centre(state, block, end, clockwise)
    except ArcError as error:
        raise block.error(error.meaning, str(error)) from None
    centre, normal = end.copy(), [0.0] * 6
    centre[u], centre[v], normal[w] = centre_u, centre_v, 1.0
    frames, modal = state.frames, state.modal
    row = (
        tuple(frames.machine(centre)[:3]),
        tuple(frames.turn(normal)[:3]),
        -turns if clockwise != frames.mirrored else turns,
    )
    if state.unfollowed:
        raise state.refusal(block)
    if frames.tilt is not None and not modal.tcp:
        _look_at_plane(state, block)
    f = feed_of(state, block)
    state.position = state.reach(end)
    state.point = end
    state.recorder.add(
        Kind.ARC,
        block.row,
        state.position,
        f=f,
        mode=modal.feed_mode // 10,
        speed=modal.speed,
        aux=state.recorder.add_arc_row(row),
    )


def _turns(block: Block) -> int:
    turns = block.values.get("P", 1.0)
    if not 1 <= turns <= MOST_TURNS or not turns.is_integer():
        raise block.error("arc_turns", f"P{turns:g}", "P")
    return int(turns)


def _centre(state: State, block: Block, end: list[float], clockwise: bool) -> Point:
    """Return the centre (u, v) [mm] in the program frame."""
    u, v, w = PLANES[state.modal.plane]
    start, scale, words = state.point, state.scale, block.values
    # Under G43.5 I J K is the direction of the tool, so that only R is left for arcs.
    vectors = state.modal.tcp == VECTORS
    given = [letter for letter in CENTRE_WORDS if letter in words and not vectors]
    if "R" in words and (not given or state.control.readings.r_and_ijk == "r_wins"):
        radius = words["R"] * scale
        tolerance = state.control.readings.arc
        return centre_from_radius(
            (start[u], start[v]), (end[u], end[v]), radius, clockwise, tolerance
        )
    if "R" in words:
        raise block.error("arc_r_and_center", "R and centre words", "R")
    if CENTRE_WORDS[w] in given:
        raise block.error("arc_wrong_center_word", CENTRE_WORDS[w], CENTRE_WORDS[w])
    absolute = state.modal.centre_distance == 901
    if not given or (absolute and len(given) < 2):
        raise block.error("arc_no_center", "arc without centre")
    offset_u, offset_v = (words.get(CENTRE_WORDS[i], 0.0) * scale for i in (u, v))
    centre = (offset_u, offset_v) if absolute else (start[u] + offset_u, start[v] + offset_v)
    inch = state.modal.unit == 200
    check_centre((start[u], start[v]), (end[u], end[v]), centre, state.control.readings.arc, inch)
    return centre


def store_reference(state: State, block: Block, number: int) -> None:
    """G28.1 G30.1: the current position becomes the reference point."""
    state.reference[f"G{number // 10}"] = dict(zip(AXES, state.axes, strict=True))


def probe(state: State, block: Block, number: int) -> None:
    """G31 G38.x: a feed move, for contact is never made; the motion mode stays."""
    if not block.moves:
        raise block.error("axis_missing", f"G{number / 10:g} without axis words")
    if block.has("G", 530):
        raise block.error("axis_without_motion", "G53 with a probing move", "G53")
    point = target(state, block)
    position = state.reach(point)
    rotary_only = position[:3] == state.position[:3]
    feed = feed_of(state, block, rotary_only, cutting=False)
    move(state, block, Kind.FEED, position, feed)
    state.point = point


def return_to_reference(state: State, block: Block, number: int) -> None:
    """G28 G30: by way of the words, then only the named axes to the reference point."""
    code = f"G{number // 10}"
    named = [letter for letter in state.control.axes if letter in block.values]
    if not named:
        state.report(block.finding("g28_without_axes", f"{code} without axis words", code), code)
        named = list(state.control.axes)
    if block.values.get("P", 2.0) != 2.0:
        raise block.error("reference_not_found", f"{code} P{block.values['P']:g}", "P")
    reference = state.reference.get(code, {})
    if missing := [letter for letter in named if letter not in reference]:
        raise block.error("reference_not_found", f"{code} {missing[0]}", missing[0])
    middle = state.reach(target(state, block))
    if state.frame is Frame.MACHINE:
        move(state, block, Kind.RAPID, middle, 0.0)
    else:
        move_axes(state, block, Kind.RAPID, state.axes_of(middle))
    axes = state.axes.copy()
    for letter in named:
        axes[INDEX[letter]] = reference[letter]
    move_axes(state, block, Kind.RAPID, axes)

"""What moves the axes: rapids, feeds, arcs, probing, and the return to the reference point."""

from __future__ import annotations

import math
from collections.abc import Iterable

from gcodesim.nc.control import moves
from gcodesim.nc.control.arcs import Point
from gcodesim.nc.control.columns import CENTRE_WORDS
from gcodesim.nc.control.modal import Motion, TipControl
from gcodesim.nc.control.state import INCH, Edge
from gcodesim.nc.iso.block import Block
from gcodesim.nc.iso.g_codes import G
from gcodesim.nc.iso.memory import IsoState
from gcodesim.nc.program import AXES, PLANES, Frame, Kind, Plane

INDEX = {letter: i for i, letter in enumerate(AXES)}

MOTIONS = (Motion.RAPID, Motion.FEED, Motion.CLOCKWISE, Motion.COUNTER_CLOCKWISE)

VECTORS = TipControl.VECTORS

MOST_TURNS = 1_000_000
"""Largest P of an arc; no thread has more turns."""


def axis_values(state: IsoState, block: Block) -> dict[int, float]:
    """Return index in AXES -> value [mm or deg] of the axis words of a block."""
    found, inch = {}, state.modal.inch
    for letter, value in block.values.items():
        if letter in INDEX:
            i = INDEX[letter]
            found[i] = value * INCH if inch and i < 3 else value
    return found


def target(state: IsoState, block: Block) -> list[float]:
    """Return the program point the axis words name; letters left out keep their value."""
    if state.is_length_doubtful and "Z" in block.values and not state.modal.incremental:
        _settle_length(state)
    point = moves.point_to(state, axis_values(state, block))
    if state.codes.polar:
        _apply_polar(state, block, point)
    if "@" in block.values or "^" in block.values:
        _apply_radius_and_angle(state, block, point)
    if state.modal.tip_control is VECTORS:
        _apply_vector(state, block, point)
    return point


def _settle_length(state: IsoState) -> None:
    """Decide which tool length counts, before the first Z word that depends on it."""
    was_cancelled, state.is_length_cancelled = state.is_length_cancelled, False
    length, state.length_of_new_tool = state.length_of_new_tool, None
    if was_cancelled and state.reading("length_after_reference") == "cancelled":
        _take_length(state, 0.0)
    if length is None or length == state.frames.tool[2]:
        return
    if state.reading("length_at_tool_change") == "new_tool":
        _take_length(state, length)


def _take_length(state: IsoState, length: float) -> None:
    state.frames.tool = [*state.frames.tool[:2], length, *state.frames.tool[3:]]
    state.reframe()


def leave_length(state: IsoState, named: Iterable[int]) -> None:
    """Remember that the length axis was told to go where some controls cancel the length."""
    if 2 in named and state.frames.tool[2] and state.frame is Frame.MACHINE:
        state.is_length_cancelled = True


def _apply_vector(state: IsoState, block: Block, point: list[float]) -> None:
    """G43.5: I J K is the direction of the tool in the program frame, and rotary words are none."""
    words = block.values
    if rotary := next((letter for letter in "ABC" if letter in words), ""):
        raise block.error("unused_word", f"{rotary} under G43.5, which takes I J K", rotary)
    if state.control.kinematics is None or not words.keys() & set(CENTRE_WORDS):
        return
    vector = [words.get(letter, 0.0) for letter in CENTRE_WORDS]
    if not any(vector):
        raise block.error("direction_zero", "I, J and K are 0", "I")
    moves.aim_tool(state, point, vector)


def _apply_polar(state: IsoState, block: Block, point: list[float]) -> None:
    """G16: the first word of the plane is a radius, the second an angle, and replace the point.

    A radius in G91 makes the current point the pole; one in G90 takes program zero.
    """
    codes, words = state.codes, block.values
    u, v, _ = PLANES[state.modal.plane]
    incremental = state.modal.incremental
    if AXES[u] not in words and AXES[v] not in words:
        return
    if AXES[u] in words:
        codes.pole = (state.point[u], state.point[v]) if incremental else (0.0, 0.0)
        codes.radius = words[AXES[u]] * state.scale
    if AXES[v] in words:
        codes.angle = words[AXES[v]] + (codes.angle if incremental else 0.0)
    angle = math.radians(codes.angle)
    point[u] = codes.pole[0] + codes.radius * math.cos(angle)
    point[v] = codes.pole[1] + codes.radius * math.sin(angle)


def _apply_radius_and_angle(state: IsoState, block: Block, point: list[float]) -> None:
    """LinuxCNC's @ and ^: distance from program zero and angle in the XY plane, or steps of them.

    What is left out stays as it is.
    """
    words, (x, y) = block.values, state.point[:2]
    if "X" in words or "Y" in words or state.modal.plane is not Plane.XY:
        raise block.error("polar_words", "X, Y or another plane", "@" if "@" in words else "^")
    radius, angle = math.hypot(x, y), math.degrees(math.atan2(y, x))
    if state.modal.incremental:
        radius += words.get("@", 0.0) * state.scale
        angle += words.get("^", 0.0)
    else:
        radius = words["@"] * state.scale if "@" in words else radius
        angle = words.get("^", angle)
    point[0] = radius * math.cos(math.radians(angle))
    point[1] = radius * math.sin(math.radians(angle))


def set_polar(state: IsoState, block: Block, number: int) -> None:
    """G15 G16: polar words begin at the current point."""
    codes = state.codes
    codes.polar = number == G.POLAR
    u, v, _ = PLANES[state.modal.plane]
    codes.pole = (0.0, 0.0)
    codes.radius = math.hypot(state.point[u], state.point[v])
    codes.angle = math.degrees(math.atan2(state.point[v], state.point[u]))


def straight(state: IsoState, block: Block, number: int) -> None:
    """G0 G1, with G53 in machine coordinates; without axis words only the mode changes."""
    modal = state.modal
    modal.motion, state.codes.cycle, modal.drilling = MOTIONS[number // 10], 0, False
    if not block.moves:
        return
    kind = Kind.FEED if number else Kind.RAPID
    if block.has("G", G.MACHINE_COORDINATES):
        _to_machine_point(state, block, kind)
        return
    edge = None
    if block.corner[0]:
        letter, size = block.corner
        edge = Edge(letter == "R", size * state.scale, f",{letter}{size:g}", letter)
    moves.straight(state, kind, target(state, block), edge)


def move_in_step(state: IsoState, block: Block, number: int) -> None:
    """G33 G33.1 of LinuxCNC: feed by K with every turn of the spindle; G33.1 comes back."""
    modal, taps = state.modal, number == G.RIGID_TAPPING
    modal.motion = Motion.RIGID_TAPPING if taps else Motion.THREADING
    state.codes.cycle, modal.drilling = 0, False
    code, pitch = f"G{number / 10:g}", abs(block.values.get("K", 0.0)) * state.scale
    if not block.moves:
        raise block.error("axis_missing", f"{code} without axis words")
    if block.has("G", G.MACHINE_COORDINATES):
        raise block.error("axis_without_motion", f"G53 with {code}", "G53")
    if not pitch:
        raise block.error("feed_missing", f"{code} without K", code)
    if taps and not modal.spindle_turns:
        raise block.error("tapping_no_spindle", f"{code} with the spindle off", code)
    if taps and (rotary := next((letter for letter in "ABC" if letter in block.values), "")):
        raise block.error("rotary_in_cycle", f"{rotary} with {code}", rotary)
    moves.in_step(state, target(state, block), pitch, back=taps)


def _to_machine_point(state: IsoState, block: Block, kind: Kind) -> None:
    """G53: the words are axis positions; under G91 the control has a reading of its own."""
    reading = state.control.readings.g53_incremental
    if not state.modal.incremental or reading == "absolute":
        point = moves.machine_point(state, axis_values(state, block))
        moves.straight_to_axes(state, kind, point)
        leave_length(state, axis_values(state, block))
    elif reading == "ignored":
        state.report("g53_ignored", "G53 under G91", "G53")
    elif reading == "incremental":
        moves.straight(state, kind, target(state, block))
    else:
        meaning = "g53_incremental" if reading == "stop" else "g53_incremental_open"
        raise block.error(meaning, "G53 under G91", "G53")


def arc(state: IsoState, block: Block, number: int) -> None:
    """G2 G3 in the active plane, with centre words or R, P turns and a helix."""
    modal = state.modal
    modal.motion, state.codes.cycle, modal.drilling = MOTIONS[number // 10], 0, False
    if not block.moves:
        return
    if block.has("G", G.MACHINE_COORDINATES):
        raise block.error("axis_without_motion", "G53 with an arc", "G53")
    end = target(state, block)
    turns = _turns(block)
    centre, radius = _centre(state, block)
    if centre is None and not _needs_arc(state, block, end, radius):
        moves.straight(state, Kind.FEED, end)
        return
    clockwise = number == G.CLOCKWISE
    moves.arc(state, end, clockwise=clockwise, centre=centre, radius=radius, turns=turns)


def _needs_arc(state: IsoState, block: Block, end: list[float], radius: float) -> bool:
    """Tell whether there is an arc to trace, of a block without centre words.

    Raises:
        ProgramError: there is none, and that is an alarm.
    """
    if not radius and "R" not in block.values:
        if state.reading("arc_no_centre") == "alarm":
            raise block.error("arc_no_center", "arc without centre")
        return False
    u, v, _ = PLANES[state.modal.plane]
    if (end[u], end[v]) != (state.point[u], state.point[v]):
        return True
    return state.reading("arc_r_no_end") == "alarm"


def _turns(block: Block) -> int:
    turns = block.values.get("P", 1.0)
    if not 1 <= turns <= MOST_TURNS or not turns.is_integer():
        raise block.error("arc_turns", f"P{turns:g}", "P")
    return int(turns)


def _centre(state: IsoState, block: Block) -> tuple[Point | None, float]:
    """Return the centre (u, v) [mm] in the program frame and 0, or None and the radius [mm]."""
    u, v, w = PLANES[state.modal.plane]
    start, scale, words = state.point, state.scale, block.values
    # Under G43.5 I J K is the direction of the tool, so that only R is left for arcs.
    vectors = state.modal.tip_control is VECTORS
    given = [letter for letter in CENTRE_WORDS if letter in words and not vectors]
    if "R" in words and (not given or state.control.readings.r_and_ijk == "r_wins"):
        return None, words["R"] * scale
    if "R" in words:
        raise block.error("arc_r_and_center", "R and centre words", "R")
    if CENTRE_WORDS[w] in given:
        _check_normal_word(state, block, CENTRE_WORDS[w])
        given.remove(CENTRE_WORDS[w])
    absolute = state.modal.centre_absolute
    if not given:
        return None, 0.0
    if absolute and len(given) < 2:
        raise block.error("arc_no_center", "arc without centre")
    offset_u, offset_v = (words.get(CENTRE_WORDS[i], 0.0) * scale for i in (u, v))
    may_be_left_out = not absolute and state.control.readings.arc_no_centre != "alarm"
    if may_be_left_out and not (offset_u or offset_v):
        # I0 J0 may be left out, so that they are no centre.
        return None, 0.0
    return (offset_u, offset_v) if absolute else (start[u] + offset_u, start[v] + offset_v), 0.0


def _check_normal_word(state: IsoState, block: Block, letter: str) -> None:
    """Refuse a centre word along the normal of the plane where it is, or may be, an error."""
    reading = state.control.readings.arc_normal_word
    if reading == "error":
        raise block.error("arc_wrong_center_word", letter, letter)
    if reading == "zero" and block.values[letter]:
        raise block.error("arc_normal_word_open", f"{letter}{block.values[letter]:g}", letter)


def store_reference(state: IsoState, block: Block, number: int) -> None:
    """G28.1 G30.1: the current position becomes the reference point."""
    state.reference[f"G{number // 10}"] = dict(zip(AXES, state.axes, strict=True))


def probe(state: IsoState, block: Block, number: int) -> None:
    """G31 G38.x: a feed move, for contact is never made; the motion mode stays."""
    if not block.moves:
        raise block.error("axis_missing", f"G{number / 10:g} without axis words")
    if block.has("G", G.MACHINE_COORDINATES):
        raise block.error("axis_without_motion", "G53 with a probing move", "G53")
    moves.probe(state, target(state, block))


def return_to_reference(state: IsoState, block: Block, number: int) -> None:
    """G28 G30: by way of the words, then only the named axes to the reference point."""
    code = f"G{number // 10}"
    named = [letter for letter in state.control.axes if letter in block.values]
    if not named:
        state.report("g28_without_axes", f"{code} without axis words", code, subject=code)
        if state.reading("g28_no_axes") == "none":
            return
        named = list(state.control.axes)
    if block.values.get("P", 2.0) != 2.0:
        raise block.error("reference_not_found", f"{code} P{block.values['P']:g}", "P")
    reference = state.reference.get(code, {})
    if missing := [letter for letter in named if letter not in reference]:
        raise block.error("reference_not_found", f"{code} {missing[0]}", missing[0])
    ends = {INDEX[letter]: reference[letter] for letter in named}
    moves.through(state, target(state, block), ends)
    leave_length(state, ends)

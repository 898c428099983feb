"""One run of plain lines and arcs: modal state goes down the columns, not from line to line.

A run ends before the first line for which the language itself may say or do something else.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from gcodesim.nc.control.arcs import Pairs, broken, centres_from_radii
from gcodesim.nc.control.columns import (
    CENTRE_WORDS,
    MOTION,
    SPEED,
    TOOL,
    Bools,
    Columns,
    Floats,
    Ints,
)
from gcodesim.nc.control.modal import Motion, TipControl
from gcodesim.nc.control.readings import BOTH
from gcodesim.nc.control.state import State
from gcodesim.nc.control.wrap import unwound
from gcodesim.nc.program import AXES, PLANES, FeedMode, Kind

NEARLY_HALF = 0.4999
"""Part of a turn: a rotary axis that takes the shortest way turns by less, else the run ends.
Nearer to a half, the last bit decides which way is the shorter one."""

EDGE_DEG = 1e-6
"""This near its travel limit a run ends: the one way rounds a sum the other does not."""

KINDS = np.array([Kind.RAPID, Kind.FEED, Kind.ARC, Kind.ARC], np.uint8)
"""Kind by Motion."""

NONE = np.zeros(0)

ROTARY = "ABC"

KNOWN = {MOTION, SPEED, TOOL, "F", "R", *CENTRE_WORDS, *AXES}
"""Columns that are understood here; a line with another one needs the language itself."""


class PlainRun:
    """One run: lines begin to end (excluded) of a scanned chunk.

    Attributes:
        has, value: letter -> columns of the run's lines.
        bare: columns of the run's lines, see Columns.
        motion: Motion of every line; greater for cycles of the language.
        arcs, moves: the line is an arc; it is that or has axis words.
    """

    def __init__(self, state: State, columns: Columns, begin: int, end: int) -> None:
        self.state, self.columns, self.begin = state, columns, begin
        self.count = end - begin
        self.has = {k: v[begin:end] for k, v in columns.has.items() if v[begin:end].any()}
        self.value = {k: columns.value[k][begin:end] for k in self.has}
        self.bare = {k: v[begin:end] for k, v in columns.bare.items() if v[begin:end].any()}
        if self.bare and state.control.readings.no_point == "increment":
            for letter, bare in self.bare.items():
                increment = state.increment(is_angle=letter in ROTARY)
                self.value[letter] = np.where(
                    bare, self.value[letter] * increment, self.value[letter]
                )
        self.axes = [(i, letter) for i, letter in enumerate(AXES) if letter in self.has]
        self.moves = self._any(letter for _, letter in self.axes)
        self.motion = self._filled(MOTION, self.value.get(MOTION, NONE), state.modal.motion)
        self.centred = self._any(CENTRE_WORDS + "R")
        self.arcs = self.motion >= Motion.CLOCKWISE
        self.arcs &= self.moves | self.centred | self._any([MOTION])
        self.moves |= self.arcs

    def carry_out(self, before: int) -> int:
        """Record the moves and leave the state as the last line does; return how many lines.

        Args:
            before: lines of other texts before this one.
        """
        if self.state.frames.tilted and self.state.modal.tip_control is TipControl.OFF:
            self._cut(self._any(ROTARY))
        if self.state.clamped_by:
            self._cut(self._any(ROTARY))
        angles = self._angles()
        self._cut(self._any(self.has.keys() - KNOWN) | (self.motion > Motion.COUNTER_CLOCKWISE))
        self._cut(self._unsaid())
        self._cut((self.moves & (self.motion < 0)) | (self.centred & ~self.arcs))
        self._cut(self._without_tool())
        self._cut(self._unfed(self.moves & (self.motion >= Motion.FEED)))
        if not self.count:
            return 0
        points = self._points(angles)
        centres = self._centres(points) if self.arcs.any() else (NONE, NONE)
        if not self.count:
            return 0
        points = {i: column[: self.count] for i, column in points.items()}
        positions = self._positions(points)
        self._record(points, positions, centres, before)
        self._leave(points, positions)
        self._count_bare(before)
        return self.count

    def _any(self, letters: Iterable[str]) -> Bools:
        """Return which lines hold one of these letters."""
        found = np.zeros(self.count, bool)
        for letter in letters:
            if letter in self.has:
                found |= self.has[letter]
        return found

    def _cut(self, stops: Bools) -> None:
        """End the run before the first line that stops it."""
        found = np.flatnonzero(stops[: self.count])
        if not len(found):
            return
        n = self.count = int(found[0])
        self.has = {k: v[:n] for k, v in self.has.items()}
        self.value = {k: v[:n] for k, v in self.value.items()}
        self.moves, self.motion = self.moves[:n], self.motion[:n]
        self.arcs, self.centred = self.arcs[:n], self.centred[:n]

    def _filled(self, letter: str, value: Floats, start: float) -> Floats:
        """Return what is in force on every line: the last value of a letter, before it `start`."""
        if letter not in self.has:
            return np.full(self.count, start)
        has = self.has[letter]
        if has.all():
            return value
        last = np.maximum.accumulate(np.where(has, np.arange(self.count), -1))
        return np.where(last >= 0, value[last], start)

    def _bare_lines(self) -> Bools:
        """Return which lines hold a number without a decimal point."""
        found = np.zeros(self.count, bool)
        for bare in self.bare.values():
            found |= bare[: self.count]
        return found

    def _count_bare(self, before: int) -> None:
        """Count the lines for which it matters how numbers without a decimal point are read."""
        at = np.flatnonzero(self._bare_lines())
        reading = self.state.control.readings.no_point
        if len(at) and reading == "open":
            self.state.count_again("no_point_open", len(at))
        elif len(at) and reading == BOTH:
            self.state.meet("no_point", self._first_row(before) + int(at[0]), len(at))

    def _unsaid(self) -> Bools:
        """Return the lines whose numbers without a decimal point nothing has been said about."""
        open_yet = self.state.control.readings.no_point == "open"
        if open_yet and not self.state.has_reported("no_point_open"):
            return self._bare_lines()
        return np.zeros(self.count, bool)

    def _without_tool(self) -> Bools:
        """Return the lines that select a tool which the supplied table lacks."""
        tools = self.state.tools
        if tools is None or TOOL not in self.has:
            return np.zeros(self.count, bool)
        return self.has[TOOL] & ~np.isin(self.value[TOOL], [0, *tools])

    def _speeds(self) -> Floats:
        """Return the speed in force on every line."""
        modal = self.state.modal
        if modal.surface_speed:
            return np.full(self.count, modal.speed)
        return self._filled(SPEED, self.value.get(SPEED, NONE), modal.speed)

    def _unfed(self, feeds: Bools) -> Bools:
        """Return those feed moves whose feed, or spindle, the block-by-block way has to judge."""
        modal, state = self.state.modal, self.state
        feeds, has = feeds[: self.count], self._any("F")
        silent = modal.spindle_turns or state.has_reported("spindle_off_feed")
        if not silent:
            return feeds
        if modal.feed_mode == FeedMode.INVERSE_TIME:
            return feeds & ~has
        unfed = np.zeros(self.count, bool)
        if modal.feed_mode == FeedMode.PER_REVOLUTION:
            unfed = self._speeds() == 0.0
        if not (modal.feed or self._feed_given_from_outside()):
            unfed |= ~np.logical_or.accumulate(has)
        return feeds & unfed

    def _feed_given_from_outside(self) -> bool:
        modal = self.state.modal
        from_outside = (
            modal.feed_mode == FeedMode.PER_MINUTE and not modal.feed_given and not modal.feed
        )
        return bool(from_outside and self.state.control.feed)

    def _angles(self) -> dict[int, Floats]:
        """Return axis index -> unwound angles of the lines that name an axis read modulo 360.

        Ends the run where the direction of rotation is ambiguous.
        """
        found = {}
        for i, letter in self.axes:
            wrap = self.state.wraps.get(letter)
            if wrap is None or self.state.modal.incremental or letter not in self.has:
                continue
            has = self.has[letter]
            if wrap != "shortest":
                self._cut(has)
                continue
            at = np.flatnonzero(has)
            if not len(at):
                continue
            words = self.value[letter][at]
            current = self.state.point[i]
            shift = self.state.position[i] - current
            low, high = self.state.control.travel.get(letter, (-math.inf, math.inf))
            low, high = low - shift, high - shift
            first = unwound(float(words[0]), current, wrap, low, high)
            steps = np.diff(words) / 360.0
            turns = np.rint(steps)
            # The number of whole turns changes where the shorter way leads over 360 degrees.
            whole = round((first - float(words[0])) / 360.0) - np.cumsum(turns)
            angles = words + 360.0 * np.concatenate(([0.0], whole + 0.0))
            angles[0] = first
            far = np.abs(steps - turns) > NEARLY_HALF
            far |= (angles[1:] < low + EDGE_DEG) | (angles[1:] > high - EDGE_DEG)
            stops = np.zeros(self.count, bool)
            stops[at[1:][far]] = True
            self._cut(stops)
            found[i] = angles
        return found

    def _points(self, angles: dict[int, Floats]) -> dict[int, Floats]:
        """Return axis index -> program coordinate on every line, of axes that are named."""
        state, points = self.state, {}
        for i, letter in self.axes:
            has = self.has[letter]
            if not has.any():
                continue
            value = self.value[letter] * state.scale if i < 3 else self.value[letter]
            if state.modal.incremental:
                steps = np.concatenate(([state.point[i]], value[has]))
                value = np.zeros(self.count)
                value[has] = np.cumsum(steps)[1:]
            elif i in angles:
                value = np.zeros(self.count)
                value[has] = angles[i][: np.count_nonzero(has)]
            points[i] = self._filled(letter, value, state.point[i])
        return points

    def _positions(self, points: dict[int, Floats]) -> dict[int, Floats]:
        """Return axis index -> machine coordinate on every line.

        An axis keeps its very number until it is told to move, as in State.reach.
        """
        state = self.state
        shift = state.frames.shift
        moved = {i: _ever(column != state.point[i]) for i, column in points.items()}
        columns = dict(points)
        # Axes that the frame turns into each other are told to move together.
        joined = range(state.frames.joined)
        if any(i in points for i in joined):
            turned = self._turned([self._column(i, points) for i in range(3)])
            either = np.logical_or.reduce([moved[i] for i in joined if i in moved])
            for i in joined:
                columns[i], moved[i] = turned[i], either
        return {
            i: np.where(moved[i], column + shift[i], state.position[i])
            for i, column in columns.items()
        }

    def _turned(self, place: list[Floats]) -> list[Floats]:
        """Return columns X Y Z of the program frame, turned as Frames.machine turns a point."""
        matrix, (x, y, z) = self.state.frames.matrix, place
        return place if matrix is None else [a * x + b * y + c * z for a, b, c in matrix]

    def _record(
        self,
        points: dict[int, Floats],
        positions: dict[int, Floats],
        centres: Pairs,
        before: int,
    ) -> None:
        state, modal = self.state, self.state.modal
        moved, linear = self._moved(positions)
        rows = np.flatnonzero(moved | self.arcs)
        to = np.empty((len(rows), 6))
        for i in range(6):
            to[:, i] = positions[i][rows] if i in positions else state.position[i]
        kind, aux = KINDS[self.motion[rows].astype(np.intp)], np.zeros(len(rows), np.int64)
        at = np.flatnonzero(self.arcs)
        if len(at):
            first = self._record_arcs(at, points, centres)
            aux[self.arcs[rows]] = np.arange(first, first + len(at))
        state.recorder.extend(
            kind=kind,
            line=rows + self._first_row(before),
            to=to,
            f=np.where(kind == Kind.RAPID, 0.0, self._feeds(linear | self.arcs)[rows]),
            aux=aux,
            mode=modal.feed_mode,
            speed=self._speeds()[rows].astype(np.float32),
        )

    def _moved(self, positions: dict[int, Floats]) -> tuple[Bools, Bools]:
        """Return which lines move an axis at all, and which a linear one."""
        moved, linear = np.zeros(self.count, bool), np.zeros(self.count, bool)
        for i, column in positions.items():
            steps = np.zeros(self.count, bool)
            steps[0] = column[0] != self.state.position[i]
            np.not_equal(column[1:], column[:-1], out=steps[1:])
            moved |= steps
            if i < 3:
                linear |= steps
        return moved, linear

    def _first_row(self, before: int) -> int:
        """Return the number of the run's first line among the lines of all texts."""
        return before + self.columns.first + self.begin + 1

    def _centres(self, points: dict[int, Floats]) -> Pairs:
        """Return the centres (u, v) [mm] of the arcs in the program frame.

        Ends the run before the first arc that the block-by-block way may refuse.
        """
        modal, at = self.state.modal, np.flatnonzero(self.arcs)
        u, v, w = PLANES[modal.plane]
        end = self._column(u, points)[at], self._column(v, points)[at]
        start = self._before(u, points)[at], self._before(v, points)[at]
        arm = self._lengths(CENTRE_WORDS[u])[at], self._lengths(CENTRE_WORDS[v])[at]
        has_u, has_v = self._any(CENTRE_WORDS[u])[at], self._any(CENTRE_WORDS[v])[at]
        by_radius, tolerance = self._any("R")[at], self.state.control.readings.arc
        if modal.centre_absolute:
            centre, enough = arm, has_u & has_v
        else:
            centre, enough = (start[0] + arm[0], start[1] + arm[1]), has_u | has_v
        refused = ~enough | broken(start, end, centre, tolerance, modal.inch)
        if by_radius.any():
            clockwise, radius = self.motion[at] == Motion.CLOCKWISE, self._lengths("R")[at]
            other, bad = centres_from_radii(start, end, radius, clockwise, tolerance)
            # Which of R and centre words counts is for the dialect to say.
            refused = np.where(by_radius, bad | has_u | has_v, refused)
            centre = (
                np.where(by_radius, other[0], centre[0]),
                np.where(by_radius, other[1], centre[1]),
            )
        stops = np.zeros(self.count, bool)
        stops[at] = refused | self._any(CENTRE_WORDS[w])[at]
        self._cut(stops)
        left = np.count_nonzero(self.arcs)
        return centre[0][:left], centre[1][:left]

    def _column(self, i: int, points: dict[int, Floats]) -> Floats:
        """Return the program coordinate of an axis on every line."""
        return points[i] if i in points else np.full(self.count, self.state.point[i])

    def _before(self, i: int, points: dict[int, Floats]) -> Floats:
        """Return the program coordinate of an axis before every line, and after the last."""
        return np.concatenate(([self.state.point[i]], self._column(i, points)))

    def _lengths(self, letter: str) -> Floats:
        """Return the lengths [mm] that a letter names, 0 where it does not stand."""
        none = np.zeros(self.count)
        return self.value.get(letter, none) * self.state.scale

    def _record_arcs(self, at: Ints, points: dict[int, Floats], centres: Pairs) -> int:
        """Record centres, normals and turns of the arcs on lines `at`; return the first row."""
        frames, (u, v, w) = self.state.frames, PLANES[self.state.modal.plane]
        place = [self._column(i, points)[at] for i in range(3)]
        place[u], place[v] = centres
        place, shift = self._turned(place), frames.shift
        normal = [float(i == w) for i in range(3)]
        turns = np.where(self.motion[at] == Motion.CLOCKWISE, -1, 1)
        centre = np.column_stack([column + shift[i] for i, column in enumerate(place)])
        return self.state.recorder.extend_arcs(centre, frames.turn(normal), turns)

    def _feeds(self, linear: Bools) -> Floats:
        """Return what moves.feed_of returns; lengths in mm, angles in degrees."""
        state, modal = self.state, self.state.modal
        value = self.value["F"] if "F" in self.has else np.zeros(self.count)
        if modal.feed_mode == FeedMode.INVERSE_TIME:
            return value
        if self._feed_given_from_outside():
            start = rotary = state.control.feed or 0.0
        else:
            start, rotary = (modal.feed or 0.0) * modal.feed_scale, modal.feed or 0.0
        lengths = self._filled("F", value * state.scale, start)
        angles = self._filled("F", value, rotary)
        rotary_feed = state.control.readings.tcp_rotary_feed
        tips = modal.tip_control is not TipControl.OFF
        if tips and modal.feed_mode == FeedMode.PER_MINUTE and rotary_feed:
            angles = np.full(self.count, rotary_feed)
        return np.where(linear, lengths, angles)

    def _leave(self, points: dict[int, Floats], positions: dict[int, Floats]) -> None:
        state, modal = self.state, self.state.modal
        if self.motion[-1] >= 0:
            modal.motion = Motion(int(self.motion[-1]))
        if "F" in self.has and self.has["F"].any():
            modal.feed = float(self.value["F"][np.flatnonzero(self.has["F"])[-1]])
            modal.feed_scale, modal.feed_given = state.scale, True
        modal.speed = float(self._speeds()[-1])
        if TOOL in self.has and self.has[TOOL].any():
            modal.selected = int(self.value[TOOL][np.flatnonzero(self.has[TOOL])[-1]])
        state.point, state.position = list(state.point), list(state.position)
        for i, column in points.items():
            state.point[i] = float(column[-1])
        for i, column in positions.items():
            state.position[i] = float(column[-1])
        for letter, counts in self.columns.ignored.items():
            if times := int(counts[self.begin : self.begin + self.count].sum()):
                state.ignored[f"word {letter}"] += times


def _ever(changes: Bools) -> Bools:
    """Return whether something has changed up to here."""
    return np.asarray(np.logical_or.accumulate(changes))

"""Runs of plain blocks carried out at once: modal state goes down the columns instead of blocks.

The result is what the block-by-block way makes of the same lines, bit for bit: a run ends before
the first line for which that cannot be promised.
"""

from __future__ import annotations

import math

import numpy as np

from gcodesim.nc.flow import Source
from gcodesim.nc.program import AXES, Kind
from gcodesim.nc.scan import Bools, Floats, Words, scan
from gcodesim.nc.state import State
from gcodesim.nc.wrap import unwound

CHUNK = 1 << 13
"""Lines scanned at once: their arrays stay in the cache of a core."""

KEPT_CHUNKS = 8
"""Scanned chunks that are kept, for loops and subprograms."""

SHORTEST = 16
"""Shorter runs are faster block by block."""

HALF_TURN_DEG = 179.0
"""A rotary axis that takes the shortest way steps by less than this, else the run ends."""

EDGE_DEG = 1e-6
"""This near its travel limit a run ends: the one way rounds a sum the other does not."""


class Runs:
    """Finds runs of plain blocks and carries them out.

    Attributes:
        state: where the control stands.
        blocks, last_line: blocks of the last run, and the line of its last block, 0 without one.
    """

    def __init__(self, state: State) -> None:
        self.state = state
        self.blocks = self.last_line = 0
        self._chunks: dict[tuple[int, int], Words] = {}
        self._wait = self._pause = 0

    def take(self, source: Source, index: int, most: int) -> int:
        """Carry out the run that begins at a line; return how many lines that were.

        Args:
            source: the text.
            index: index of the line.
            most: number of blocks after which the run ends at the latest.
        """
        if self._wait:
            self._wait -= 1
            return 0
        state = self.state
        modal = state.modal
        if modal.cycle or modal.polar == 160 or state.unfollowed or not state.frames.is_plain:
            return 0
        words = self._words(source, index)
        begin = index - words.first
        end = min(int(words.run_end[begin]), source.structure.end - words.first)
        if end - begin < SHORTEST:
            return 0
        taken = self._carry_out(words, begin, end, most, source.first)
        # Where runs keep ending early, looking for the next one waits longer and longer.
        self._pause = 0 if taken >= SHORTEST else min(2 * self._pause + SHORTEST, CHUNK)
        self._wait = self._pause
        return taken

    def _carry_out(self, words: Words, begin: int, end: int, most: int, before: int) -> int:
        written = np.flatnonzero(~words.blank[begin:end])
        if len(written) > most:
            end = begin + int(written[most])
        run = Run(self.state, words, begin, end)
        taken = run.carry_out(before)
        written = written[written < taken]
        self.blocks = len(written)
        self.last_line = 0
        if len(written):
            self.last_line = before + words.first + begin + int(written[-1]) + 1
        return taken

    def _words(self, source: Source, index: int) -> Words:
        key = source.first, index // CHUNK
        if key not in self._chunks:
            if len(self._chunks) == KEPT_CHUNKS:
                del self._chunks[next(iter(self._chunks))]
            first = key[1] * CHUNK
            last = min(first + CHUNK, len(source.lines))
            control = self.state.control
            self._chunks[key] = scan(source.lines, first, last, control.axes, control.ignore_words)
        return self._chunks[key]


class Run:
    """One run: lines begin to end (excluded) of a scanned chunk.

    Attributes:
        has, value: letter -> columns of the run's lines.
        motion: motion code of every line, -1 before the first.
        moves: the line has axis words.
    """

    def __init__(self, state: State, words: Words, begin: int, end: int) -> None:
        self.state, self.words, self.begin = state, words, begin
        self.count = end - begin
        self.has = {k: v[begin:end] for k, v in words.has.items() if v[begin:end].any()}
        self.value = {k: words.value[k][begin:end] for k in self.has}
        self.axes = [(i, letter) for i, letter in enumerate(AXES) if letter in self.has]
        self.moves = np.zeros(self.count, bool)
        for _, letter in self.axes:
            self.moves |= self.has[letter]
        start = state.modal.motion if state.modal.motion in (0, 10) else -1
        codes = self.value["G"] * 10.0 if "G" in self.has else np.zeros(0)
        self.motion = self._filled("G", codes, start)

    def carry_out(self, before: int) -> int:
        """Record the moves and leave the state as the last line does; return how many lines.

        Args:
            before: lines of other texts before this one.
        """
        turns = self._whole_turns()
        self._cut(self.moves & (self.motion < 0))
        self._cut(self._unfed())
        if not self.count:
            return 0
        points = self._points(turns)
        positions = self._positions(points)
        self._record(positions, before)
        self._leave(points, positions)
        return self.count

    def _cut(self, stops: Bools) -> None:
        """End the run before the first line that stops it."""
        found = np.flatnonzero(stops[: self.count])
        if not len(found):
            return
        n = self.count = int(found[0])
        self.has = {k: v[:n] for k, v in self.has.items()}
        self.value = {k: v[:n] for k, v in self.value.items()}
        self.moves, self.motion = self.moves[:n], self.motion[:n]

    def _filled(self, letter: str, value: Floats, start: float) -> Floats:
        """Return what is in force on every line: the last value of a letter, before it `start`."""
        if letter not in self.has:
            return np.full(self.count, start)
        has = self.has[letter]
        if has.all():
            return value
        last = np.maximum.accumulate(np.where(has, np.arange(self.count), -1))
        return np.where(last >= 0, value[last], start)

    def _unfed(self) -> Bools:
        """Return the feed moves whose feed, or spindle, the block-by-block way has to judge."""
        modal, state = self.state.modal, self.state
        feeds = self.moves & (self.motion == 10)
        has = self.has.get("F", np.zeros(self.count, bool))
        silent = modal.spindle in (30, 40) or state.has_reported("spindle_off_feed")
        if not silent or (modal.feed_mode == 950 and not modal.speed):
            return feeds
        if modal.feed_mode == 930:
            return feeds & ~has
        if modal.feed or self._feed_given_from_outside():
            return np.zeros(self.count, bool)
        return feeds & ~np.logical_or.accumulate(has)

    def _feed_given_from_outside(self) -> bool:
        modal = self.state.modal
        from_outside = modal.feed_mode == 940 and not modal.feed_given and not modal.feed
        return bool(from_outside and self.state.control.feed)

    def _whole_turns(self) -> dict[int, tuple[float, float]]:
        """Return axis index -> first angle and whole turns of axes read modulo 360.

        Ends the run where such an axis changes its number of whole turns.
        """
        found = {}
        for i, letter in self.axes:
            wrap = self.state.wraps.get(letter)
            if wrap is None or self.state.modal.distance == 910 or letter not in self.has:
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
            turns = 360.0 * round((first - float(words[0])) / 360.0)
            angles = words[1:] + turns
            far = np.abs(np.diff(words)) > HALF_TURN_DEG
            far |= (angles < low + EDGE_DEG) | (angles > high - EDGE_DEG)
            stops = np.zeros(self.count, bool)
            stops[at[1:][far]] = True
            self._cut(stops)
            found[i] = first, turns
        return found

    def _points(self, turns: dict[int, tuple[float, float]]) -> dict[int, Floats]:
        """Return axis index -> program coordinate on every line, of axes that are named."""
        state, points = self.state, {}
        for i, letter in self.axes:
            has = self.has[letter]
            if not has.any():
                continue
            value = self.value[letter] * state.scale if i < 3 else self.value[letter]
            if state.modal.distance == 910:
                steps = np.concatenate(([state.point[i]], value[has]))
                value = np.zeros(self.count)
                value[has] = np.cumsum(steps)[1:]
            elif i in turns:
                first, whole = turns[i]
                value = value + whole
                value[np.argmax(has)] = first
            points[i] = self._filled(letter, value, state.point[i])
        return points

    def _positions(self, points: dict[int, Floats]) -> dict[int, Floats]:
        """Return axis index -> machine coordinate on every line.

        An axis keeps its very number until it is told to move, as in State.reach.
        """
        state = self.state
        shift, cos, sin = state.frames.shift
        moved = {i: _ever(column != state.point[i]) for i, column in points.items()}
        columns = dict(points)
        if sin and (0 in points or 1 in points):
            x, y = (points.get(i, np.full(self.count, state.point[i])) for i in (0, 1))
            columns[0], columns[1] = cos * x - sin * y, sin * x + cos * y
            either = [moved[i] for i in (0, 1) if i in moved]
            moved[0] = moved[1] = np.logical_or.reduce(either)
        return {
            i: np.where(moved[i], column + shift[i], state.position[i])
            for i, column in columns.items()
        }

    def _record(self, positions: dict[int, Floats], before: int) -> None:
        state, modal = self.state, self.state.modal
        moved, linear = np.zeros(self.count, bool), np.zeros(self.count, bool)
        for i, column in positions.items():
            steps = np.empty(self.count, bool)
            steps[0] = column[0] != state.position[i]
            np.not_equal(column[1:], column[:-1], out=steps[1:])
            moved |= steps
            if i < 3:
                linear |= steps
        rows = np.flatnonzero(moved)
        to = np.empty((len(rows), 6))
        for i in range(6):
            to[:, i] = positions[i][rows] if i in positions else state.position[i]
        is_feed = self.motion[rows] == 10
        state.recorder.extend(
            kind=np.where(is_feed, Kind.FEED, Kind.RAPID).astype(np.uint8),
            line=rows + (before + self.words.first + self.begin + 1),
            to=to,
            f=np.where(is_feed, self._feeds(linear)[rows], 0.0),
            mode=modal.feed_mode // 10,
            speed=modal.speed,
        )

    def _feeds(self, linear: Bools) -> Floats:
        """Return what moves.feed_of returns; lengths in mm, angles in degrees."""
        state, modal = self.state, self.state.modal
        value = self.value["F"] if "F" in self.has else np.zeros(self.count)
        if modal.feed_mode == 930:
            return value
        if self._feed_given_from_outside():
            start = rotary = state.control.feed or 0.0
        else:
            start, rotary = (modal.feed or 0.0) * modal.feed_scale, modal.feed or 0.0
        lengths = self._filled("F", value * state.scale, start)
        angles = self._filled("F", value, rotary)
        return np.where(linear, lengths, angles)

    def _leave(self, points: dict[int, Floats], positions: dict[int, Floats]) -> None:
        state, modal = self.state, self.state.modal
        if self.motion[-1] >= 0:
            modal.motion = int(self.motion[-1])
        if "F" in self.has and self.has["F"].any():
            modal.feed = float(self.value["F"][np.flatnonzero(self.has["F"])[-1]])
            modal.feed_scale, modal.feed_given = state.scale, True
        state.point, state.position = list(state.point), list(state.position)
        for i, column in points.items():
            state.point[i] = float(column[-1])
        for i, column in positions.items():
            state.position[i] = float(column[-1])
        for letter, counts in self.words.ignored.items():
            if times := int(counts[self.begin : self.begin + self.count].sum()):
                state.ignored[f"word {letter}"] += times


def _ever(changes: Bools) -> Bools:
    """Return whether something has changed up to here."""
    return np.asarray(np.logical_or.accumulate(changes))

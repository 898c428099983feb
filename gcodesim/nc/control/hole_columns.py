"""One run of holes: positions of an active cycle that are all drilled alike."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from gcodesim.errors import ProgramError
from gcodesim.nc.control.arcs import CENTRE_WORDS
from gcodesim.nc.control.columns import Run
from gcodesim.nc.control.state import State
from gcodesim.nc.iso.block import Block
from gcodesim.nc.iso.cycles import STEPS, Hole, check_words, new_hole
from gcodesim.nc.iso.scan import Bools, Floats, Words
from gcodesim.nc.program import AXES, PLANES, Kind

ALONG_DEPTH = frozenset({730, 740, 810, 820, 830, 840, 850, 860, 890})
"""Cycles that only move along the depth axis, and say nothing about their holes."""

XY = 170
PER_MINUTE = 94

MOST_ROWS = 1 << 17
"""Commands recorded at once; a hole may have thousands of pecks."""


@dataclass(slots=True)
class Levels(Hole):
    """A hole that is not made: it notes kinds and levels [mm] of its steps."""

    steps: list[tuple[Kind, float]] = field(default_factory=list)

    def dwell(self) -> None:
        """Note a dwell."""
        if self.seconds:
            self.steps.append((Kind.DWELL, 0.0))

    def _go(self, kind: Kind, level: float) -> None:
        self.steps.append((kind, level))


@dataclass(frozen=True, slots=True)
class Pattern:
    """What every hole of the active cycle does, from the level it is left to.

    Attributes:
        kind, depth: commands behind the way to the hole, and their positions of the depth axis.
        seconds: dwell at the bottom.
        counted: what a hole adds to State.holes.
    """

    kind: list[Kind]
    depth: list[float]
    seconds: float
    counted: int


def pattern_of(state: State) -> Pattern | None:
    """Return what every next hole of the active cycle does, None where they may differ."""
    modal, (shift, _, sin) = state.modal, state.frames.shift
    # G82 without P is reported for every hole.
    if modal.cycle not in ALONG_DEPTH or (modal.cycle == 820 and "P" not in modal.cycle_words):
        return None
    if sin and modal.plane != XY:
        return None
    before = state.holes
    try:
        hole = _tried(state)
        counted = 1 + state.holes - before
    except ProgramError:
        return None
    finally:
        state.holes = before
    w = hole.w
    level, position = start = state.point[w], state.position[w]
    kinds, depths = [], []
    for kind, target in hole.steps:
        # As in State.reach: an axis that is not told to move keeps its very number.
        place = position if kind == Kind.DWELL or target == level else target + shift[w]
        if kind == Kind.DWELL or place != position:
            kinds.append(kind)
            depths.append(place)
        level, position = (level if kind == Kind.DWELL else target), place
    if (level, position) != start or level < hole.r or len(kinds) >= MOST_ROWS:
        return None
    return Pattern(kinds, depths, hole.seconds, counted)


def _tried(state: State) -> Levels:
    """Return the steps of the next hole behind the way to it.

    Raises:
        ProgramError: the hole would be refused.
    """
    number, block = state.modal.cycle, Block("", 0, "")
    check_words(state, block, number)
    hole = new_hole(Levels, state, block, number)
    hole.rapid(hole.r)
    STEPS[number](hole)
    return hole


class HoleRun(Run):
    """Lines begin to end (excluded) of a scanned chunk, under an active cycle."""

    def __init__(self, state: State, words: Words, begin: int, end: int, pattern: Pattern) -> None:
        super().__init__(state, words, begin, end)
        self.pattern = pattern
        self.motion = np.full(self.count, -1.0)
        self.moves = self._any(letter for _, letter in self.axes)
        depth = PLANES[state.modal.plane][2]
        self.axes = [(i, letter) for i, letter in self.axes if i != depth]

    def carry_out(self, before: int) -> int:
        """Record the holes and leave the state as the last line does; return how many lines."""
        self._cut(self._any("ABC" + CENTRE_WORDS) | self._changed())
        self._cut(self._unfed(self.moves))
        self._cut(np.cumsum(self.moves) > MOST_ROWS // (1 + len(self.pattern.kind)))
        if not self.count:
            return 0
        points = self._points({})
        positions = self._positions(points)
        self._record_holes(positions, before)
        self._leave(points, positions)
        return self.count

    def _changed(self) -> Bools:
        """Return the lines whose words are not those that the cycle keeps."""
        modal, scale = self.state.modal, self.state.scale
        changed, depth = np.zeros(self.count, bool), AXES[PLANES[modal.plane][2]]
        for letter, kept in (("Q", "Q"), ("R", "R"), (depth, "Z")):
            if letter in self.has:
                same = self.value[letter] * scale == modal.cycle_words.get(kept, np.nan)
                changed |= self.has[letter] & ~same
        if "G" in self.has:
            changed |= self.has["G"] & (self.value["G"] * 10.0 != modal.cycle)
        return changed

    def _record_holes(self, positions: dict[int, Floats], before: int) -> None:
        state, modal, pattern = self.state, self.state.modal, self.pattern
        at, w = np.flatnonzero(self.moves), PLANES[modal.plane][2]
        kind = np.array([Kind.RAPID, *pattern.kind], np.uint8)
        shape = len(at), len(kind)
        to = np.zeros((*shape, 6))
        for i in range(6):
            to[:, :, i] = positions[i][at, None] if i in positions else state.position[i]
        to[:, :, w] = state.position[w], *pattern.depth
        dwells, f = kind == Kind.DWELL, np.zeros(shape)
        to[:, dwells], f[:, dwells] = 0.0, pattern.seconds
        f[:, kind == Kind.FEED] = self._feeds(np.ones(self.count, bool))[at, None]
        # The way to a hole that is where the last one was is no move.
        moves = np.ones(shape, bool)
        moves[:, 0] = self._moved(positions)[0][at]
        kept = moves.reshape(-1)
        modes = np.where(dwells, PER_MINUTE, modal.feed_mode // 10).astype(np.uint8)
        speeds = np.where(dwells, 0.0, modal.speed).astype(np.float32)
        state.recorder.extend(
            kind=np.tile(kind, len(at))[kept],
            line=np.repeat(at + self._first_row(before), len(kind))[kept],
            to=to.reshape(-1, 6)[kept],
            f=f.reshape(-1)[kept],
            aux=np.zeros(np.count_nonzero(kept), np.int64),
            mode=np.tile(modes, len(at))[kept],
            speed=np.tile(speeds, len(at))[kept],
        )
        state.holes += len(at) * pattern.counted

"""One run of holes: positions of an active cycle that are all drilled alike."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gcodesim.nc.control.columns import MOTION, SPEED, TOOL, Bools, Columns, Floats
from gcodesim.nc.control.drilling import Dwell, FeedTo, Hole, RapidTo, Step
from gcodesim.nc.control.plain_run import PlainRun
from gcodesim.nc.control.state import State
from gcodesim.nc.program import PLANES, FeedMode, Kind

MOST_ROWS = 1 << 17
"""Commands recorded at once; a hole may have thousands of pecks."""


@dataclass(frozen=True, slots=True)
class Pattern:
    """What every hole of the active cycle does, from the level it is left to.

    Attributes:
        hole: what the language says of it.
        kind, depth: commands after the way to the hole, and their positions of the depth axis.
        seconds: dwell, as often as there is one.
    """

    hole: Hole
    kind: list[Kind]
    depth: list[float]
    seconds: float


def pattern_of(state: State, hole: Hole) -> Pattern | None:
    """Return what every next hole does, None where they may differ or leave the depth axis."""
    w = PLANES[state.modal.plane][2]
    if state.frames.joined > w or hole.level is None or hole.is_upward:
        return None
    shift = state.frames.shift
    level, position = start = state.point[w], state.position[w]
    kinds: list[Kind] = []
    depths: list[float] = []
    times: set[float] = set()
    for step in (RapidTo(hole.level), *hole.steps):
        kind, target = _along_depth(step)
        if kind is None:
            return None
        if kind == Kind.DWELL:
            if target:
                times.add(target)
                kinds.append(kind)
                depths.append(position)
            continue
        # As in State.reach: an axis that is not told to move keeps its very number.
        place = position if target == level else target + shift[w]
        if place != position:
            kinds.append(kind)
            depths.append(place)
        level, position = target, place
    if (level, position) != start or level < hole.level or len(kinds) >= MOST_ROWS:
        return None
    return Pattern(hole, kinds, depths, times.pop() if times else 0.0) if len(times) < 2 else None


def _along_depth(step: Step) -> tuple[Kind | None, float]:
    """Return kind and level of a step, or its seconds; None for one that leaves the depth axis."""
    match step:
        case FeedTo(level):
            return Kind.FEED, level
        case RapidTo(level):
            return Kind.RAPID, level
        case Dwell(seconds):
            return Kind.DWELL, seconds
    return None, 0.0


class HoleRun(PlainRun):
    """Lines begin to end (excluded) of a scanned chunk, under an active cycle."""

    def __init__(
        self, state: State, columns: Columns, begin: int, end: int, pattern: Pattern
    ) -> None:
        super().__init__(state, columns, begin, end)
        self.pattern = pattern
        self.motion = np.full(self.count, -1.0)
        self.moves = self._any(letter for letter in self.has if letter in pattern.hole.drills)
        depth = PLANES[state.modal.plane][2]
        self.axes = [(i, letter) for i, letter in self.axes if i != depth]

    def carry_out(self, before: int) -> int:
        """Record the holes and leave the state as the last line does; return how many lines."""
        self._cut(self._changed() | self._without_tool() | self._unsaid())
        self._cut(self._unfed(self.moves))
        self._cut(np.cumsum(self.moves) > MOST_ROWS // (1 + len(self.pattern.kind)))
        if not self.count:
            return 0
        points = self._points({})
        positions = self._positions(points)
        self._record_holes(positions, before)
        self._leave(points, positions)
        self._count_bare(before)
        return self.count

    def _changed(self) -> Bools:
        """Return the lines with words that are neither a place nor what the cycle keeps."""
        kept = self.pattern.hole.kept
        places = {letter for i, letter in self.axes if i < 3} | {"F", SPEED, TOOL}
        changed = self._any(self.has.keys() - places - kept.keys())
        for letter in kept.keys() & self.has.keys():
            scale = 1.0 if letter == MOTION else self.state.scale
            changed |= self.has[letter] & (self.value[letter] * scale != kept[letter])
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
        modes = np.where(dwells, FeedMode.PER_MINUTE, modal.feed_mode).astype(np.uint8)
        speeds = np.where(dwells, 0.0, self._speeds()[at, None]).astype(np.float32)
        state.recorder.extend(
            kind=np.tile(kind, len(at))[kept],
            line=np.repeat(at + self._first_row(before), len(kind))[kept],
            to=to.reshape(-1, 6)[kept],
            f=f.reshape(-1)[kept],
            aux=np.zeros(np.count_nonzero(kept), np.int64),
            mode=np.tile(modes, len(at))[kept],
            speed=speeds.reshape(-1)[kept],
        )
        state.holes += len(at) * pattern.hole.counted

"""Runs of plain blocks carried out at once: modal state goes down the columns instead of blocks.

The result is what the block-by-block way makes of the same lines, bit for bit: a run ends before
the first line for which that cannot be promised.
"""

from __future__ import annotations

import numpy as np

from gcodesim.nc.control.columns import Run
from gcodesim.nc.control.hole_columns import HoleRun, pattern_of
from gcodesim.nc.control.program_flow import Source
from gcodesim.nc.control.state import State
from gcodesim.nc.iso.scan import Words, scan

CHUNK = 1 << 13
"""Lines scanned at once: their arrays stay in the cache of a core."""

KEPT_CHUNKS = 8
"""Scanned chunks that are kept, for loops and subprograms."""

POLAR, VECTORS = 160, 435

SHORTEST = 16
"""Shorter runs are faster block by block."""


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
        # Lines of a source where no run begins: nothing is asked about them again.
        self._source: Source | None = None
        self._none = range(0)

    def take(self, source: Source, index: int, most: int) -> int:
        """Carry out the run that begins at a line; return how many lines that were.

        Args:
            source: the text.
            index: index of the line.
            most: number of blocks after which the run ends at the latest.
        """
        if index in self._none and source is self._source:
            return 0
        if self._wait:
            self._wait -= 1
            return 0
        state = self.state
        modal = state.modal
        if modal.polar == POLAR or state.unfollowed or not self._is_framed():
            return 0
        if state.corner is not None or modal.tcp == VECTORS or state.frames.carried is not None:
            return 0
        words = self._words(source, index)
        begin = index - words.first
        self._source, self._none = source, range(index, words.first + int(words.next_run[begin]))
        if index in self._none:
            return 0
        end = min(int(words.run_end[begin]), source.structure.end - words.first)
        taken = self._carry_out(words, begin, end, most, source.first)
        # Where runs keep ending early, looking for the next one waits longer and longer.
        self._pause = 0 if taken >= SHORTEST else min(2 * self._pause + SHORTEST, CHUNK)
        self._wait = self._pause
        return taken

    def _is_framed(self) -> bool:
        """Tell whether the frame is one that columns can be turned in, with nothing to report."""
        frames, modal = self.state.frames, self.state.modal
        if frames.is_plain:
            return True
        square = frames.tilt is None or bool(modal.tcp) or self.state.on_plane is True
        return square and not frames.mirror and not modal.cycle

    def _carry_out(self, words: Words, begin: int, end: int, most: int, before: int) -> int:
        pattern = pattern_of(self.state) if self.state.modal.cycle else None
        if self.state.modal.cycle and pattern is None:
            return 0
        # Holes and pecks are limited as blocks are.
        most = most // (1 + pattern.counted) if pattern else most
        if most < 1:
            return 0
        written = np.flatnonzero(~words.blank[begin:end])
        if len(written) > most:
            end = begin + int(written[most - 1]) + 1
        place = self.state, words, begin, end
        taken = (HoleRun(*place, pattern) if pattern else Run(*place)).carry_out(before)
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
            letters = control.axes, frozenset(control.readings.ignore_words)
            self._chunks[key] = scan(source.lines, first, last, *letters, SHORTEST)
        return self._chunks[key]

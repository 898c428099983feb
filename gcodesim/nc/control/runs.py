"""Runs of plain lines carried out at once: modal state goes down the columns instead of lines.

The result is what the language makes of the same lines one by one, bit for bit: a run ends before
the first line for which that cannot be promised.
"""

from __future__ import annotations

from typing import Generic

import numpy as np

from gcodesim.nc.control.columns import Columns
from gcodesim.nc.control.hole_run import HoleRun, Pattern, pattern_of
from gcodesim.nc.control.language_base import Language, Line
from gcodesim.nc.control.modal import TipControl
from gcodesim.nc.control.plain_run import PlainRun
from gcodesim.nc.control.program_flow import Source

CHUNK = 1 << 13
"""Lines scanned at once: their arrays stay in the cache of a core."""

KEPT_CHUNKS = 8
"""Scanned chunks that are kept, for loops and subprograms."""

SHORTEST = 16
"""Shorter runs are faster line by line."""


class Runs(Generic[Line]):
    """Finds runs of plain lines and carries them out.

    Attributes:
        language: reads the columns, and knows its modes and cycles.
    """

    def __init__(self, language: Language[Line]) -> None:
        self.language, self.state = language, language.state
        self._chunks: dict[tuple[int, int], Columns] = {}
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
        if not self._is_plain():
            return 0
        columns = self._columns(source, index)
        begin = index - columns.first
        self._source = source
        self._none = range(index, columns.first + int(columns.next_run[begin]))
        if index in self._none:
            return 0
        end = min(int(columns.run_end[begin]), source.end - columns.first)
        taken = self._carry_out(columns, begin, end, most, source.first)
        # Where runs keep ending early, looking for the next one waits longer and longer.
        self._pause = 0 if taken >= SHORTEST else min(2 * self._pause + SHORTEST, CHUNK)
        self._wait = self._pause
        return taken

    def _is_plain(self) -> bool:
        """Tell whether plain words mean plain moves here, with nothing to report."""
        state, frames, modal = self.state, self.state.frames, self.state.modal
        if state.unfollowed or state.corner is not None or frames.carried is not None:
            return False
        if state.skipped is not None:
            return False
        if frames.tilted and modal.tip_control is TipControl.OFF and state.on_plane is not True:
            return False
        if frames.mirrored or (modal.drilling and frames.joined == 3):
            return False
        return modal.tip_control is not TipControl.VECTORS and self.language.is_plain()

    def _carry_out(self, columns: Columns, begin: int, end: int, most: int, before: int) -> int:
        pattern = self._pattern() if self.state.modal.drilling else None
        if self.state.modal.drilling and pattern is None:
            return 0
        # Holes and pecks are limited as blocks are.
        most = most // (1 + pattern.hole.counted) if pattern else most
        if most < 1:
            return 0
        written = np.flatnonzero(~columns.blank[begin:end])
        if len(written) > most:
            end = begin + int(written[most - 1]) + 1
        place = self.state, columns, begin, end
        taken = (HoleRun(*place, pattern) if pattern else PlainRun(*place)).carry_out(before)
        written = written[written < taken]
        self.state.blocks += len(written)
        if len(written):
            self.state.last_line = before + columns.first + begin + int(written[-1]) + 1
        return taken

    def _pattern(self) -> Pattern | None:
        hole = self.language.next_hole()
        return None if hole is None else pattern_of(self.state, hole)

    def _columns(self, source: Source, index: int) -> Columns:
        key = source.first, index // CHUNK
        if key not in self._chunks:
            if len(self._chunks) == KEPT_CHUNKS:
                del self._chunks[next(iter(self._chunks))]
            first = key[1] * CHUNK
            last = min(first + CHUNK, len(source.lines))
            self._chunks[key] = self.language.scan(source.lines, first, last, SHORTEST)
        return self._chunks[key]

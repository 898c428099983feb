"""Trace: axis positions over program time, as CSV rows or NPZ columns."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TextIO

import numpy as np
from numpy.typing import NDArray

from gcodesim.constants import PS_PER_S
from gcodesim.machine.model import Machine
from gcodesim.motion.path import Path
from gcodesim.motion.servo import lagged_positions
from gcodesim.output_file import replacing

CHUNK, ROWS = 1 << 20, 1 << 14
"""Instants whose positions are found at once, and rows that are written at once."""

PLACES = 9
"""Decimals of times [s] and positions [mm, deg]: well below what any control resolves."""


@dataclass(frozen=True)
class Trace:
    """A path looked at in equal steps, and at its end.

    Attributes:
        every_ps: the step [ps].
        real: where the lagging drives are, not where the control commands them to be.
    """

    path: Path
    machine: Machine
    every_ps: int
    real: bool = False

    @property
    def times_ps(self) -> NDArray[np.int64]:
        """All instants, shape (m,); none for a path without pieces."""
        if not len(self.path):
            return np.zeros(0, np.int64)
        end = self.path.duration_ps
        return np.append(np.arange(0, end, self.every_ps, dtype=np.int64), end)

    def positions(self, times_ps: NDArray[np.int64]) -> NDArray[np.float64]:
        """Joint positions, shape (m, joints) [mm or deg]."""
        if self.real:
            return lagged_positions(self.path, self.machine, times_ps)
        return self.path.positions(times_ps)

    def lines(self, times_ps: NDArray[np.int64]) -> NDArray[np.int32]:
        """Source line in force, shape (m,)."""
        return self.path.line[self.path.piece_at(times_ps)]


def write_csv(trace: Trace, out: TextIO) -> None:
    """Write a header, then one row per instant: time_s, line, every axis."""
    out.write(",".join(["time_s", "line", *trace.path.joints]) + "\n")
    row = f"%.{PLACES}f,%d{f',%.{PLACES}f' * len(trace.path.joints)}\n"
    times = trace.times_ps
    for first in range(0, len(times), CHUNK):
        part = times[first : first + CHUNK]
        cells = np.column_stack([part / PS_PER_S, trace.lines(part), trace.positions(part)])
        for begin in range(0, len(part), ROWS):
            some = cells[begin : begin + ROWS]
            # One formatting for many rows: three times faster than one for each cell.
            out.write(row * len(some) % tuple(some.ravel().tolist()))


def write_npz(trace: Trace, file: str) -> None:
    """Write the columns time_s, line, axes (names) and positions (m, axes) as a NumPy archive."""
    times = trace.times_ps
    with replacing(file) as out:
        np.savez_compressed(
            out,
            time_s=times / PS_PER_S,
            line=trace.lines(times) if len(times) else np.zeros(0, np.int32),
            axes=np.array(trace.path.joints),
            positions=trace.positions(times)
            if len(times)
            else np.zeros((0, len(trace.path.joints))),
        )

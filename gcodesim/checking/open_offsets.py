"""A work offset that is in use and that nobody gave: the program may run anywhere."""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np

from gcodesim.findings.codes import Finding
from gcodesim.machine.model import Machine
from gcodesim.nc.control.interpreter import Interpretation
from gcodesim.nc.program import Kind

MOVES = (Kind.RAPID, Kind.FEED, Kind.ARC)


MACHINE_PLACES = re.compile(r"G0*(?:53|28|30)(?![0-9.])", re.IGNORECASE)
"""Codes whose blocks go to places of the machine, whatever the offset."""


def open_offsets(meaning: Interpretation, machine: Machine) -> Iterator[Finding]:
    """Yield the finding that G54 is taken as zero, where the program moves in it.

    Only G54 can be in force without being given: any other is refused where it is called. Values
    that the program writes itself are known.
    """
    if machine.work_link is None or 1 in machine.offsets:
        return
    program, lines = meaning.program, meaning.lines
    sets = np.flatnonzero(program.kind == Kind.G5X)
    moves = np.flatnonzero(np.isin(program.kind, MOVES) & (program.line > 0))
    before = np.searchsorted(sets, moves) - 1
    in_force = sets[np.maximum(before, 0)] if len(sets) else np.zeros(len(moves), np.int64)
    taken = (before < 0) | ((program.aux[in_force] == 1) & ~program.to[in_force].any(axis=1))
    used = (int(line) for line in program.line[moves[taken]])
    line = next((line for line in used if not MACHINE_PLACES.search(lines[line - 1])), None)
    if line is not None:
        text = "G54 is in use and nobody gave it: it is taken as zero; give it under work: offsets"
        yield Finding("GC425", text, "offset_assumed", line=line)

"""A language: what the interpreter asks of each, to turn lines of text into what a control does."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from gcodesim.findings.left_out import NotRun
from gcodesim.nc.control.columns import Columns
from gcodesim.nc.control.drilling import Hole
from gcodesim.nc.control.place import Place
from gcodesim.nc.control.program_flow import ProgramFlow, Source
from gcodesim.nc.control.state import State
from gcodesim.nc.lines import Lines

Line = TypeVar("Line", bound=Place)
"""What a language makes of a line before it runs: its block."""


class Language(ABC, Generic[Line]):
    """One language at work on one program.

    Attributes:
        state: what the control knows; the language changes it through the modules beside this one.
        flow: which line runs next; the language lets it jump and call.
    """

    def __init__(self, state: State, flow: ProgramFlow) -> None:
        self.state, self.flow = state, flow

    def open(self, text: str, file: str) -> None:
        """Take in the main program, and find where it begins and ends.

        Raises:
            ProgramError: it cannot run: what its lines open and close does not fit.
        """
        self.flow.add(text, file)

    @abstractmethod
    def place(self, source: Source, index: int) -> Line:
        """Return the place of a line that is about to run."""

    @abstractmethod
    def run(self, line: Line) -> None:
        """Carry out a line, and count it in the state if it is a block.

        Raises:
            ProgramError: the line is refused; what it has recorded is taken back.
            OrientationError: no rotary positions hold the tool as it says.
        """

    @abstractmethod
    def scan(self, lines: Lines, first: int, last: int, shortest: int) -> Columns:
        """Read lines first to last (excluded) into columns; runs below `shortest` are none."""

    def is_plain(self) -> bool:
        """Tell whether the modes of the language let plain words mean plain moves."""
        return True

    def next_hole(self) -> Hole | None:
        """Return what the cycle in force does at the next point; None where holes may differ."""
        return None

    def not_run(self, ran: NDArray[np.int32]) -> Iterator[NotRun]:
        """Yield what of the texts did not run, of commands whose rows are given."""
        yield from ()

    def other_programs(self) -> list[tuple[str, int]]:
        """Return the main programs of the file that nothing has called, with their lines."""
        return []

    def unfinished(self) -> str:
        """Return what to report when the text of a subprogram ends without a return."""
        return "the subprogram ends without a return"

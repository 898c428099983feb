"""Interprets a program in the language it is written in."""

from __future__ import annotations

from collections.abc import Callable

from gcodesim.nc.control.interpreter import Interpretation, Interpreter
from gcodesim.nc.control.supply import Control
from gcodesim.nc.iso.reader import IsoReader


def interpret(
    text: str,
    control: Control,
    file: str = "",
    progress: Callable[[float], None] = lambda fraction: None,
) -> Interpretation:
    """Interpret a program.

    Args:
        text: program text (lines.read_program).
        control: what the control knows before the program starts.
        file: name for findings; subprograms are read from the folder it stands in.
        progress: called now and then with the fraction of the lines that is done.

    Returns:
        The canonical program and what there is to say about it. Never raises for bad programs.
    """
    return Interpreter(IsoReader(control), progress).run(text, file)

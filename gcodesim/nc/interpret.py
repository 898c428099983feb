"""Interprets a program in the language it is written in: the one place that chooses it."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace

from gcodesim.nc.control.interpreter import Interpretation, Interpreter
from gcodesim.nc.control.place import Place, ProgramError
from gcodesim.nc.control.readings import ROWS, choose_readings
from gcodesim.nc.control.supply import Control
from gcodesim.nc.detect import LINES, dialect_of, neighbour_of
from gcodesim.nc.iso.reader import IsoReader
from gcodesim.nc.lines import split_lines

HEAD = 4096 * LINES
"""Characters in which the first lines stand."""


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
    control = settled(text, control)
    meaning = Interpreter(IsoReader(control), progress).run(text, file)
    if not control.dialect_told:
        return meaning
    note = Place(file, 1, "").finding("dialect_told", control.dialect_told)
    return replace(meaning, findings=(*meaning.findings, note))


def main_programs(text: str, control: Control) -> list[str]:
    """Return the main programs of a text: "" for the first one, O-number or <NAME> of the others.

    Args:
        text: program text.
        control: as for interpret.
    """
    reader = IsoReader(settled(text, control))
    # What is wrong with the text its check says.
    with suppress(ProgramError):
        reader.open(text, "")
    return ["", *(name for name, _ in reader.other_programs())]


def settled(text: str, control: Control) -> Control:
    """Return the control with the dialect that the text tells, where nothing else has told it."""
    if control.given is None:
        return control
    head = split_lines(text[:HEAD])
    dialect, mark = dialect_of(head, ROWS)
    if mark:
        told = f"dialect {dialect}, by {mark.quoted}"
    elif name := neighbour_of(head):
        told = f"dialect assumed: {dialect}; the text names {name}, which has no row of its own"
    else:
        told = f"dialect assumed: {dialect}; nothing in the text decides"
    readings = choose_readings(dialect, control.given)
    return replace(control, readings=readings, given=None, dialect_told=told)

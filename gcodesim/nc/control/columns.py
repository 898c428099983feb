"""Columns: many lines of plain words read at once, as the scanner of a language fills them.

A line is plain when it holds nothing but words that mean the same wherever the line stands: axis
and arc words, F, the kind of motion, the speed, and the tool to select. Whatever is not plain is
left to the language itself, line by line.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Bools = NDArray[np.bool_]
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MOTION = "motion"
"""Column of the kind of motion: values of modal.Motion; above them, a cycle of the language."""

SPEED, TOOL = "S", "T"
"""Columns of the speed of the spindle [rev/min], 0 or more, and of the number of a tool, whole."""

CENTRE_WORDS = "IJK"
"""Columns of arc centres by the index of their axis; R is the column of the radius."""


@dataclass(slots=True)
class Columns:
    """Columns of n lines.

    Letters are those of axes, CENTRE_WORDS, R, F, MOTION, SPEED, TOOL, or the language's.

    Attributes:
        first: index of the first line.
        plain, blank: the line is plain; it holds no word at all; shape (n,) each.
        has, value: letter -> whether, and with which value, the line holds it, shape (n,) each.
        ignored: ignored letter -> how often each line holds it, in the order first met.
        bare: letter -> whether its number has no decimal point and is not 0, shape (n,), of letters
            for which that matters and where it happens.
        run_end: index of the next line that is not plain, shape (n,), counted from `first`.
        next_run: index of the next line at which a run long enough may begin, shape (n,).
    """

    first: int
    plain: Bools
    blank: Bools
    has: dict[str, Bools]
    value: dict[str, Floats]
    ignored: dict[str, Ints] = field(default_factory=dict)
    bare: dict[str, Bools] = field(default_factory=dict)
    run_end: Ints = field(default_factory=lambda: np.zeros(0, np.int64))
    next_run: Ints = field(default_factory=lambda: np.zeros(0, np.int64))

    def find_runs(self, shortest: int) -> None:
        """Fill in where runs end and begin; runs of fewer lines than `shortest` are none."""
        index = np.arange(len(self.plain))
        self.run_end = _next(~self.plain, index)
        self.next_run = _next(self.run_end - index >= shortest, index)


def columns_of(first: int, words: Mapping[str, Floats], shortest: int) -> Columns:
    """Return columns of plain lines.

    Args:
        first: index of the first line.
        words: letter -> value on every line, shape (n,); NaN where the line does not hold it.
        shortest: lines of the shortest run.
    """
    has = {letter: ~np.isnan(value) for letter, value in words.items()}
    value = {letter: np.nan_to_num(value) for letter, value in words.items()}
    blank = ~np.logical_or.reduce(list(has.values()))
    columns = Columns(first, np.ones(len(blank), bool), blank, has, value)
    columns.find_runs(shortest)
    return columns


def _next(marked: Bools, index: Ints) -> Ints:
    """Return for every line the next one that is marked, the line itself included."""
    return np.minimum.accumulate(np.where(marked, index, len(index))[::-1])[::-1]

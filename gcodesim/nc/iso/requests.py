"""What a block may ask of the program flow; jumps.Jumps carries it out after the block."""

from __future__ import annotations

from typing import NamedTuple


class CallProgram(NamedTuple):
    """Run subprogram O.

    Attributes:
        number: its O-number.
        repeats: how often.
        arguments: its local parameters; None = those of the caller stay.
    """

    number: int
    repeats: int
    arguments: dict[float, float | None] | None = None


class CallBlock(NamedTuple):
    """Run from block N of the running program to M99 (M97)."""

    number: int
    repeats: int


class Return(NamedTuple):
    """Return from the running subprogram, to block N of the caller where there is one."""

    target: int | None


Request = CallProgram | CallBlock | Return

"""How the languages of macros differ: one row per language."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace


@dataclass(frozen=True)
class MacroRules:
    """What text of macros means in one language.

    Attributes:
        levels: operators by strength, strongest first.
        o_words: blocks are built with o-words, and an assignment takes one value.
        vacant: a parameter without a value has none, which is not 0.
        lowest, last: the parameters there are; #1 to `locals` belong to a call.
        system: parameters that the control itself keeps.
        read_only: parameters that a program cannot write.
        layout: key of parameters.LAYOUTS: what the system's parameters hold.
        full_turn: ATAN[y]/[x] gives 0 to 360, else -180 to 180.
        floored: FIX, FUP and MOD round down and up, else towards zero and away from it.
        bitwise: AND OR XOR join the bits of numbers, else what is not 0.
    """

    levels: tuple[re.Pattern[str], ...]
    o_words: bool
    vacant: bool
    lowest: int
    locals: int
    last: int
    system: range
    read_only: tuple[range, ...]
    layout: str
    full_turn: bool
    floored: bool
    bitwise: bool


def _levels(*levels: str) -> tuple[re.Pattern[str], ...]:
    return tuple(re.compile("|".join(map(re.escape, names.split()))) for names in levels)


COMPARISONS = "EQ NE GT GE LT LE"

MACRO_B = MacroRules(
    levels=_levels("* / MOD AND", "+ - OR XOR", COMPARISONS),
    o_words=False,
    vacant=True,
    lowest=0,
    locals=33,
    last=9999,
    system=range(1000, 10_000),
    read_only=(range(4001, 4131), range(5001, 5047)),
    layout="macro_b",
    full_turn=True,
    floored=False,
    bitwise=True,
)

MACROS = {
    "macro_b": MACRO_B,
    "macro_b_haas": replace(MACRO_B, last=10_999),
    "o_words": MacroRules(
        levels=_levels("**", "* / MOD", "+ -", COMPARISONS, "AND OR XOR"),
        o_words=True,
        vacant=False,
        lowest=1,
        locals=30,
        last=5602,
        system=range(5000, 10_000),
        read_only=(range(5400, 5429),),
        layout="linuxcnc",
        full_turn=False,
        floored=True,
        bitwise=False,
    ),
    # Nothing of these rules comes to pass: macro text is refused.
    "none": MACRO_B,
}
"""Readings.macros -> rules."""

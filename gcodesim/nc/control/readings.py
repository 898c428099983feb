"""Where controls differ: one row per dialect, single keys may be overridden by the machine file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

from gcodesim.errors import UsageError


@dataclass(frozen=True)
class Dialect:
    """How one family of controls reads what the standard leaves open.

    Attributes:
        cycle_return: return level of cycles at program start: G98 | G99.
        dwell_p: unit of P with G4: ms | s | point (ms without a decimal point, s with one).
        g80: G80 ends the motion mode, or only cycles: motion | cycle.
        r_and_ijk: an arc with R and centre words: r_wins | error.
        macros: language of macros: fanuc (Macro B) | linuxcnc (with o-words).
        m99: M99 in the main program: end (one pass) | restart.
        g87: back boring with a shift Q, or with centre words I J and the top K: shift | centre.
    """

    name: str
    cycle_return: str
    dwell_p: str
    g80: str
    r_and_ijk: str
    g87: str
    macros: str
    m99: str


DIALECTS: dict[str, Dialect] = {
    "fanuc": Dialect("fanuc", "G98", "ms", "cycle", "r_wins", "shift", "fanuc", "end"),
    "haas": Dialect("haas", "G98", "point", "cycle", "error", "shift", "fanuc", "end"),
    "linuxcnc": Dialect(
        *("linuxcnc", "G99", "s", "motion", "error", "centre", "linuxcnc", "restart")
    ),
}

CHOICES: dict[str, tuple[str, ...]] = {
    "cycle_return": ("G98", "G99"),
    "dwell_p": ("ms", "s", "point"),
    "g80": ("motion", "cycle"),
    "r_and_ijk": ("r_wins", "error"),
    "g87": ("shift", "centre"),
    "macros": ("fanuc", "linuxcnc"),
    "m99": ("end", "restart"),
}


def choose_dialect(name: str, overrides: Mapping[str, Any] | None = None) -> Dialect:
    """Return the dialect `name` with single keys replaced.

    Raises:
        UsageError: the name, a key or a value is not known.
    """
    if name not in DIALECTS:
        raise UsageError(f"unknown dialect {name!r}; known are {', '.join(DIALECTS)}")
    for key, value in (overrides or {}).items():
        if key not in CHOICES:
            raise UsageError(f"unknown dialect key {key!r}; known are {', '.join(CHOICES)}")
        if value not in CHOICES[key]:
            known = ", ".join(CHOICES[key])
            raise UsageError(f"dialect key {key} cannot be {value!r}; known are {known}")
    return replace(DIALECTS[name], **(overrides or {}))


assert set(CHOICES) == {field.name for field in fields(Dialect)} - {"name"}

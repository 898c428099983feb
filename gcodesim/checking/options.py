"""What a user may choose for a check; a module of its own, because it is quick to import."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from numbers import Integral, Real
from typing import Any

from gcodesim.constants import DEFAULT_PERIOD_PS, MAX_PERIOD_PS, MIN_PERIOD_PS
from gcodesim.errors import UsageError

METHODS = ("search", "exhaustive", "paper")
ONLY_SEARCH = ("clearance", "minimum", "stop_all", "audit")
"""Only the method search knows distances: these must not be dropped in silence."""


@dataclass(frozen=True)
class Options:
    """What a user may choose for a check.

    Attributes:
        dialect: fanuc | haas | linuxcnc: replaces the dialect of the machine file.
        feed: feed until the first F word [mm/min].
        period_ps: sample period [ps].
        device: auto | cpu | cuda | cuda:N.
        method: search | exhaustive | paper.
        between: prove the time between samples too (method search).
        clearance: replaces the clearance of every pair [mm] (method search).
        minimum: find the smallest distance of every pair (method search).
        nearest: find the pair that comes nearest, and its distance (method search).
        stop_all: list every contact, not only the first (method search).
        audit: check again with nothing left out, and compare (method search).
        block_delete: leave out blocks that begin with /.
        max_blocks: interpretation ends after this many blocks; None = see Control.
        threads: searches side by side on the CPU, 0 for one per core.

    Raises:
        UsageError: a value cannot be used, or does not go with the method.
    """

    dialect: str | None = None
    feed: float | None = None
    period_ps: int = DEFAULT_PERIOD_PS
    device: str = "auto"
    method: str = "search"
    between: bool = True
    clearance: float | None = None
    minimum: bool = False
    nearest: bool = False
    stop_all: bool = False
    audit: bool = False
    block_delete: bool = False
    max_blocks: int | None = None
    threads: int = 0

    def __post_init__(self) -> None:
        """Refuse what cannot be used here, and not somewhere on the way through a check."""
        for name, (fits, right) in RULES.items():
            value = getattr(self, name)
            if not fits(value):
                raise UsageError(f"Options: {name}={value!r}: expected {right}")
        for name in ONLY_SEARCH:
            is_asked = getattr(self, name) is not None and getattr(self, name) is not False
            if is_asked and self.method != "search":
                raise UsageError(f"Options: {name} needs method='search', not {self.method!r}")

    @property
    def language(self) -> tuple[str | None, float | None, bool, int | None]:
        """What control_for takes, besides the machine."""
        return self.dialect, self.feed, self.block_delete, self.max_blocks


def _is_number(value: Any) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool) and math.isfinite(value)


def _is_count(value: Any, low: int) -> bool:
    return isinstance(value, Integral) and not isinstance(value, bool) and int(value) >= low


def _is_device(value: Any) -> bool:
    return isinstance(value, str) and re.fullmatch(r"auto|cpu|cuda(:\d+)?", value) is not None


def _is_switch(value: Any) -> bool:
    return isinstance(value, bool)


Rule = tuple[Callable[[Any], bool], str]
SWITCH: Rule = (_is_switch, "True or False")

RULES: dict[str, Rule] = {
    "dialect": (lambda v: v is None or isinstance(v, str), "the name of a dialect, or None"),
    "feed": (lambda v: v is None or (_is_number(v) and v > 0.0), "mm/min above 0, or None"),
    "period_ps": (
        lambda v: _is_count(v, MIN_PERIOD_PS) and v <= MAX_PERIOD_PS,
        f"whole picoseconds from {MIN_PERIOD_PS} (1 us) to {MAX_PERIOD_PS} (10 s)",
    ),
    "device": (_is_device, "auto, cpu, cuda or cuda:N"),
    "method": (lambda v: v in METHODS, ", ".join(METHODS)),
    "clearance": (lambda v: v is None or (_is_number(v) and v >= 0.0), "mm, 0 or more, or None"),
    "max_blocks": (lambda v: v is None or _is_count(v, 1), "a whole number from 1 on, or None"),
    "threads": (lambda v: _is_count(v, 0), "a whole number, 0 for one per core"),
    **dict.fromkeys(("between", "minimum", "nearest", "stop_all", "audit", "block_delete"), SWITCH),
}
"""Field -> what tells that a value can be used, and what to write instead."""

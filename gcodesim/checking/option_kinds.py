"""Kinds of options: which values can be used, what is right instead, and how it is written."""

from __future__ import annotations

import math
import re
from abc import ABC, abstractmethod
from dataclasses import dataclass
from numbers import Integral, Real
from typing import Any

from gcodesim.constants import MAX_PERIOD_PS, MIN_PERIOD_PS, PS_PER_S


class OptionKind(ABC):
    """What the values of an option have in common."""

    @property
    @abstractmethod
    def right(self) -> str:
        """What is expected, for errors."""

    @abstractmethod
    def fits(self, value: Any) -> bool:
        """Whether a value can be used."""

    def written(self, value: Any) -> str:
        """A value as it is written on the command line and in settings."""
        return str(value)


@dataclass(frozen=True)
class Switch(OptionKind):
    """True or False.

    Attributes:
        words: what the command line calls the two, False first; without them it has a flag.
        negative: the flag that says no, where that is not the same as saying nothing.
    """

    words: tuple[str, str] | None = None
    negative: str = ""

    @property
    def right(self) -> str:
        """The two values."""
        return "True or False"

    def fits(self, value: Any) -> bool:
        """Whether it is one of the two."""
        return isinstance(value, bool)

    def written(self, value: Any) -> str:
        """The word, or true or false."""
        return (self.words or ("false", "true"))[value]


@dataclass(frozen=True)
class OneOf(OptionKind):
    """One of some words."""

    words: tuple[str, ...]

    @property
    def right(self) -> str:
        """The words."""
        return ", ".join(self.words)

    def fits(self, value: Any) -> bool:
        """Whether it is one of the words."""
        return value in self.words


@dataclass(frozen=True)
class Text(OptionKind):
    """Any text."""

    @property
    def right(self) -> str:
        """What it is."""
        return "a text"

    def fits(self, value: Any) -> bool:
        """Whether it is a text."""
        return isinstance(value, str)


@dataclass(frozen=True)
class DialectName(Text):
    """The name of a dialect; whether there is one of that name is asked where it is used."""

    words: tuple[str, ...]

    @property
    def right(self) -> str:
        """What it is."""
        return "the name of a dialect"


@dataclass(frozen=True)
class File(Text):
    """A file; in a settings file counted from the folder of that file."""


@dataclass(frozen=True)
class MachineName(Text):
    """A machine file, counted like any file, or else the name of a shipped machine."""


@dataclass(frozen=True)
class ReportFile(Text):
    """A format and the file that a report is written to, FORMAT=PATH."""


@dataclass(frozen=True)
class Number(OptionKind):
    """A finite number from 0 on, or above 0."""

    unit: str
    above_zero: bool = False

    @property
    def right(self) -> str:
        """Unit and range."""
        return f"{self.unit} above 0" if self.above_zero else f"{self.unit}, 0 or more"

    def fits(self, value: Any) -> bool:
        """Whether it is a number of the range."""
        if not isinstance(value, Real) or isinstance(value, bool) or not math.isfinite(value):
            return False
        return float(value) > 0.0 if self.above_zero else float(value) >= 0.0


@dataclass(frozen=True)
class Count(OptionKind):
    """A whole number.

    Attributes:
        low: the smallest.
        remark: what is special about the smallest.
    """

    low: int
    remark: str = ""

    @property
    def right(self) -> str:
        """The range."""
        return f"a whole number{f', {self.remark}' if self.remark else f' from {self.low} on'}"

    def fits(self, value: Any) -> bool:
        """Whether it is a whole number of the range."""
        return _is_whole(value) and value >= self.low


@dataclass(frozen=True)
class Period(OptionKind):
    """A time between samples [ps]; people write it with its unit."""

    @property
    def right(self) -> str:
        """The range."""
        return f"whole picoseconds from {MIN_PERIOD_PS} (1 us) to {MAX_PERIOD_PS} (10 s)"

    def fits(self, value: Any) -> bool:
        """Whether it is a whole number of the range."""
        return _is_whole(value) and MIN_PERIOD_PS <= value <= MAX_PERIOD_PS

    def written(self, value: Any) -> str:
        """The period in milliseconds."""
        return f"{value * 1000 / PS_PER_S:g}ms"


@dataclass(frozen=True)
class Device(OptionKind):
    """Where to compute; whether there is such a device is asked where it is used."""

    @property
    def right(self) -> str:
        """What a device may be called."""
        return "auto, cpu, cuda or cuda:N"

    def fits(self, value: Any) -> bool:
        """Whether a device may be called so."""
        return isinstance(value, str) and re.fullmatch(r"auto|cpu|cuda(:\d+)?", value) is not None


@dataclass(frozen=True)
class Shard(OptionKind):
    """Part I of N, counted from 1."""

    @property
    def right(self) -> str:
        """What is expected."""
        return "a part and how many there are, such as 2/5"

    def fits(self, value: Any) -> bool:
        """Whether it is a pair of such numbers."""
        index, count = value
        return _is_whole(index) and _is_whole(count) and 1 <= index <= count

    def written(self, value: Any) -> str:
        """I/N."""
        return "/".join(map(str, value))


def _is_whole(value: Any) -> bool:
    return isinstance(value, Integral) and not isinstance(value, bool)

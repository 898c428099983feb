"""What a user may choose for a check; a module of its own, because it is quick to import."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, fields
from enum import Enum
from typing import Any, NamedTuple

from gcodesim.checking.option_kinds import (
    Count,
    Device,
    DialectName,
    Number,
    OneOf,
    OptionKind,
    Period,
    Switch,
    Text,
)
from gcodesim.constants import DEFAULT_PERIOD_PS
from gcodesim.errors import UsageError
from gcodesim.nc.control.readings import ROWS

METHODS = ("search", "exhaustive", "paper")


class Scope(Enum):
    """Where an option may be given; what may stand in a job may also stand above the jobs."""

    JOB = "command line, settings, jobs"
    RUN = "command line, settings"
    COMMAND_LINE = "command line"


@dataclass(frozen=True, kw_only=True)
class Option:
    """One thing that a user may choose: a field, an option of commands, a key of settings.

    Attributes:
        kind: which values it may have.
        help: what it does, for people.
        name: long option without dashes, and key of settings; "" where only Python has it.
        metavar: what its value is called on the command line.
        many: it is a list, and on the command line it may be repeated.
        table: in settings the list may be a table, too.
        scope: where it may be given.
        language: it is about how the control reads a program.
        only_search: only the method search can do it.
        commands: commands that have it.
    """

    kind: OptionKind
    help: str
    name: str
    metavar: str = ""
    many: bool = False
    table: bool = False
    scope: Scope = Scope.JOB
    language: bool = False
    only_search: bool = False
    commands: tuple[str, ...] = ("check", "batch")

    def goes_with(self, value: Any, method: str) -> bool:
        """Tell whether a method can do what a value asks for: only the search knows distances."""
        is_asked = value is not None and value is not False
        return not (self.only_search and is_asked) or method == "search"


def option(default: Any, kind: OptionKind, help_text: str, *, name: str, **more: Any) -> Any:
    """A field that describes itself.

    Args:
        default: value where it is not given.
        kind: which values it may have.
        help_text: what it does.
        name: long option without dashes; "" where only Python has it.
        more: further fields of Option.
    """
    described = Option(kind=kind, help=help_text, name=name, **more)
    return field(default=default, metadata={Option: described})


class OptionField(NamedTuple):
    """A field that describes itself.

    Attributes:
        field: its name.
        option: what it says of itself.
        default: value where it is not given.
    """

    field: str
    option: Option
    default: Any


def options_of(model: type) -> Iterator[OptionField]:
    """Yield the fields of a dataclass that describe themselves."""
    for each in fields(model):
        if Option in each.metadata:
            yield OptionField(each.name, each.metadata[Option], each.default)


@dataclass(frozen=True)
class Options:
    """What a user may choose for a check.

    Raises:
        UsageError: a value cannot be used, or does not go with the method.
    """

    dialect: str | None = option(
        None,
        DialectName(tuple(ROWS)),
        "How the control reads the program. Left out: as the machine file says.",
        name="dialect",
        language=True,
    )
    feed: float | None = option(
        None,
        Number("mm/min", above_zero=True),
        "Feed until the first F word. Left out: a feed move before any F is an error.",
        name="feed",
        metavar="MM/MIN",
        language=True,
    )
    period_ps: int = option(
        DEFAULT_PERIOD_PS,
        Period(),
        "Time between samples, with its unit.",
        name="sample-period",
        metavar="TIME",
    )
    device: str = option(
        "auto",
        Device(),
        "Where to compute: auto, cpu, cuda or cuda:N; auto takes CUDA when present.",
        name="device",
        metavar="NAME",
        scope=Scope.RUN,
    )
    method: str = option(
        "search",
        OneOf(METHODS),
        "search: proves stretches of time free; exhaustive: every sample, certified; paper: the "
        "seed paper's way, for comparison. All find the same first contact at samples.",
        name="method",
    )
    between: bool = option(
        True,
        Switch(("off", "on")),
        "Prove the time between the samples too, down to 0.001 mm (method search).",
        name="between-samples",
    )
    clearance: float | None = option(
        None,
        Number("mm"),
        "Distance every pair must keep, instead of what the machine file says (method search).",
        name="clearance",
        metavar="MM",
        only_search=True,
    )
    minimum: bool = option(
        False,
        Switch(negative="no-min-clearance"),
        "Report how near every pair comes (to a thousandth of the distance), when and in which "
        "line (method search). Left out: a batch reports the nearest pair, and with "
        "--no-min-clearance none.",
        name="min-clearance",
        only_search=True,
    )
    nearest: bool = option(
        False,
        Switch(),
        "Report the pair that comes nearest, and its distance, as a batch does (method search).",
        name="",
    )
    stop_all: bool = option(
        False,
        Switch(("first", "all")),
        "Stop at the first contact, or list every stretch of contact and every place that is too "
        "near (method search).",
        name="stop",
        only_search=True,
    )
    audit: bool = option(
        False,
        Switch(),
        "Check again with nothing left out, and compare (method search).",
        name="audit",
        only_search=True,
    )
    block_delete: bool = option(
        False,
        Switch(),
        "Leave out blocks that begin with /.",
        name="block-delete",
        language=True,
    )
    max_blocks: int | None = option(
        None,
        Count(1),
        "Blocks after which the program counts as endless (INCONCLUSIVE). Left out: 100 million, "
        "or 5 million that loops and calls repeat.",
        name="max-blocks",
        metavar="N",
        language=True,
    )
    main_program: str | None = option(
        None,
        Text(),
        "Which program of the file runs: O-number or <NAME>, empty for the first. Left out: the "
        "first, with a note about the others.",
        name="",
    )
    threads: int = option(
        0,
        Count(0, "0 for one per core"),
        "Searches side by side on the CPU, 0 for one per core.",
        name="",
    )

    def __post_init__(self) -> None:
        """Refuse what cannot be used here, and not somewhere on the way through a check."""
        for name, described, default in options_of(Options):
            value = getattr(self, name)
            if not described.kind.fits(value) and not (value is None and default is None):
                right = f"{described.kind.right}{', or None' if default is None else ''}"
                raise UsageError(f"Options: {name}={value!r}: expected {right}")
        for name, described, _ in options_of(Options):
            if not described.goes_with(getattr(self, name), self.method):
                raise UsageError(f"Options: {name} needs method='search', not {self.method!r}")

    @property
    def language(self) -> tuple[str | None, float | None, bool, int | None]:
        """What control_for takes, besides the machine."""
        return self.dialect, self.feed, self.block_delete, self.max_blocks


Options.__doc__ = f"{Options.__doc__}\nFields:\n" + "".join(
    f"    {name}: {described.help} ({described.kind.right}; default {default!r})\n"
    for name, described, default in options_of(Options)
)

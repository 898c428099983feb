"""The outcome of a check: first contact, findings, coverage, and the verdict that follows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from gcodesim.constants import TOLERANCE_MM
from gcodesim.findings.codes import CLEARANCES, FAIL, INCONCLUSIVE, NOTED, Finding
from gcodesim.findings.left_out import LeftOut, NotRun

if TYPE_CHECKING:
    from gcodesim.checking.replay import Replay

PASS = "pass"

CONTRACT = (
    "PASS means that the machine, moved as the program commands, brings no checked pair of parts "
    "into contact: at no sample, and at no instant between samples to within the stated tolerance; "
    "whatever was not checked makes the verdict INCONCLUSIVE."
)
"""What a verdict promises, word for word as in README, --help and the report."""

LEVELS = ("contact", "error", "warning", "note")
"""What makes a program FAIL (--fail-on): contacts only, or findings of this severity and above."""

EXIT_CODES = {PASS: 0, FAIL: 1, INCONCLUSIVE: 3}
USAGE_EXIT, INTERRUPT_EXIT = 2, 130
EXIT_ORDER = (USAGE_EXIT, 1, 3, 0)
"""Of several programs, the worst exit code counts, in this order."""


@dataclass(frozen=True)
class FirstContact:
    """The first contact of a program.

    Attributes:
        sample: smallest sample index in contact; time_s is the instant looked at, at most one
            sample period before it.
        pair, parts, triangles: what touches; triangles are numbered within their part.
        point_mm: a shared point, world coordinates.
        axes: axis letter -> position [mm, deg].
    """

    sample: int
    time_s: float
    pair: tuple[str, str]
    parts: tuple[str, str]
    triangles: tuple[int, int] | None
    point_mm: tuple[float, float, float] | None
    line: int
    block: str
    axes: dict[str, float]
    tool: int | None
    between_samples: bool = False
    distance_mm: float = 0.0


@dataclass(frozen=True)
class ReadingTaken:
    """How a word was read that controls read in several ways, and what another way would give.

    `value` is the way that the report is of; `verdict` is that of the other ways where the check
    has tried them (`varied`); `agrees`: all that counts there counts in the first way too. The key
    `together` is all of them changed at once.
    """

    key: str
    value: str
    varied: bool
    line: int
    count: int
    verdict: str = ""
    agrees: bool = True


@dataclass(frozen=True)
class StockCoverage:
    """How a stock was followed as it is cut away.

    Nothing is deeper in it than `inset_mm`, or a contact is deeper than half of it; `undecided` of
    its beams, `width_mm` wide, stay open.
    """

    stock: str
    inset_mm: float
    undecided: int
    width_mm: float
    beams: int
    moves: int


@dataclass(frozen=True)
class OtherWay:
    """Another way of reading a program: `key` read as `value`, and what that gives."""

    key: str
    value: str
    result: CheckResult


@dataclass(frozen=True)
class Coverage:
    """What was checked, and what was not.

    `off_path` says how far the real machine may be from the path that was checked, and what of
    that is only assumed. `not_run` says which lines of the program did not run, or may do something
    else than what was checked, each with the number of the first line in its file.
    """

    pairs: tuple[tuple[str, str], ...] = ()
    between_samples: bool = False
    unsupported: tuple[str, ...] = ()
    ignored: tuple[str, ...] = ()
    uncertified: tuple[str, ...] = ()
    unchecked_by_rule: tuple[str, ...] = ()
    off_path: tuple[str, ...] = ()
    readings: tuple[ReadingTaken, ...] = ()
    not_run: tuple[NotRun, ...] = ()
    stocks: tuple[StockCoverage, ...] = ()


@dataclass(frozen=True)
class ContactInterval:
    """A stretch of program time in which two parts touch (--stop all).

    Attributes:
        deepest_mm, deepest_at_s: of a point of one body inside the other, at the instants looked
            at; at others it may be deeper by `deeper_by_mm`.
    """

    pair: tuple[str, str]
    parts: tuple[str, str]
    from_s: float
    to_s: float
    deepest_mm: float
    deepest_at_s: float
    between_samples: bool = False
    deeper_by_mm: float = 0.0


@dataclass(frozen=True)
class SmallestDistance:
    """The smallest distance of a pair in the whole program (--min-clearance)."""

    pair: tuple[str, str]
    minimum_mm: float
    time_s: float
    line: int


@dataclass(frozen=True)
class LargestStep:
    """The largest distance a vertex can move against its partner from sample to sample."""

    mm: float
    pair: tuple[str, str]
    line: int


@dataclass(frozen=True)
class CheckResult:
    """Everything a report shows about one program.

    `tool_times` are numbers of tools, None before the first change, with their program time [s];
    `tolerance_mm` is the distance below which time between samples does not count as free;
    `main_program` names the program of the file, empty for the first;
    `fail_on` is one of LEVELS; `setup` the file it ran with; `pictures` are files
    that show what was found; `replay` is what they are made of, dropped where they are written;
    `looked_up` are the files that the program called, or for which it was looked, each with a mark
    of its content, "" where there is none; `ways` are the other ways of reading the program, until
    the policy has judged them as it judges this one.
    """

    program: str
    machine: str
    verified_model: bool
    device: str
    method: str
    dialect: str
    sample_period_s: float
    samples: int
    duration_s: float
    blocks: int
    first_contact: FirstContact | None
    findings: tuple[Finding, ...]
    coverage: Coverage
    tool_times: tuple[tuple[int | None, float], ...] = ()
    tolerance_mm: float = TOLERANCE_MM
    largest_step: LargestStep | None = None
    contacts: tuple[ContactInterval, ...] = ()
    clearances: tuple[SmallestDistance, ...] = ()
    left_out: tuple[LeftOut, ...] = ()
    work: dict[str, int] = field(default_factory=dict)
    timing_s: dict[str, float] = field(default_factory=dict)
    main_program: str = ""
    fail_on: str = "error"
    setup: str = ""
    pictures: tuple[str, ...] = ()
    replay: Replay | None = field(default=None, repr=False, compare=False)
    looked_up: Mapping[str, str] = field(default_factory=dict, repr=False, compare=False)
    ways: tuple[OtherWay, ...] = field(default=(), repr=False, compare=False)

    @property
    def title(self) -> str:
        """The name of the file, and of the program where it is not the file's first."""
        return f"{self.program} {self.main_program}".rstrip()

    @property
    def verdict(self) -> str:
        """pass, fail or inconclusive."""
        own = decide(self.findings, self.samples, len(self.coverage.pairs), self.fail_on)
        # PASS and FAIL hold only if every way in which the program may be read gives them.
        readings = self.coverage.readings
        return own if all(r.agrees or r.verdict == own for r in readings) else INCONCLUSIVE

    @property
    def shown(self) -> FirstContact | Finding | None:
        """What a picture shows: the first contact, or else the first pair that comes too near."""
        near = [f for f in self.counted if f.code in CLEARANCES and f.time_s is not None]
        first = min(near, key=lambda f: (f.severity != "error", f.time_s), default=None)
        return self.first_contact or first

    @property
    def counted(self) -> tuple[Finding, ...]:
        """The findings that count."""
        return tuple(finding for finding in self.findings if not finding.ignored)

    @property
    def ignored(self) -> tuple[Finding, ...]:
        """The findings that somebody asked to ignore."""
        return tuple(finding for finding in self.findings if finding.ignored)


def effect_at(finding: Finding, fail_on: str) -> str:
    """Effect of a finding under --fail-on.

    A laxer level never turns what was not checked into a PASS: a refused program is INCONCLUSIVE
    where it does not count as FAIL.
    """
    if finding.is_contact or fail_on == "error":
        return finding.effect
    if fail_on == "contact":
        if finding.effect != FAIL or finding.code == "GC601":
            return finding.effect
        return INCONCLUSIVE if finding.leaves_unchecked else NOTED
    strict = LEVELS.index(finding.severity) <= LEVELS.index(fail_on)
    return FAIL if strict and finding.effect == NOTED else finding.effect


def decide(findings: Sequence[Finding], samples: int, pairs: int, fail_on: str = "error") -> str:
    """Verdict that follows from the findings that count: nothing checked is never a pass."""
    effects = {effect_at(finding, fail_on) for finding in findings if not finding.ignored}
    if FAIL in effects:
        return FAIL
    if INCONCLUSIVE in effects or samples == 0 or pairs == 0:
        return INCONCLUSIVE
    return PASS


def worst_exit(codes: Sequence[int]) -> int:
    """Exit code of several programs."""
    return min(codes, key=EXIT_ORDER.index)

"""One run of the command: the results that every report format is a view of."""

from __future__ import annotations

from dataclasses import dataclass

from gcodesim.checking.verdict import CheckResult

FORMATS = ("text", "json", "jsonl", "junit", "sarif", "github", "gitlab")
"""Names of the formats; gcodesim.report.formats writes them."""


@dataclass(frozen=True)
class Failure:
    """A program that could not be checked at all, and why."""

    program: str
    message: str


@dataclass(frozen=True)
class RunOutcome:
    """Programs in the order they were checked, and those that could not be."""

    results: tuple[CheckResult, ...]
    failures: tuple[Failure, ...] = ()

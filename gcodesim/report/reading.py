"""Reads JSON reports back: a batch has these of its programs, and writes every format from them."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Iterable
from dataclasses import fields, replace
from typing import Any

from gcodesim.checking.verdict import (
    CheckResult,
    ContactInterval,
    Coverage,
    FirstContact,
    LargestStep,
    ReadingTaken,
    SmallestDistance,
    StockCoverage,
)
from gcodesim.errors import UsageError
from gcodesim.findings.codes import Finding, Ignored
from gcodesim.findings.fingerprints import fingerprint, likeness
from gcodesim.findings.left_out import LeftOut, NotRun
from gcodesim.report.outcome import Failure, RunOutcome

NESTED = {"contacts": ContactInterval, "clearances": SmallestDistance, "left_out": LeftOut}
SINGLE = {"first_contact": FirstContact, "coverage": Coverage, "largest_step": LargestStep}
LISTS = ("findings", "suppressed")


def outcome_of(
    records: Iterable[dict[str, Any]],
    missing: Iterable[dict[str, str]] = (),
    shards: Iterable[str] = (),
) -> RunOutcome:
    """The run that the records of a batch are of, by program, machine and setup.

    Args:
        records: what became of jobs.
        missing: labels of jobs without a record; what was not checked is reported as not read.
        shards: parts of the batch that are not there.

    Raises:
        UsageError: a report is not one of this version.
    """
    records = sorted(records, key=_place)
    results = [result_of_record(record) for record in records if "report" in record]
    failures = [Failure(r["program"], r["error"]) for r in records if "error" in r]
    failures += [Failure(job["program"], "not checked") for job in sorted(missing, key=_place)]
    failures += [Failure(f"shard {shard}", "not there") for shard in shards]
    return RunOutcome(tuple(results), tuple(dict.fromkeys(failures)))


def result_of_record(record: dict[str, Any]) -> CheckResult:
    """The result of a record of a batch; UsageError where its report is not of this version."""
    try:
        return result_of(record["report"])
    except (KeyError, TypeError, ValueError) as error:
        text = f"its record is not of this version of gcodesim ({error!r}): check it again"
        raise UsageError(f"{record['program']}: {text}") from error


def result_of(report: dict[str, Any]) -> CheckResult:
    """The result that a JSON report is of; it renders to the same bytes in every format.

    Only the motion, which pictures are made of, is not there.

    Raises:
        KeyError, TypeError, ValueError: it is no report of this version.
    """
    values = {f.name: _frozen(report[f.name]) for f in fields(CheckResult) if f.name in report}
    for name, kind in NESTED.items():
        values[name] = tuple(_made(kind, value) for value in report[name])
    for name, kind in SINGLE.items():
        values[name] = _made(kind, report[name]) if report[name] else None
    coverage = values["coverage"]
    taken = tuple(_made(ReadingTaken, dict(entry)) for entry in report["coverage"]["readings"])
    not_run = tuple(_made(NotRun, dict(entry)) for entry in report["coverage"]["not_run"])
    stocks = tuple(
        _made(StockCoverage, dict(entry)) for entry in report["coverage"].get("stocks", ())
    )
    values["coverage"] = replace(coverage, readings=taken, not_run=not_run, stocks=stocks)
    times = tuple((entry["tool"], entry["time_s"]) for entry in report["tool_times"])
    return CheckResult(**values | {"tool_times": times, "findings": _findings(report)})


def _place(label: dict[str, Any]) -> tuple[str, ...]:
    return label["program"], label["machine"], label["setup"]


def _findings(report: dict[str, Any]) -> tuple[Finding, ...]:
    """What counts and what does not, in one row that gives them their fingerprints again.

    Findings that are alike are distinguished by their order only.
    """
    queues = [deque((_finding(row), row["fingerprint"]) for row in report[name]) for name in LISTS]
    found: list[Finding] = []
    seen: Counter[str] = Counter()
    while waiting := [queue for queue in queues if queue]:
        keys = [likeness(queue[0][0]) for queue in waiting]
        due = (n for n, key in enumerate(keys) if fingerprint(key, seen[key]) == waiting[n][0][1])
        chosen = next(due, 0)
        found.append(waiting[chosen].popleft()[0])
        seen[keys[chosen]] += 1
    return tuple(found)


def _finding(row: dict[str, Any]) -> Finding:
    values = {name: _frozen(value) for name, value in row.items() if name != "fingerprint"}
    if "ignored" in values:
        values["ignored"] = Ignored(**values["ignored"])
    return Finding(**values)


def _made(kind: Any, values: dict[str, Any]) -> Any:
    return kind(**{name: _frozen(value) for name, value in values.items()})


def _frozen(value: Any) -> Any:
    """A value with tuples for lists, which JSON does not tell apart."""
    return tuple(map(_frozen, value)) if isinstance(value, list) else value

"""Checks a program in every way in which a control whose parameters are not known may read it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

from gcodesim.checking.verdict import PASS, CheckResult, ReadingTaken
from gcodesim.constants import DEPTH_SLACK
from gcodesim.findings.codes import FAIL, Finding
from gcodesim.findings.fingerprints import likeness
from gcodesim.findings.meanings import MEANINGS
from gcodesim.nc.control.readings import is_varied, ways_of

TOGETHER = "together"
"""In place of a key: all keys changed at once."""

Again = Callable[[Mapping[str, str]], CheckResult]
"""Checks the same program with some keys of the readings changed."""


def varied(first: CheckResult, again: Again) -> CheckResult:
    """Return a result that holds for every way in which the program may be read.

    Each key is changed alone, then all of them together; the report stays that of the first ways.

    Args:
        first: the result with the first way of every key.
        again: makes the result of another way.
    """
    readings, findings = [], list(first.findings)
    changed: dict[str, str] = {}
    looked_up = dict(first.looked_up)
    for reading in first.coverage.readings:
        if not is_varied(reading.key):
            readings.append(reading)
            continue
        others = {way: again({reading.key: way}) for way in ways_of(reading.key)[1:]}
        changed[reading.key] = next(iter(others))
        for result in others.values():
            looked_up |= result.looked_up
        agrees = all(_agrees(first, result) for result in others.values())
        verdict = _verdict(first, others)
        readings.append(replace(reading, varied=True, verdict=verdict, agrees=agrees))
        findings += _differences(first, reading, others)
    if len(changed) > 1:
        result = again(changed)
        looked_up |= result.looked_up
        line = min(reading.line for reading in readings if reading.varied)
        agrees, verdict = _agrees(first, result), result.verdict
        all_keys = ReadingTaken(TOGETHER, ", ".join(changed), True, line, 1, verdict, agrees)
        readings.append(all_keys)
        if result.verdict != first.verdict and len(findings) == len(first.findings):
            findings.append(_difference(first, all_keys, "the other way", result))
    coverage = replace(first.coverage, readings=tuple(readings))
    return replace(first, findings=tuple(findings), coverage=coverage, looked_up=looked_up)


def _agrees(first: CheckResult, other: CheckResult) -> bool:
    """Tell whether another way gives the same verdict, for nothing that the first has not found.

    What is ignored in the first result is then ignored in the other too, if it is no deeper there.
    """
    known = _failing(first)
    return other.verdict == first.verdict and all(
        key in known and depth <= known[key] + DEPTH_SLACK for key, depth in _failing(other).items()
    )


def _failing(result: CheckResult) -> dict[str, float]:
    """Return the likenesses of the findings that make a program fail, with their depths."""
    depths: dict[str, float] = {}
    for finding in (f for f in result.findings if f.effect == FAIL):
        key = likeness(finding)
        depths[key] = max(depths.get(key, 0.0), finding.depth or 0.0)
    return depths


def _verdict(first: CheckResult, others: Mapping[str, CheckResult]) -> str:
    """Return the verdict of the other ways: that of the first result where they all agree."""
    return next((r.verdict for r in others.values() if r.verdict != first.verdict), first.verdict)


def _differences(
    first: CheckResult, reading: ReadingTaken, others: Mapping[str, CheckResult]
) -> list[Finding]:
    return [
        _difference(first, reading, way, result)
        for way, result in others.items()
        if result.verdict != first.verdict
    ]


def _difference(
    first: CheckResult, reading: ReadingTaken, way: str, result: CheckResult
) -> Finding:
    """Return the finding that another way of reading gives another verdict, and why."""
    code, right = MEANINGS["reading_matters"]
    what = f"{reading.key}: {reading.value} gives {_outcome(first)}, {way} gives {_outcome(result)}"
    line = reading.line or None
    return Finding(
        code, f"{what}: {right}", meaning="reading_matters", file=first.program, line=line
    )


def _outcome(result: CheckResult) -> str:
    """Return a verdict, with what decides it."""
    if result.verdict == PASS:
        return "PASS"
    contact = result.first_contact
    if contact is not None:
        return f"a contact of {contact.pair[0]} and {contact.pair[1]} in line {contact.line}"
    weightiest = [f for f in result.counted if f.effect == result.verdict or f.effect == FAIL]
    return weightiest[0].code if weightiest else result.verdict.upper()

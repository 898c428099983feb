"""Checks a program in every way in which a control whose parameters are not known may read it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace

from gcodesim.checking.verdict import PASS, CheckResult, OtherWay, ReadingTaken
from gcodesim.constants import DEPTH_SLACK
from gcodesim.findings.codes import FAIL, Finding
from gcodesim.findings.fingerprints import likeness
from gcodesim.findings.meanings import MEANINGS
from gcodesim.nc.control.readings import is_varied, ways_of

TOGETHER = "together"
"""In place of a key: all keys changed at once."""

MATTERS = "reading_matters"
"""Meaning of the finding that another way of reading gives another verdict."""

Again = Callable[[Mapping[str, str]], CheckResult]
"""Checks the same program with some keys of the readings changed."""


def varied(first: CheckResult, again: Again) -> CheckResult:
    """Return a result that holds for every way in which the program may be read.

    Each key is changed alone, then all of them together; the report stays that of the first ways.

    Args:
        first: the result with the first way of every key.
        again: makes the result of another way.
    """
    keys = [r.key for r in first.coverage.readings if is_varied(r.key)]
    ways = [OtherWay(key, value, again({key: value})) for key in keys for value in ways_of(key)[1:]]
    if len(keys) > 1:
        changed = {key: ways_of(key)[1] for key in keys}
        ways.append(OtherWay(TOGETHER, "the other way", again(changed)))
    looked_up = dict(first.looked_up)
    for way in ways:
        looked_up |= way.result.looked_up
    told = tuple(replace(way, result=replace(way.result, replay=None)) for way in ways)
    return compared(replace(first, looked_up=looked_up, ways=told))


def compared(first: CheckResult) -> CheckResult:
    """Return a result with what its other ways of reading give, and GC427 where they differ.

    What was ignored, in it and in the other ways, does not make them differ.
    """
    if not first.ways:
        return first
    first = _alone(first)
    findings, readings = list(first.findings), []
    for reading in [*first.coverage.readings, *_together(first)]:
        ways = [way for way in first.ways if way.key == reading.key]
        if not ways:
            readings.append(reading)
            continue
        agrees = all(_agrees(first, way.result) for way in ways)
        verdicts = (way.result.verdict for way in ways)
        verdict = next((v for v in verdicts if v != first.verdict), first.verdict)
        readings.append(replace(reading, varied=True, verdict=verdict, agrees=agrees))
        if reading.key != TOGETHER or len(findings) == len(first.findings):
            differ = [way for way in ways if way.result.verdict != first.verdict]
            findings += [_difference(first, reading, way) for way in differ]
    coverage = replace(first.coverage, readings=tuple(readings))
    return replace(first, findings=tuple(findings), coverage=coverage)


def _alone(first: CheckResult) -> CheckResult:
    """Return a result as if no other way had been tried."""
    findings = tuple(f for f in first.findings if f.meaning != MATTERS)
    readings = [r for r in first.coverage.readings if r.key != TOGETHER]
    undecided = tuple(replace(r, verdict="", agrees=True) for r in readings)
    coverage = replace(first.coverage, readings=undecided)
    return replace(first, findings=findings, coverage=coverage)


def _together(first: CheckResult) -> Iterator[ReadingTaken]:
    """Yield the reading that stands for all keys at once, where more than one was changed."""
    keys = list(dict.fromkeys(way.key for way in first.ways if way.key != TOGETHER))
    if len(keys) > 1:
        line = min(reading.line for reading in first.coverage.readings if reading.key in keys)
        yield ReadingTaken(TOGETHER, ", ".join(keys), True, line, 1)


def _agrees(first: CheckResult, other: CheckResult) -> bool:
    """Tell whether another way gives the same verdict, for nothing that the first has not found."""
    known = _failing(first)
    return other.verdict == first.verdict and all(
        key in known and depth <= known[key] + DEPTH_SLACK for key, depth in _failing(other).items()
    )


def _failing(result: CheckResult) -> dict[str, float]:
    """Return the likenesses of the findings that make a program fail, with their depths."""
    depths: dict[str, float] = {}
    for finding in (f for f in result.counted if f.effect == FAIL):
        key = likeness(finding)
        depths[key] = max(depths.get(key, 0.0), finding.depth or 0.0)
    return depths


def _difference(first: CheckResult, reading: ReadingTaken, way: OtherWay) -> Finding:
    """Return the finding that another way of reading gives another verdict, and why."""
    code, right = MEANINGS[MATTERS]
    what = f"{reading.key}: {reading.value} gives {_outcome(first)}, "
    what += f"{way.value} gives {_outcome(way.result)}"
    line = reading.line or None
    return Finding(code, f"{what}: {right}", meaning=MATTERS, file=first.program, line=line)


def _outcome(result: CheckResult) -> str:
    """Return a verdict, with what decides it."""
    if result.verdict == PASS:
        return "PASS"
    contact = result.first_contact
    if contact is not None and any(finding.is_contact for finding in result.counted):
        return f"a contact of {contact.pair[0]} and {contact.pair[1]} in line {contact.line}"
    weightiest = [f for f in result.counted if f.effect == result.verdict or f.effect == FAIL]
    return weightiest[0].code if weightiest else result.verdict.upper()

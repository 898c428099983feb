"""The JSON report, schema gcodesim.report/1: the source of every other format."""

from __future__ import annotations

import hashlib
from collections import Counter
from dataclasses import asdict
from typing import Any

from gcodesim.constants import SLACK_MM
from gcodesim.findings import Finding
from gcodesim.verdict import CheckResult

SCHEMA = "gcodesim.report/1"
PLACES = 12
"""Decimals of times and positions: a picosecond, far below any rounding of the machine."""


def report_dict(result: CheckResult) -> dict[str, Any]:
    """The report as JSON-ready values, keys in the order of the schema."""
    return {
        "schema": SCHEMA,
        "verdict": result.verdict,
        "program": result.program,
        "machine": result.machine,
        "verified_model": result.verified_model,
        "device": result.device,
        "method": result.method,
        "dialect": result.dialect,
        "sample_period_s": result.sample_period_s,
        "samples": result.samples,
        "duration_s": result.duration_s,
        "tool_times": [{"tool": tool, "time_s": time_s} for tool, time_s in result.tool_times],
        "blocks": result.blocks,
        "tolerance_mm": result.tolerance_mm,
        "slack_mm": SLACK_MM,
        "largest_step": asdict(result.largest_step) if result.largest_step else None,
        "first_contact": _first_contact(result),
        "contacts": [asdict(interval) for interval in result.contacts],
        "clearances": [asdict(distance) for distance in result.clearances],
        "findings": _findings(result.findings),
        "coverage": {
            key: [list(v) if isinstance(v, tuple) else v for v in value]
            if isinstance(value, tuple)
            else value
            for key, value in asdict(result.coverage).items()
        },
        "left_out": [asdict(item) for item in result.left_out],
        "work": result.work,
        "timing_s": {stage: round(seconds, 6) for stage, seconds in result.timing_s.items()},
    }


def _first_contact(result: CheckResult) -> dict[str, Any] | None:
    contact = result.first_contact
    if contact is None:
        return None
    values = asdict(contact)
    values["axes"] = {name: round(q, PLACES) for name, q in contact.axes.items()}
    return {
        key: list(value) if isinstance(value, tuple) else value for key, value in values.items()
    }


def _findings(findings: tuple[Finding, ...]) -> list[dict[str, Any]]:
    """Findings as values without their empty fields, each with its fingerprint."""
    seen: Counter[str] = Counter()
    rows = []
    for finding in findings:
        values = {k: v for k, v in asdict(finding).items() if v not in (None, "")}
        values["pair"] = list(finding.pair) if finding.pair else None
        key = fingerprint_key(finding)
        values["fingerprint"] = _fingerprint(key, seen[key])
        seen[key] += 1
        rows.append({k: v for k, v in values.items() if v is not None})
    return rows


def fingerprint_key(finding: Finding) -> str:
    """What makes a finding the same one after an edit: no line numbers, no floats."""
    pair = "-".join(finding.pair or ())
    return "\x1f".join([finding.file, finding.code, pair, str(finding.tool), finding.block.strip()])


def _fingerprint(key: str, ordinal: int) -> str:
    return hashlib.sha256(f"{key}\x1f{ordinal}".encode()).hexdigest()[:16]

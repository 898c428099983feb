"""The JSON report, schema gcodesim.report/1: the source of every other format."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import Any

from gcodesim.checking.verdict import CheckResult
from gcodesim.constants import SLACK_MM
from gcodesim.findings.fingerprints import fingerprints
from gcodesim.report.outcome import RunOutcome

SCHEMA = "gcodesim.report/1"
PLACES = 12
"""Decimals of times and positions: a picosecond, far below any rounding of the machine."""


def render(run: RunOutcome) -> str:
    """One object for one program, an array for several, whatever became of them."""
    reports = [report_dict(result) for result in run.results]
    one = len(reports) == 1 and not run.failures
    return json.dumps(reports[0] if one else reports, indent=2) + "\n"


def report_dict(result: CheckResult) -> dict[str, Any]:
    """The report as JSON-ready values, keys in the order of the schema."""
    rows = finding_rows(result)
    return {
        "schema": SCHEMA,
        "verdict": result.verdict,
        "fail_on": result.fail_on,
        "program": result.program,
        # Only where a file holds several, and they were asked for.
        **({"main_program": result.main_program} if result.main_program else {}),
        "machine": result.machine,
        "setup": result.setup,
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
        "findings": [row for row in rows if "ignored" not in row],
        "suppressed": [row for row in rows if "ignored" in row],
        "coverage": {
            key: [list(v) if isinstance(v, tuple) else v for v in value]
            if isinstance(value, tuple)
            else value
            for key, value in asdict(result.coverage).items()
            if value or key != "stocks"  # a setup without a stock has no such key
        },
        "left_out": [asdict(item) for item in result.left_out],
        "pictures": list(result.pictures),
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


def finding_rows(result: CheckResult) -> list[dict[str, Any]]:
    """Findings as values without their empty fields, each with its fingerprint."""
    marks = fingerprints(result.findings)
    rows = []
    for finding, fingerprint in zip(result.findings, marks, strict=True):
        values = dict(vars(finding), fingerprint=fingerprint)
        values["pair"] = list(finding.pair) if finding.pair else None
        values["parts"] = list(finding.parts) if finding.parts else None
        values["continues"] = finding.continues or None
        values["ignored"] = vars(finding.ignored) if finding.ignored else None
        rows.append({key: value for key, value in values.items() if value not in (None, "")})
    return rows

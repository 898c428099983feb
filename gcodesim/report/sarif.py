"""SARIF 2.1.0: one run, its rules from the table of codes, within the limits of GitHub."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from urllib.parse import quote

from gcodesim import __version__
from gcodesim.findings.codes import CODES
from gcodesim.findings.explain import explain
from gcodesim.findings.printing import printable
from gcodesim.report.outcome import RunOutcome
from gcodesim.report.rows import CountedFinding, repository_path, rows

SCHEMA = (
    "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json"
)
RESULTS = 25_000
"""GitHub refuses a run with more results; the weightiest are kept."""

RULES = {code: i for i, code in enumerate(CODES)}


def render(run: RunOutcome) -> str:
    """The log, JSON."""
    found = rows(run)
    log = {
        "$schema": SCHEMA,
        "version": "2.1.0",
        "runs": [
            {
                "tool": {"driver": _driver()},
                "columnKind": "unicodeCodePoints",
                "invocations": [_invocation(run, len(found))],
                "results": [_result(row) for row in found[:RESULTS]],
                "properties": {"verdicts": _verdicts(run)},
            }
        ],
    }
    return json.dumps(log) + "\n"


def uri(path: str) -> str:
    """A path as a reference relative to the repository; absolute where it lies outside."""
    if Path(path).is_absolute():
        return Path(path).as_uri()
    return quote(path, errors="surrogateescape")


def _driver() -> dict[str, Any]:
    return {
        "name": "gcodesim",
        "version": __version__,
        "semanticVersion": __version__,
        "rules": [_rule(code) for code in CODES],
    }


def _rule(code: str) -> dict[str, Any]:
    row, text = CODES[code], explain(code)
    return {
        "id": code,
        "shortDescription": {"text": row.title},
        "fullDescription": {"text": text.splitlines()[1].strip()},
        "help": {"text": text},
        "defaultConfiguration": {"level": row.severity},
    }


def _invocation(run: RunOutcome, count: int) -> dict[str, Any]:
    notifications = [_notification("error", each.message, each.program) for each in run.failures]
    if count > RESULTS:
        text = f"{count - RESULTS} more findings are left out: see the other reports"
        notifications.append(_notification("warning", text))
    return {"executionSuccessful": not run.failures, "toolExecutionNotifications": notifications}


def _notification(level: str, text: str, file: str = "") -> dict[str, Any]:
    place = {"locations": [_location(repository_path(file))]} if file else {}
    return {"level": level, "message": {"text": printable(text)}, **place}


def _result(row: CountedFinding) -> dict[str, Any]:
    finding = row.finding
    properties = {
        "machine": row.result.machine,
        "meaning": finding.meaning,
        "pair": finding.pair,
        "time_s": finding.time_s,
        "tool": finding.tool,
    }
    return {
        "ruleId": finding.code,
        "ruleIndex": RULES[finding.code],
        "level": finding.severity,
        "message": {"text": printable(finding.message)},
        "locations": [_location(row.path, _region(row))],
        "partialFingerprints": {"gcodesim/v1": row.fingerprint},
        "properties": {k: v for k, v in properties.items() if v not in (None, "")},
    }


def _region(row: CountedFinding) -> dict[str, Any]:
    region: dict[str, Any] = {"startLine": row.line}
    if row.finding.column:
        region["startColumn"] = row.finding.column
    if row.finding.block:
        region["snippet"] = {"text": printable(row.finding.block)}
    return region


def _location(path: str, region: dict[str, Any] | None = None) -> dict[str, Any]:
    place: dict[str, Any] = {"artifactLocation": {"uri": uri(path)}}
    if region:
        place["region"] = region
    return {"physicalLocation": place}


def _verdicts(run: RunOutcome) -> Sequence[dict[str, str]]:
    return [{"program": r.title, "machine": r.machine, "verdict": r.verdict} for r in run.results]

"""What `machine lint` prints: its findings as lines, or as JSON (schema gcodesim.lint/1)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from gcodesim.findings.codes import Finding
from gcodesim.findings.printing import printable
from gcodesim.report.text import SEVERITY_COLORS

SCHEMA = "gcodesim.lint/1"


def lint_lines(name: str, findings: Sequence[Finding]) -> list[str]:
    """A line with the counts, then one line per finding, what weighs most first."""
    counts = Counter(finding.severity for finding in findings)
    summary = ", ".join(f"{counts[s]} {s}{'' if counts[s] == 1 else 's'}" for s in SEVERITY_COLORS)
    return [f"{name}: {summary}", *(_line(finding) for finding in _by_weight(findings))]


def lint_dict(name: str, findings: Sequence[Finding]) -> dict[str, Any]:
    """The findings as JSON-ready values without their empty fields."""
    rows = [
        {key: value for key, value in asdict(finding).items() if value not in (None, "")}
        for finding in _by_weight(findings)
    ]
    return {"schema": SCHEMA, "machine": name, "findings": rows}


def _by_weight(findings: Sequence[Finding]) -> list[Finding]:
    weights = list(SEVERITY_COLORS)
    return sorted(findings, key=lambda finding: weights.index(finding.severity))


def _line(finding: Finding) -> str:
    place = ":".join(str(part) for part in (finding.file, finding.line) if part)
    text = f"{place}: {finding.message}" if place else finding.message
    return printable(f"  {finding.severity} {finding.code} {text}")

"""The code quality report of GitLab: a list of what its merge request widget shows."""

from __future__ import annotations

import hashlib
import json
from typing import Any

from gcodesim.findings.printing import printable
from gcodesim.report.outcome import Failure, RunOutcome
from gcodesim.report.rows import (
    CountedFinding,
    ignored_rows,
    ignored_title,
    repository_path,
    rows,
    title,
)

SEVERITIES = {"error": "critical", "warning": "major", "note": "info"}


def render(run: RunOutcome) -> str:
    """The findings as JSON; those that are ignored come last, for information."""
    issues = [_unread(failure) for failure in run.failures]
    issues += [_issue(row) for row in (*rows(run), *ignored_rows(run))]
    return json.dumps(issues, indent=2) + "\n"


def _issue(row: CountedFinding) -> dict[str, Any]:
    severity = "blocker" if row.finding.is_contact else SEVERITIES[row.finding.severity]
    text = ignored_title(row) if row.finding.ignored else title(row)
    severity = "info" if row.finding.ignored else severity
    # The same block may collide on two machines: GitLab shows one issue per fingerprint.
    result = row.result
    # Of several programs in a file too, and every other fingerprint stays as it was.
    program = (result.main_program,) if result.main_program else ()
    job = (row.fingerprint, result.machine, result.setup, *program)
    return _entry(text, row.finding.code, job, severity, row.path, row.line)


def _unread(failure: Failure) -> dict[str, Any]:
    job = ("unread", failure.program)
    path = repository_path(failure.program)
    return _entry(failure.message, "unreadable", job, "blocker", path, 1)


def _entry(
    description: str, name: str, job: tuple[str, ...], severity: str, path: str, line: int
) -> dict[str, Any]:
    mark = hashlib.sha256("\x1f".join(job).encode(errors="replace")).hexdigest()[:32]
    return {
        "description": printable(description),
        "check_name": name,
        "fingerprint": mark,
        "severity": severity,
        "location": {"path": path, "lines": {"begin": line}},
    }

"""Findings as CI systems want them: what counts, weightiest first, paths from the repository."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from gcodesim.checking.verdict import PASS, CheckResult, effect_at
from gcodesim.findings.codes import FAIL, INCONCLUSIVE, NOTED, Finding, Ignored
from gcodesim.findings.fingerprints import fingerprints
from gcodesim.report.outcome import RunOutcome

ROOTS = ("GITHUB_WORKSPACE", "CI_PROJECT_DIR")
"""Where GitHub and GitLab say that the repository lies."""

EFFECTS = (FAIL, INCONCLUSIVE, NOTED)
SEVERITIES = ("error", "warning", "note")


@dataclass(frozen=True)
class CountedFinding:
    """A finding that counts, or one that is ignored.

    Attributes:
        result: of the program it belongs to.
        path: its file, counted from the root of the repository, with slashes.
        fingerprint: as in the JSON report.
    """

    result: CheckResult
    finding: Finding
    path: str
    fingerprint: str

    @property
    def line(self) -> int:
        """Line of the finding; the first one where the whole file is meant."""
        return self.finding.line or 1


def rows(run: RunOutcome) -> list[CountedFinding]:
    """The findings that count, contacts and failures first, otherwise in the order of the run."""
    return sorted((row for result in run.results for row in _rows_of(result)), key=_weight)


def ignored_rows(run: RunOutcome) -> list[CountedFinding]:
    """The findings that somebody asked to ignore, contacts first."""
    found = []
    for result in run.results:
        both = zip(result.findings, fingerprints(result.findings), strict=True)
        found += [_row(result, finding, mark) for finding, mark in both if finding.ignored]
    return sorted(found, key=_weight)


def ignored_title(row: CountedFinding) -> str:
    """What was ignored, by whom, and why."""
    mark = row.finding.ignored or Ignored("")
    why = f"{mark.by}: {mark.reason}" if mark.reason else mark.by
    return f"ignored ({why}): {title(row)}"


def title(row: CountedFinding) -> str:
    """Message with the code before it, and after it the machine, and the program of several."""
    where = f"{row.result.main_program} on {row.result.machine}".removeprefix(" on ")
    return f"{row.finding.code} {row.finding.message} ({where})"


def repository_path(file: str, environment: Mapping[str, str] = os.environ) -> str:
    """A file counted from the root of the repository; as it stands where it lies outside."""
    root = next((environment[name] for name in ROOTS if environment.get(name)), os.getcwd())
    try:
        return Path(os.path.abspath(file)).relative_to(os.path.abspath(root)).as_posix()
    except ValueError:
        return Path(file).as_posix()


def _rows_of(result: CheckResult) -> list[CountedFinding]:
    both = zip(result.findings, fingerprints(result.findings), strict=True)
    found = [_row(result, finding, mark) for finding, mark in both if not finding.ignored]
    decided = any(effect_at(row.finding, result.fail_on) != NOTED for row in found)
    if result.verdict != PASS and not decided:
        nothing = Finding("GC901", "nothing was checked: no motion, or no pair of bodies")
        found.append(_row(result, nothing, fingerprints([nothing])[0]))
    return found


def _row(result: CheckResult, finding: Finding, fingerprint: str) -> CountedFinding:
    return CountedFinding(
        result, finding, repository_path(finding.file or result.program), fingerprint
    )


def _weight(row: CountedFinding) -> tuple[bool, int, int]:
    finding = row.finding
    effect = effect_at(finding, row.result.fail_on)
    return not finding.is_contact, EFFECTS.index(effect), SEVERITIES.index(finding.severity)

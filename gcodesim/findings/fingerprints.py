"""Fingerprints: what makes a finding the same one after the program was edited."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Iterable

from gcodesim.findings.codes import Finding


def fingerprints(findings: Iterable[Finding]) -> list[str]:
    """A fingerprint for each finding; equal ones are told apart by their order."""
    seen: Counter[str] = Counter()
    marks = []
    for finding in findings:
        key = likeness(finding)
        marks.append(fingerprint(key, seen[key]))
        seen[key] += 1
    return marks


def fingerprint(key: str, before: int) -> str:
    """The fingerprint of a finding of some likeness, with so many like it before it."""
    return hashlib.sha256(f"{key}\x1f{before}".encode(errors="replace")).hexdigest()[:16]


def likeness(finding: Finding) -> str:
    """What is kept by an edit elsewhere: no line numbers, no floats."""
    pair = "-".join(finding.pair or ())
    # Bodies of one part without a name of its own are told apart by their names alone.
    pair += "" if finding.parts in (None, finding.pair) else f" {'-'.join(finding.parts)}"
    return "\x1f".join([finding.file, finding.code, pair, str(finding.tool), finding.block.strip()])

"""Fingerprints: what makes a finding the same one after the program was edited."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Iterable

from gcodesim.findings import Finding


def fingerprints(findings: Iterable[Finding]) -> list[str]:
    """A fingerprint for each finding; equal ones are told apart by their order."""
    seen: Counter[str] = Counter()
    marks = []
    for finding in findings:
        key = _key(finding)
        marks.append(
            hashlib.sha256(f"{key}\x1f{seen[key]}".encode(errors="replace")).hexdigest()[:16]
        )
        seen[key] += 1
    return marks


def _key(finding: Finding) -> str:
    """What is kept by an edit elsewhere: no line numbers, no floats."""
    pair = "-".join(finding.pair or ())
    return "\x1f".join([finding.file, finding.code, pair, str(finding.tool), finding.block.strip()])

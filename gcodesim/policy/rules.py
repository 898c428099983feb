"""A rule: findings of a code, or of a family of codes, that are not to count, and why."""

from __future__ import annotations

import re
from dataclasses import dataclass

from gcodesim.errors import UsageError
from gcodesim.findings.codes import CODES, Finding, Ignored

PREFIX = re.compile(r"GC\d{1,3}")
NO_REASON = "a contact is never ignored without a reason"
NOT_CHECKED = "it says that something was not checked, and no reason makes up for that"


@dataclass(frozen=True)
class Rule:
    """Ignore the findings whose code begins with `prefix`, down to a depth if one is given."""

    prefix: str
    mark: Ignored
    depth: float | None = None

    def takes(self, finding: Finding) -> bool:
        """Whether the rule speaks of this finding and has the power to ignore it."""
        if not finding.code.startswith(self.prefix):
            return False
        return not refusal(finding, self.mark.reason, self.depth)


def refusal(finding: Finding, reason: str, depth: float | None = None) -> str:
    """Why a finding counts whatever anybody says; empty where it can be ignored.

    Args:
        finding: what was found.
        reason: why it is to be ignored.
        depth: down to which depth it is accepted [mm, deg]; None: any.
    """
    if finding.leaves_unchecked:
        return NOT_CHECKED
    if finding.is_contact and not reason:
        return NO_REASON
    if depth is not None and finding.is_contact and finding.depth is None:
        return f"how deep it is is not known, and {depth:.4g} mm were accepted"
    if depth is not None and finding.depth is not None and finding.depth > depth:
        unit = "deg" if finding.code == "GC302" else "mm"
        return f"it is {finding.depth:.4g} {unit} now, and {depth:.4g} {unit} were accepted"
    return "a wrong wish to ignore cannot be ignored" if finding.code == "GC601" else ""


def parse_prefix(text: str, option: str) -> str:
    """A code or its beginning, ``GC201`` or ``GC2``.

    Raises:
        UsageError: no code begins so.
    """
    prefix = text.strip().upper()
    if not PREFIX.fullmatch(prefix) or not any(code.startswith(prefix) for code in CODES):
        raise UsageError(f"{option} {text!r}: no code begins so; right is GC201, or GC2")
    return prefix


def parse_rule(text: str, option: str) -> Rule:
    """A rule as an option gives it, ``CODE`` or ``CODE=REASON``.

    Raises:
        UsageError: no code begins so, contacts without a reason, or nothing that can be ignored.
    """
    code, _, reason = text.partition("=")
    prefix, reason = parse_prefix(code, option), reason.strip()
    if prefix.startswith("GC1") and not reason:
        raise UsageError(f"{option} {text}: {NO_REASON}; write '{prefix}=why'")
    if all(refusal(Finding(code, ""), "any") for code in CODES if code.startswith(prefix)):
        raise UsageError(f"{option} {text}: {prefix} cannot be ignored: {NOT_CHECKED}")
    return Rule(prefix, Ignored(f"{option} {prefix}", reason))

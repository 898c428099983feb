"""The policy: which findings count, and what ignoring the others does to a result."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

from gcodesim.checking.request import CheckRequest
from gcodesim.checking.variation import MATTERS, compared
from gcodesim.checking.verdict import CheckResult, effect_at
from gcodesim.findings.codes import CLEARANCES, FAIL, NOTED, Finding, Ignored
from gcodesim.policy.baseline import Baseline, Entry
from gcodesim.policy.comments import Comment, comments_in
from gcodesim.policy.rules import Rule, parse_prefix, parse_rule, refusal

SAME_WITHOUT = Ignored("what differs", "it is ignored")
NOT_SELECTED = Ignored("--select")


@dataclass(frozen=True)
class Policy:
    """What a user asks for.

    Ignoring speaks of what was found, never of what was not looked at: a finding that says that
    something was not checked always counts (gcodesim.policy.rules).

    Attributes:
        fail_on: one of verdict.LEVELS.
        select: beginnings of codes; of what may be ignored only these count, all if empty.
        ignore: rules of the command line or the settings.
        baseline: accepted findings.
    """

    fail_on: str = "error"
    select: tuple[str, ...] = ()
    ignore: tuple[Rule, ...] = ()
    baseline: Baseline | None = None

    def apply(self, result: CheckResult, text: str, *, stop_all: bool) -> CheckResult:
        """The result with every ignored finding marked, and with remarks about what was ignored.

        Args:
            result: as the check gave it.
            text: the program, for its comments.
            stop_all: the check looked on after the first contact.
        """
        judged = self._judged(result, text, stop_all)
        # What is ignored in one way of reading is ignored in the others: they are judged alike.
        ways = (replace(w, result=self._judged(w.result, text, stop_all)) for w in result.ways)
        judged = compared(replace(judged, ways=tuple(ways)))
        findings = [*_told_once(judged.findings), *_settled(result, judged)]
        return replace(judged, findings=tuple(findings), ways=())

    def _judged(self, result: CheckResult, text: str, stop_all: bool) -> CheckResult:
        """The result with every block of every contact by itself."""
        comments = list(comments_in(text))
        entries = self._entries(result)
        both = list(zip(result.findings, entries, strict=True))
        findings = [self._marked(f, e) for f, e in both]
        remarks = list(_wrong(comments, result.program))
        remarks += [remark for f, e in both for remark in _refused(f, e, self.fail_on)]
        remarks += self._old_entries(both, result.program)
        if looked_at_all(result, stop_all):
            remarks += [*_unused(comments, result), *self._unused_entries(result)]
        gaps = [] if stop_all else [gap for f in findings if (gap := self._gap_after(f))]
        file = result.program
        remarks += [Finding("GC901", gap, "stopped_at_ignored", file=file) for gap in gaps]
        # A wrong comment on a block with several findings is wrong once.
        remarks = list(dict.fromkeys(remarks))
        coverage = result.coverage
        if any(f.ignored and f.is_contact for f in findings):
            gap = "clearances in the rest of the move in which an ignored contact ends"
            coverage = replace(coverage, uncertified=(*coverage.uncertified, gap))
        findings += remarks
        return replace(result, findings=tuple(findings), coverage=coverage, fail_on=self.fail_on)

    def wanted(self, result: CheckResult, text: str) -> list[Finding]:
        """Findings that belong in a baseline: all that count, except what can never be ignored."""
        judged = replace(self, baseline=None)._judged(result, text, stop_all=True)
        both = zip(result.findings, judged.findings, strict=False)
        return [f for f, seen in both if not seen.ignored and not refusal(f, "any")]

    def _entries(self, result: CheckResult) -> Sequence[Entry | None]:
        if self.baseline is None:
            return [None] * len(result.findings)
        return self.baseline.entries_of(result)

    def _marked(self, finding: Finding, entry: Entry | None) -> Finding:
        mark = next(self._marks(finding, entry), None)
        return replace(finding, ignored=mark) if mark else finding

    def _marks(self, finding: Finding, entry: Entry | None) -> Iterator[Ignored]:
        """Yield every reason for which the finding does not count."""
        rules = [*_rules_of(finding), *self.ignore]
        yield from (rule.mark for rule in rules if rule.takes(finding))
        if entry and self.baseline and not refusal(finding, entry.reason, entry.limit):
            yield Ignored(self.baseline.path, entry.reason)
        # A contact is never left unselected: that would be ignoring it without a reason.
        if self.select and not refusal(finding, "") and not finding.code.startswith(self.select):
            yield NOT_SELECTED

    def _gap_after(self, finding: Finding) -> str:
        """What was not looked at after an ignored finding; empty where that cannot matter.

        A wish for every place, by an option or in the settings, speaks of what follows too.
        """
        if finding.ignored and finding.is_contact:
            return "the check ended at an ignored contact: --stop all looks at what follows"
        everywhere = (NOT_SELECTED, *(rule.mark for rule in self.ignore))
        here = finding.ignored and finding.ignored not in everywhere
        if here and finding.code in CLEARANCES and effect_at(finding, self.fail_on) == FAIL:
            pair = "-".join(finding.pair or ())
            return (
                f"only the first place where {pair} is too near is reported: --stop all reports all"
            )
        return ""

    def _old_entries(
        self, both: Sequence[tuple[Finding, Entry | None]], file: str
    ) -> Iterator[Finding]:
        old = sum(e is not None and e.depth is None and f.depth is not None for f, e in both)
        if old and self.baseline:
            text = f"{self.baseline.path} accepts {old} finding{'s' if old > 1 else ''} at any "
            text += "depth: it is old; --stop all --update-baseline writes the depths into it"
            yield Finding("GC430", text, "baseline_old", file=file)

    def _unused_entries(self, result: CheckResult) -> Iterator[Finding]:
        for entry in self.baseline.unused(result) if self.baseline else ():
            text = f"an entry of the baseline matches nothing: {entry.code} {entry.message}"
            yield Finding("GC602", text, "baseline_unused", file=result.program)


def policy_of(
    asked: CheckRequest,
    baseline: Baseline | None,
    label: Callable[[str], str] = "--{}".format,
) -> Policy:
    """The policy that a user asks for.

    Args:
        asked: with codes and rules as they are written.
        baseline: as its file holds it.
        label: what to call an option in a message.

    Raises:
        UsageError: a code or rule is wrong.
    """
    return Policy(
        fail_on=asked.fail_on,
        select=tuple(parse_prefix(text, label("select")) for text in asked.select),
        ignore=tuple(parse_rule(text, label("ignore")) for text in asked.ignore),
        baseline=baseline,
    )


def looked_at_all(result: CheckResult, stop_all: bool) -> bool:
    """Whether a finding that is not there is gone: nothing ended the check before it."""
    ends = any(f.is_contact and not stop_all for f in result.findings)
    return not ends and not any(f.leaves_unchecked for f in result.findings)


def _rules_of(finding: Finding) -> list[Rule]:
    """What the comment in the finding's own block ignores."""
    return [rule for comment in comments_in(finding.block) for rule in comment.rules]


def _wrong(comments: Sequence[Comment], file: str) -> Iterator[Finding]:
    for comment in comments:
        if comment.wrong:
            text = f"comment for gcodesim: {comment.wrong}"
            yield Finding("GC601", text, "ignore_unreadable", file=file, line=comment.line)


def _unused(comments: Sequence[Comment], result: CheckResult) -> Iterator[Finding]:
    file = result.program
    ways = (result, *(way.result for way in result.ways))
    found = {(f.line, f.code) for way in ways for f in way.findings if f.file == file}
    for comment in comments:
        for rule in comment.rules:
            if not any(line == comment.line and c.startswith(rule.prefix) for line, c in found):
                text = f"this comment ignores {rule.prefix}, but the block has no such finding"
                yield Finding("GC602", text, "ignore_unused", file=file, line=comment.line)


def _refused(finding: Finding, entry: Entry | None, fail_on: str) -> Iterator[Finding]:
    """Yield what is wrong with a comment or an entry that speaks of a finding that counts."""
    wishes = [
        ("this comment", rule.mark.reason, rule.depth)
        for rule in _rules_of(finding)
        if finding.code.startswith(rule.prefix)
    ]
    wishes += [("the baseline", entry.reason, entry.limit)] if entry else []
    for who, reason, depth in wishes:
        # What is too deep counts again; it is an error only where it makes the program fail.
        noted = effect_at(finding, fail_on) == NOTED and not refusal(finding, reason)
        if not noted and (why := refusal(finding, reason, depth)):
            text = f"{finding.code} still counts, though {who} ignores it: {why}"
            yield Finding("GC601", text, "ignore_refused", file=finding.file, line=finding.line)


def _settled(result: CheckResult, judged: CheckResult) -> Iterator[Finding]:
    """Yield the differences between ways of reading that are gone with what was ignored."""
    if result.ways and not any(f.meaning == MATTERS for f in judged.findings):
        for finding in result.findings:
            if finding.meaning == MATTERS:
                yield replace(finding, ignored=SAME_WITHOUT)


def _told_once(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """The findings with those joined that go on in other blocks and count alike."""
    told: list[Finding] = []
    for finding in findings:
        if finding.continues and told and told[-1].ignored == finding.ignored:
            depths = [f.depth for f in (told[-1], finding) if f.depth is not None]
            told[-1] = replace(told[-1], depth=max(depths, default=None))
        else:
            told.append(replace(finding, continues=False))
    return tuple(told)

"""JUnit XML: a test case per program, as Jenkins (xunit's junit-10.xsd) and GitLab read it.

FAIL is a failure. INCONCLUSIVE and a program that cannot be read are errors, not skipped tests:
CI systems take a skipped test for a good one.
"""

from __future__ import annotations

from collections import Counter
from xml.etree import ElementTree

from gcodesim.checking.verdict import PASS, CheckResult
from gcodesim.findings.codes import FAIL
from gcodesim.findings.printing import printable
from gcodesim.report.outcome import RunOutcome
from gcodesim.report.rows import repository_path, rows, title
from gcodesim.report.text import report_lines

BODY_FINDINGS = 100
"""Findings listed in the body of a test case; all are in the other formats."""


def render(run: RunOutcome) -> str:
    """The document, with an XML declaration."""
    cases = _named(run)
    seconds = sum(sum(result.timing_s.values()) for result in run.results)
    verdicts = Counter(result.verdict for result in run.results)
    suite = ElementTree.Element(
        "testsuite",
        name="gcodesim",
        tests=str(len(run.results) + len(run.failures)),
        failures=str(verdicts[FAIL]),
        errors=str(len(run.results) + len(run.failures) - verdicts[FAIL] - verdicts[PASS]),
        skipped="0",
        time=f"{seconds:.3f}",
    )
    suite.extend(_case(result, name) for result, name in zip(run.results, cases, strict=True))
    for failure in run.failures:
        case = ElementTree.SubElement(
            suite, "testcase", classname="gcodesim", name=printable(failure.program), time="0.000"
        )
        error = ElementTree.SubElement(case, "error", type="unreadable")
        error.set("message", printable(failure.message))
        error.text = printable(failure.message)
    suites = ElementTree.Element("testsuites", name="gcodesim")
    suites.append(suite)
    ElementTree.indent(suites)
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        + ElementTree.tostring(suites, encoding="unicode")
        + "\n"
    )


def _named(run: RunOutcome) -> list[str]:
    """Names of the test cases: of two with the same name GitLab drops one."""
    seen: Counter[tuple[str, str]] = Counter()
    names = []
    for result in run.results:
        name = result.title + (f" ({result.setup})" if result.setup else "")
        seen[result.machine, name] += 1
        again = seen[result.machine, name]
        names.append(printable(name if again == 1 else f"{name} #{again}"))
    return names


def _case(result: CheckResult, name: str) -> ElementTree.Element:
    case = ElementTree.Element(
        "testcase",
        classname=f"gcodesim.{printable(result.machine)}",
        name=name,
        time=f"{sum(result.timing_s.values()):.3f}",
    )
    text = "\n".join(line.plain for line in report_lines(result, BODY_FINDINGS)) + "\n"
    if result.verdict == PASS:
        ElementTree.SubElement(case, "system-out").text = text + _attachments(result)
        return case
    body = ElementTree.SubElement(case, "failure" if result.verdict == FAIL else "error")
    body.set("type", result.verdict)
    body.set("message", printable(title(rows(RunOutcome((result,)))[0])))
    body.text = text
    if result.pictures:
        ElementTree.SubElement(case, "system-out").text = _attachments(result)
    return case


def _attachments(result: CheckResult) -> str:
    """Pictures as GitLab reads them: a path from the root of the repository, one per line."""
    paths = map(repository_path, result.pictures)
    return "".join(f"[[ATTACHMENT|{printable(path)}]]\n" for path in paths)

"""Report formats: as their standards have them, and telling the gate what it must know."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import jsonschema
import junitparser
import pytest
from format_schemas import GITHUB_SARIF, GITLAB, assert_junit, sarif_schema
from reporting import FAILED, LIMIT, NEAR, NOTE, PASSED, RUN, TOUCH, UNCLEAR, UNKNOWN, finding

from gcodesim.findings.codes import CODES, Ignored
from gcodesim.findings.fingerprints import fingerprints
from gcodesim.report import github, gitlab, jsonl, junit, sarif
from gcodesim.report.formats import RENDER
from gcodesim.report.outcome import FORMATS, RunOutcome

HIDDEN = replace(PASSED, findings=(replace(TOUCH, ignored=Ignored("comment", "dummy")), NOTE))


@pytest.fixture(autouse=True)
def root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The root of a repository, the same whether GitHub, GitLab or nobody runs the tests."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("GITHUB_WORKSPACE", str(tmp_path))
    return tmp_path


def sarif_run(run: RunOutcome) -> dict:
    log = json.loads(sarif.render(run))
    for schema in (sarif_schema(), GITHUB_SARIF):
        jsonschema.Draft7Validator(schema).validate(log)
    return log["runs"][0]


def test_every_format_has_a_writer_and_an_answer_to_an_empty_run() -> None:
    assert tuple(RENDER) == FORMATS
    for name, render in RENDER.items():
        assert isinstance(render(RunOutcome(())), str), name


def test_junit_is_valid_and_an_undecided_program_is_an_error() -> None:
    text = junit.render(RUN)
    assert_junit(ElementTree.fromstring(text))
    (suite,) = ElementTree.fromstring(text)
    # A reader that others wrote counts the same.
    (read,) = junitparser.JUnitXml.fromstring(text.encode())
    assert (read.tests, read.failures, read.errors, read.skipped) == (4, 1, 2, 0)
    assert [suite.get(k) for k in ("tests", "failures", "errors", "skipped")] == list("4120")
    outcomes = [[child.tag for child in case] for case in suite]
    assert outcomes == [["system-out"], ["failure"], ["error"], ["error"]]
    failure = suite[1][0]
    assert failure.get("message") == "GC102 GC102: 5 < 6 & 100% (table_tilt)"
    assert failure.text.startswith("FAIL  parts/b a.nc on table_tilt")
    assert "error GC102 parts/part.nc:6:4: GC102: 5 < 6 & 100%\n" in failure.text
    assert suite[2][0].get("type") == "inconclusive"
    assert suite[3].get("name") == "missing.nc"


def test_junit_names_are_unique_and_pictures_are_attached(root: Path) -> None:
    seen = replace(FAILED, pictures=(str(root / "out/contact.png"), "near.png"))
    (suite,) = ElementTree.fromstring(
        junit.render(RunOutcome((seen, FAILED, replace(FAILED, setup="s"))))
    )
    names = [case.get("name") for case in suite]
    assert names == ["parts/b a.nc", "parts/b a.nc #2", "parts/b a.nc (s)"]
    assert suite[0].findtext("system-out") == (
        "[[ATTACHMENT|out/contact.png]]\n[[ATTACHMENT|near.png]]\n"
    )


def test_a_body_of_junit_stays_readable() -> None:
    many = replace(FAILED, findings=tuple(finding("GC301", line) for line in range(1, 151)))
    (suite,) = ElementTree.fromstring(junit.render(RunOutcome((many,))))
    assert suite[0][0].text.count("error GC301") == junit.BODY_FINDINGS
    assert "  50 more findings: see the other reports\n" in suite[0][0].text


def test_the_published_schema_of_sarif_refuses_what_is_misspelt() -> None:
    log = json.loads(sarif.render(RUN))
    log["runs"][0]["results"][0]["partialFingerprint"] = {}
    with pytest.raises(jsonschema.ValidationError, match="partialFingerprint"):
        jsonschema.Draft7Validator(sarif_schema()).validate(log)


def test_sarif_is_valid_and_says_where(root: Path) -> None:
    run = sarif_run(RUN)
    driver = run["tool"]["driver"]
    assert [rule["id"] for rule in driver["rules"]] == list(CODES)
    assert all(rule["help"]["text"].startswith(rule["id"]) for rule in driver["rules"])
    codes = [result["ruleId"] for result in run["results"]]
    assert codes == ["GC102", "GC402", "GC201", "GC430"]
    for result in run["results"]:
        assert driver["rules"][result["ruleIndex"]]["id"] == result["ruleId"]
    touch = run["results"][0]
    assert touch["partialFingerprints"] == {"gcodesim/v1": fingerprints([TOUCH])[0]}
    assert touch["level"] == "error"
    place = touch["locations"][0]["physicalLocation"]
    assert place["artifactLocation"] == {"uri": "parts/part.nc"}
    assert (place["region"]["startLine"], place["region"]["startColumn"]) == (6, 4)
    (invocation,) = run["invocations"]
    assert not invocation["executionSuccessful"]
    assert [n["level"] for n in invocation["toolExecutionNotifications"]] == ["error"]
    verdicts = [entry["verdict"] for entry in run["properties"]["verdicts"]]
    assert verdicts == ["pass", "fail", "inconclusive"]


@pytest.mark.parametrize(
    ("file", "uri"),
    [
        ("parts/b a.nc", "parts/b%20a.nc"),
        ("./parts/../x#1.nc", "x%231.nc"),
        ("<stdin>", "%3Cstdin%3E"),
        ("a\udce9.nc", "a%E9.nc"),
        ("/elsewhere/x.nc", "file:///elsewhere/x.nc"),
    ],
)
def test_sarif_paths_are_relative_references(file: str, uri: str) -> None:
    run = sarif_run(RunOutcome((replace(FAILED, findings=(replace(TOUCH, file=file),)),)))
    (result,) = run["results"]
    location = result["locations"][0]["physicalLocation"]["artifactLocation"]
    assert location["uri"] == uri


def test_paths_are_counted_from_the_repository_not_from_here(
    root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (root / "sub").mkdir()
    monkeypatch.chdir(root / "sub")
    assert "file=sub/parts/part.nc," in github.render(RUN)


def test_sarif_keeps_the_weightiest_within_the_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sarif, "RESULTS", 2)
    run = sarif_run(RUN)
    assert [result["ruleId"] for result in run["results"]] == ["GC102", "GC402"]
    notes = run["invocations"][0]["toolExecutionNotifications"]
    assert notes[-1]["message"]["text"].startswith("2 more findings are left out")


def test_gitlab_issues_are_valid_and_told_apart() -> None:
    elsewhere = replace(FAILED, machine="head_tilt")
    issues = json.loads(gitlab.render(replace(RUN, results=(*RUN.results, elsewhere))))
    for issue in issues:
        jsonschema.Draft7Validator(GITLAB).validate(issue)
        assert not issue["location"]["path"].startswith(("/", "./"))
        assert issue["location"]["lines"]["begin"] >= 1
    assert len({issue["fingerprint"] for issue in issues}) == len(issues) == 8
    assert [i["severity"] for i in issues[:4]] == ["blocker", "blocker", "blocker", "critical"]


def test_github_annotates_the_ten_weightiest_and_sums_up_all() -> None:
    many = tuple(finding("GC301", line) for line in range(20, 60))
    run = replace(RUN, results=(replace(FAILED, findings=(*many, NEAR, TOUCH)),))
    lines = github.render(run).splitlines()
    assert len(lines) == github.ANNOTATIONS
    assert lines[0] == "::error file=missing.nc,line=1::missing.nc: cannot be read"
    assert lines[1] == (
        "::error file=parts/part.nc,line=6,col=4::GC102 GC102: 5 < 6 & 100%25 (table_tilt)"
    )
    summary = github.summary(run)
    assert summary.count("GC301") == 2 * len(many)
    assert "| FAIL | parts/b a.nc | table\\_tilt | 42 |\n" in summary
    assert "5 &lt; 6 &amp; 100%" in summary


def test_github_escapes_what_would_end_a_property() -> None:
    odd = replace(TOUCH, file="a,b:c%.nc", message="two\nlines")
    line = github.render(RunOutcome((replace(FAILED, findings=(odd,)),)))
    assert line.startswith("::error file=a%2Cb%3Ac%25.nc,line=6,col=4::GC102 two")
    assert line.count("\n") == 1


def test_the_step_summary_stays_below_its_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(github, "SUMMARY_BYTES", 1000)
    many = tuple(finding("GC301", line) for line in range(20, 60))
    summary = github.summary(RunOutcome((replace(FAILED, findings=many),)))
    assert len(summary.encode()) <= 1000
    shown = summary.count("- **GC301")
    assert shown > 0
    assert f"\n{40 - shown} more findings" in summary


def test_json_lines_are_canonical() -> None:
    other = replace(FAILED, device="cuda:0", timing_s={"search": 9.0}, work={"poses": 3})
    assert jsonl.render(RunOutcome((FAILED,))) == jsonl.render(RunOutcome((other,)))
    lines = jsonl.render(RUN).splitlines()
    objects = [json.loads(line) for line in lines]
    for line, value in zip(lines, objects, strict=True):
        assert line == json.dumps(value, sort_keys=True, separators=(",", ":"))
    kinds = [value["type"] for value in objects]
    assert kinds == ["program", *["finding"] * 3, "program", "finding", "program", "failure"]
    assert (objects[3]["program"], objects[3]["code"]) == ("parts/b a.nc", "GC102")


def test_what_is_ignored_is_told_with_its_reason_and_is_no_result() -> None:
    run = RunOutcome((HIDDEN,))
    assert [result["ruleId"] for result in sarif_run(run)["results"]] == ["GC430"]
    assert [issue["severity"] for issue in json.loads(gitlab.render(run))] == ["info", "info"]
    notice = github.render(run).splitlines()[1]
    assert notice.startswith("::notice file=parts/part.nc,line=6::ignored (comment: dummy): GC102")
    assert "ignored (comment: dummy): GC102" in github.summary(run)
    report = json.loads(RENDER["json"](run))
    (hidden,) = report["suppressed"]
    assert hidden["ignored"] == {"by": "comment", "reason": "dummy"}
    assert hidden["fingerprint"] == fingerprints([TOUCH])[0]
    assert [row["code"] for row in report["findings"]] == ["GC430"]
    text = RENDER["text"](run)
    assert text.startswith(
        "PASS  parts/part.nc on table_tilt (unverified model, 1 contact ignored)\n"
    )
    assert "  ignored GC102 parts/part.nc:6: GC102: 5 < 6 & 100% (comment: dummy)\n" in text


def test_an_undecided_program_without_a_finding_is_seen() -> None:
    """Nothing moved, so nothing was checked: every format must say more than silence."""
    still = RunOutcome((replace(UNCLEAR, findings=(NOTE,), samples=0),))
    assert sarif_run(still)["results"][0]["ruleId"] == "GC901"
    assert github.render(still).startswith("::error file=parts/unclear.nc,line=1::GC901 nothing")
    assert json.loads(gitlab.render(still))[0]["severity"] == "critical"


def test_order_is_by_what_decides() -> None:
    mixed = replace(FAILED, findings=(NOTE, NEAR, UNKNOWN, LIMIT, TOUCH))
    codes = re.findall(r"::(GC\d+) ", github.render(RunOutcome((mixed,))))
    assert codes == ["GC102", "GC301", "GC402", "GC201", "GC430"]


def test_github_tells_what_was_ignored_after_ten_other_findings() -> None:
    hidden = [replace(TOUCH, line=n, ignored=Ignored("comment", "dummy")) for n in (1, 2, 3)]
    many = replace(FAILED, findings=(*[replace(NEAR, line=n) for n in range(20)], *hidden))
    lines = github.render(RunOutcome((many,))).splitlines()
    assert len(lines) == github.ANNOTATIONS
    assert lines[-1].startswith("::notice")
    assert lines[-1].endswith("and 2 more findings ignored")

"""Reports read back: every format comes out as it does from the result itself."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache

import pytest
from report.checked import SAMPLES
from reporting import FAILED, LIMIT, NEAR, NOTE, PASSED, RUN, TOUCH

from gcodesim.checking.flow import check_program
from gcodesim.checking.options import Options
from gcodesim.checking.verdict import CheckResult
from gcodesim.errors import UsageError
from gcodesim.findings.codes import Ignored
from gcodesim.machine.loading import load_machine
from gcodesim.policy.policy import Policy
from gcodesim.policy.rules import parse_rule
from gcodesim.report import github
from gcodesim.report.formats import RENDER
from gcodesim.report.json_report import report_dict
from gcodesim.report.outcome import Failure, RunOutcome
from gcodesim.report.reading import outcome_of, result_of


@cache
def checked(sample: str, *ignored: str) -> CheckResult:
    """A sample with everything a report can tell."""
    text = (SAMPLES / f"{sample}.nc").read_text()
    options = Options(device="cpu", period_ps=10**9, minimum=True, stop_all=True)
    policy = Policy(ignore=tuple(parse_rule(rule, "--ignore") for rule in ignored))
    result = check_program(text, f"{sample}.nc", load_machine("table_tilt"), options)
    result = policy.apply(result, text, stop_all=True)
    # A report has microseconds, and a picture is worth no time here.
    return replace(result, setup="s.yaml", pictures=("a.png",), timing_s={"search": 0.25})


REASONED = Ignored("--ignore GC301", "known")
ALIKE = replace(FAILED, findings=tuple(
    replace(LIMIT, line=line, ignored=REASONED if line % 2 else None) for line in (9, 10, 11, 12)
))  # fmt: skip
"""Findings that only their order tells apart, and every second does not count."""

HIDDEN = replace(PASSED, findings=(replace(TOUCH, ignored=Ignored("comment", "dummy")), NOTE, NEAR))


def as_read(result: CheckResult) -> CheckResult:
    return result_of(json.loads(json.dumps(report_dict(result))))


def assert_same(result: CheckResult) -> None:
    there, back = RunOutcome((result,)), RunOutcome((as_read(result),))
    for name, render in RENDER.items():
        assert render(back) == render(there), name
    assert github.summary(back) == github.summary(there)


@pytest.mark.parametrize(
    ("sample", "ignored", "verdict"),
    [
        ("clear", (), "pass"),
        ("tilt_into_holder", (), "fail"),
        ("tilt_into_holder", ("GC102=dummy",), "pass"),
        ("unknown_code", (), "inconclusive"),
        ("overtravel", ("GC301",), "pass"),
        ("no_feed", (), "fail"),
    ],
)
def test_a_check_comes_back_as_it_was(sample: str, ignored: tuple[str, ...], verdict: str) -> None:
    result = checked(sample, *ignored)
    assert result.verdict == verdict
    assert_same(result)


@pytest.mark.parametrize("result", [*RUN.results, HIDDEN, ALIKE], ids=lambda r: r.program)
def test_what_is_ignored_keeps_the_fingerprints_of_the_others(result: CheckResult) -> None:
    assert_same(result)


def label(program: str) -> dict[str, str]:
    return {"program": program, "machine": "m", "setup": "", "key": "k"}


def test_a_run_has_all_that_was_to_be_done_in_the_order_of_the_names() -> None:
    records = [
        label("b.nc") | {"report": report_dict(replace(FAILED, program="b.nc"))},
        label("a.nc") | {"report": report_dict(replace(PASSED, program="a.nc"))},
        label("gone.nc") | {"error": "gone.nc: cannot be read"},
    ]
    run = outcome_of(records, [label("c.nc")], ["2/3"])
    assert [result.program for result in run.results] == ["a.nc", "b.nc"]
    assert run.failures == (
        Failure("gone.nc", "gone.nc: cannot be read"),
        Failure("c.nc", "not checked"),
        Failure("shard 2/3", "not there"),
    )


def test_a_record_of_another_version_is_named() -> None:
    report = report_dict(PASSED)
    del report["blocks"]
    with pytest.raises(UsageError, match=r"a\.nc: its record is not of this version"):
        outcome_of([label("a.nc") | {"report": report}])

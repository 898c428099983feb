"""Reports: the JSON schema, fingerprints that survive an edit, and the text a person reads."""

from __future__ import annotations

import io
import json
from dataclasses import replace

import pytest
import reporting
from rich.cells import cell_len
from rich.console import Console

from gcodesim.checking.verdict import CONTRACT, CheckResult, Coverage, FirstContact
from gcodesim.findings.codes import Finding
from gcodesim.findings.left_out import LeftOut
from gcodesim.report.json_report import report_dict
from gcodesim.report.text import print_report

PASSED = replace(
    reporting.PASSED,
    program="part.nc",
    method="exhaustive",
    coverage=Coverage(pairs=(("cutter", "C"), ("Z", "A"))),
    work={"poses": 284002, "triangle_tests": 1},
)
TOUCH = Finding(
    "GC102",
    "holder of cutter touches table of C here",
    "contact",
    file="part.nc",
    line=6,
    block="N40 G1 Z-30 F1000",
    time_s=12.4,
    pair=("cutter", "C"),
    tool=7,
)
SPINDLE = Finding(
    "GC430",
    "feed move with the spindle off",
    "spindle_off_feed",
    file="part.nc",
    line=6,
    column=5,
    block="N40 G1 Z-30 F1000",
)
FAILED = replace(
    PASSED,
    first_contact=FirstContact(
        sample=124000,
        time_s=12.4,
        pair=("cutter", "C"),
        parts=("holder", "table"),
        triangles=(12, 340),
        point_mm=(3.0322265625, -0.0, -40.0),
        line=6,
        block="N40 G1 Z-30 F1000",
        axes={"Y": 0.0, "X": 1.5, "A": -30.0, "C": -0.0, "Z": -360.0},
        tool=7,
    ),
    findings=(SPINDLE, TOUCH),
)
UNCLEAR = replace(
    PASSED,
    findings=(
        SPINDLE,
        Finding("GC402", "G68: not followed", file="part.nc", line=8, column=4, block="  G68 R30"),
    ),
    coverage=replace(PASSED.coverage, unsupported=("G68 line 8",), ignored=("word E (3 times)",)),
)


BODIES = (("cutter", 0.5, 3), ("C", 1.5, 4))


def text(result: CheckResult) -> str:
    stream = io.StringIO()
    print_report(result, Console(file=stream, color_system=None, highlight=False, soft_wrap=True))
    return stream.getvalue()


def fingerprints(*findings: Finding) -> list[str]:
    return [
        row["fingerprint"] for row in report_dict(replace(PASSED, findings=findings))["findings"]
    ]


def test_text_of_a_pass_says_that_only_samples_were_looked_at() -> None:
    assert text(PASSED) == (
        "PASS  part.nc on table_tilt (at samples only, unverified model)\n"
        "  motion: 6 blocks, 14.200 s, 142001 samples (every 0.1 ms and at block ends)\n"
        "  checked: cutter-C, Z-A; exhaustive on cpu\n"
        "  not checked, between samples: a touch that begins and ends there is not seen\n"
        f"  {CONTRACT}\n"
    )


def test_what_was_proved_without_a_look_is_told_as_checked_and_what_has_no_margin_is_not() -> None:
    parts = [LeftOut(f"triangles of {b}", "", 2.0, mm, 0, n) for b, mm, n in BODIES]
    still = LeftOut("axis C", "stands at 0 all the time", 0.0, 0.0, 0)
    pair = LeftOut("Z-A", "reach envelopes never meet", 0.001, 15.556, 9)
    line = (
        "  proved apart without search: Z-A (15.56 mm to spare), "
        "7 triangles of cutter, C (0.5 mm to spare)\n"
    )
    assert line in text(replace(PASSED, left_out=(pair, *parts, still)))
    assert text(replace(PASSED, left_out=(still,))) == text(PASSED)


def test_text_of_a_fail_begins_with_the_first_contact() -> None:
    assert text(FAILED) == (
        "FAIL  part.nc on table_tilt (unverified model)\n"
        "  error GC102 part.nc:6: holder of cutter touches table of C here\n"
        "    N40 G1 Z-30 F1000\n"
        "    when   12.400000 s, sample 124000, tool 7\n"
        "    axes   X 1.5000  Y 0.0000  Z -360.0000  A -30.0000  C 0.0000  (machine coordinates)\n"
        "    point  X 3.0322  Y 0.0000  Z -40.0000"
        "  (world frame, triangle 12 of holder, triangle 340 of table)\n"
        "  note GC430 part.nc:6:5: feed move with the spindle off\n"
        "    N40 G1 Z-30 F1000\n"
        "        ^\n"
        "  motion: 6 blocks, 14.200 s, 142001 samples (every 0.1 ms and at block ends)\n"
        "  checked: cutter-C, Z-A up to the first contact; exhaustive on cpu\n"
        "  not checked, between samples: a touch that begins and ends there is not seen\n"
        f"  {CONTRACT}\n"
    )


def test_text_of_an_inconclusive_check_begins_with_the_reason() -> None:
    assert text(UNCLEAR) == (
        "INCONCLUSIVE  part.nc on table_tilt (unverified model)\n"
        "  error GC402 part.nc:8:4: G68: not followed\n"
        "    G68 R30\n"
        "     ^\n"
        "  note GC430 part.nc:6:5: feed move with the spindle off\n"
        "    N40 G1 Z-30 F1000\n"
        "        ^\n"
        "  motion: 6 blocks, 14.200 s, 142001 samples (every 0.1 ms and at block ends)\n"
        "  checked: cutter-C, Z-A; exhaustive on cpu\n"
        "  not followed: G68 line 8\n"
        "  ignored: word E (3 times)\n"
        "  not checked, between samples: a touch that begins and ends there is not seen\n"
        f"  {CONTRACT}\n"
    )


@pytest.mark.parametrize("nothing", [{"samples": 0}, {"coverage": Coverage()}])
def test_nothing_checked_is_never_a_pass(nothing: dict[str, object]) -> None:
    report = text(replace(PASSED, **nothing))
    assert report.startswith("INCONCLUSIVE")
    assert "\n  checked: nothing\n" in report


@pytest.mark.parametrize(
    "block",
    [
        "G1 X10 @",
        "    G1 X10 @",
        "\tG1\tX10 @",
        "(\N{CJK UNIFIED IDEOGRAPH-65E5}) @",
        "G1 \x1b[31m\x00 @",
        "G1" + " X10" * 500 + " @",
        "@" + " X10" * 500,
        "G1" + " X10" * 500 + "@" + " X10" * 500,
        "@",
    ],
)
def test_the_caret_stands_under_its_column(block: str) -> None:
    finding = replace(UNCLEAR.findings[1], block=block, column=block.index("@") + 1)
    lines = text(replace(PASSED, findings=(finding,))).splitlines()
    shown, caret = lines[2], lines[3]
    assert caret.strip() == "^"
    assert cell_len(caret) == cell_len(shown[: shown.index("@") + 1])
    assert len(shown) < 140
    assert shown.isprintable()


def test_cycle_time_is_given_per_tool() -> None:
    timed = replace(PASSED, tool_times=((None, 1.2), (7, 13.0)))
    assert "  tools: as started 1.200 s, T7 13.000 s\n" in text(timed)
    times = [{"tool": None, "time_s": 1.2}, {"tool": 7, "time_s": 13.0}]
    assert report_dict(timed)["tool_times"] == times
    assert "tools:" not in text(replace(PASSED, tool_times=((7, 14.2),)))


def test_json_has_the_keys_of_the_schema() -> None:
    report = json.loads(json.dumps(report_dict(FAILED)))
    assert list(report) == [
        *("schema", "verdict", "fail_on", "program", "machine", "setup", "verified_model"),
        *("device", "method"),
        *("dialect", "sample_period_s", "samples", "duration_s", "tool_times", "blocks"),
        *("tolerance_mm", "slack_mm", "largest_step", "first_contact", "contacts", "clearances"),
        *("findings", "suppressed", "coverage", "left_out", "pictures", "work", "timing_s"),
    ]
    assert report["schema"] == "gcodesim.report/1"
    assert report["verdict"] == "fail"
    assert report["first_contact"] == {
        "sample": 124000,
        "time_s": 12.4,
        "pair": ["cutter", "C"],
        "parts": ["holder", "table"],
        "triangles": [12, 340],
        "point_mm": [3.0322265625, 0.0, -40.0],
        "line": 6,
        "block": "N40 G1 Z-30 F1000",
        "axes": {"Y": 0.0, "X": 1.5, "A": -30.0, "C": 0.0, "Z": -360.0},
        "tool": 7,
        "between_samples": False,
        "distance_mm": 0.0,
    }
    assert report["coverage"] == {
        "pairs": [["cutter", "C"], ["Z", "A"]],
        "between_samples": False,
        "unsupported": [],
        "ignored": [],
        "uncertified": [],
        "unchecked_by_rule": [],
        "readings": [],
        "off_path": [],
        "not_run": [],
    }
    touch = report["findings"][1]
    assert len(touch.pop("fingerprint")) == 16
    assert touch == {
        "code": "GC102",
        "message": "holder of cutter touches table of C here",
        "meaning": "contact",
        "file": "part.nc",
        "line": 6,
        "block": "N40 G1 Z-30 F1000",
        "time_s": 12.4,
        "pair": ["cutter", "C"],
        "tool": 7,
        "severity": "error",
    }
    assert report_dict(PASSED)["first_contact"] is None


def test_a_line_inserted_above_keeps_the_fingerprint() -> None:
    moved = replace(TOUCH, line=7, time_s=12.5, column=3, message="said otherwise")
    indented = replace(TOUCH, block=f"  {TOUCH.block} ")
    assert fingerprints(TOUCH) == fingerprints(moved) == fingerprints(indented)


def test_what_differs_has_a_fingerprint_of_its_own() -> None:
    others = [
        replace(TOUCH, file="other.nc"),
        replace(TOUCH, code="GC103"),
        replace(TOUCH, pair=("cutter", "A")),
        replace(TOUCH, tool=8),
        replace(TOUCH, block="N40 G1 Z-31 F1000"),
    ]
    alone = {fingerprints(finding)[0] for finding in (TOUCH, *others)}
    assert len(alone) == 6


def test_two_equal_findings_are_told_apart_by_their_order() -> None:
    first, second = fingerprints(TOUCH, replace(TOUCH, line=9))
    assert first != second
    assert fingerprints(SPINDLE, TOUCH, TOUCH)[1:] == [first, second]

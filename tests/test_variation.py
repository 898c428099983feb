"""A program is checked in every way in which a control may read it; PASS and FAIL hold for all."""

from dataclasses import replace

import pytest

import gcodesim
from gcodesim.checking.flow import check_program
from gcodesim.machine.loading import load_machine
from gcodesim.policy.policy import Policy

HEAD = "G21 G90 G17 G54 G0\nT1 M6\n"
KNOWN = {
    "no_point": "units",
    "rapids": "linear",
    "g28_no_axes": "all",
    "length_after_reference": "kept",
    "length_change": "next_move",
}
OPTIONS = gcodesim.Options(device="cpu")


def check(text, **readings):
    machine = load_machine("table_tilt")
    return check_program(
        f"{HEAD}{text}\nM30\n", "part.nc", machine.with_readings(**{**KNOWN, **readings}), OPTIONS
    )


def taken(result):
    return {reading.key: (reading.value, reading.verdict) for reading in result.coverage.readings}


def test_a_program_that_reaches_no_open_reading_is_checked_once(monkeypatch):
    calls = []
    from gcodesim.checking import flow

    once = flow.check_once
    monkeypatch.setattr(flow, "check_once", lambda *given: calls.append(1) or once(*given))
    result = check("G0 X10\nY10", rapids="both", length_change="both")
    assert (result.verdict, taken(result), len(calls)) == ("pass", {}, 1)


def test_ways_that_agree_leave_the_verdict_and_are_named():
    result = check("G0 X10 Y20\nG0 X0 Y0", rapids="both")
    assert result.verdict == "pass"
    assert taken(result) == {"rapids": ("linear", "pass")}
    (reading,) = result.coverage.readings
    assert (reading.line, reading.count, reading.varied) == (3, 2, True)


def test_one_way_that_hits_makes_it_inconclusive_and_names_the_key():
    dive = "G43 H1 Z250\nG0 X0 Y0\nG0 Z40\nG49\nM5"
    assert check(dive, length_change="next_move").verdict == "pass"
    assert check(dive, length_change="at_once").verdict == "fail"
    result = check(dive, length_change="both")
    assert result.verdict == "inconclusive"
    assert taken(result) == {"length_change": ("next_move", "fail")}
    (finding,) = [f for f in result.findings if f.code == "GC427"]
    assert finding.message.startswith(
        "length_change: next_move gives PASS, at_once gives a contact"
    )
    assert (finding.line, finding.meaning) == (6, "reading_matters")


def test_a_contact_in_every_way_is_a_fail_with_the_contact_of_the_first():
    crash = "G43 H1 Z250\nG49\nG0 X0 Y0\nG43 H1 Z-50"
    result = check(crash, length_change="both")
    first = check(crash, length_change="next_move")
    assert (result.verdict, first.verdict) == ("fail", "fail")
    assert result.first_contact == first.first_contact


def test_a_first_way_that_hits_alone_is_no_fail():
    # With the length in, Z500 lies above the travel; without it, 160 mm lower.
    text = "G43 H1 Z250\nG91 G28 Z0\nG90 G0 Z500"
    kept = check(text, length_after_reference="kept")
    cancelled = check(text, length_after_reference="cancelled")
    result = check(text, length_after_reference="both")
    assert (kept.verdict, cancelled.verdict) == ("fail", "pass")
    assert result.verdict == "inconclusive"


def test_g28_without_axes_moves_all_or_none():
    moved = check("G0 X50\nG28", g28_no_axes="all")
    stayed = check("G0 X50\nG28", g28_no_axes="none")
    assert moved.samples > stayed.samples
    both = check("G0 X50\nG28", g28_no_axes="both")
    assert taken(both) == {"g28_no_axes": ("all", "pass")}


def test_a_length_that_a_reference_point_cancelled_is_not_moved_again():
    text = "G43 H1 Z250\nG91 G28 Z0\nG49\nM5"
    result = check(text, length_change="both")
    assert taken(result) == {}


def test_several_keys_are_changed_alone_and_together():
    text = "G43 H1 Z250\nG0 X10 Y20\nG28"
    keys = {"rapids": "both", "g28_no_axes": "both"}
    result = check(text, **keys)
    assert set(taken(result)) == {"rapids", "g28_no_axes", "together"}


def test_incremental_words_do_not_depend_on_the_length():
    result = check("G43 H1 Z250\nG91 G28 Z0\nG91 G0 Z-10", length_after_reference="both")
    assert taken(result) == {}


@pytest.mark.parametrize("way", ["next_move", "at_once"])
def test_a_key_that_is_given_is_not_varied(way):
    result = check("G43 H1\nG0 Z250", length_change=way)
    assert result.coverage.readings == ()
    assert replace(result.coverage, readings=()) == result.coverage


IGNORED = """(gcodesim: ignore GC102 reason=tried on the machine)"""


def test_what_is_ignored_in_one_way_is_ignored_in_the_others():
    text = f"G0 X10 Y10\nG53 G0 Z-480 {IGNORED}\nG53 Z0"
    machine = load_machine("table_tilt").with_readings(**{**KNOWN, "rapids": "both"})
    options = replace(OPTIONS, stop_all=True)
    source = f"{HEAD}{text}\nM30\n"
    result = check_program(source, "part.nc", machine, options)
    assert (result.verdict, taken(result)["rapids"]) == ("fail", ("linear", "fail"))
    assert Policy().apply(result, source, stop_all=True).verdict == "pass"


def judged(text, stop_all=True, **readings):
    machine = load_machine("table_tilt").with_readings(**{**KNOWN, **readings})
    source = f"{HEAD}{text}\nM30\n"
    options = replace(OPTIONS, stop_all=stop_all)
    result = check_program(source, "part.nc", machine, options)
    return result, Policy().apply(result, source, stop_all=stop_all)


DIVE = "G43 H1 Z250\nG0 X0 Y0\nG0 Z40\nG49 (gcodesim: ignore GC102 {depth}reason=tried)\nM5"


def test_a_contact_of_another_way_that_is_ignored_makes_no_difference():
    raw, result = judged(DIVE.format(depth=""), length_change="both")
    assert (raw.verdict, result.verdict) == ("inconclusive", "pass")
    assert taken(result) == {"length_change": ("next_move", "pass")}
    (told,) = result.ignored
    assert told.code == "GC427"
    assert not any(f.code == "GC602" for f in result.findings)


def test_a_contact_of_another_way_counts_below_its_depth_and_where_the_check_stops_at_it():
    _, deep = judged(DIVE.format(depth="depth=0.01 "), length_change="both")
    _, stopped = judged(DIVE.format(depth=""), stop_all=False, length_change="both")
    assert (deep.verdict, stopped.verdict) == ("inconclusive", "inconclusive")
    assert "GC427" in [f.code for f in deep.counted]


def test_a_first_way_that_is_ignored_leaves_the_verdict_of_the_others():
    text = "G43 H1 Z250\nG91 G28 Z0\nG90 G0 Z500 (gcodesim: ignore GC301 reason=x)"
    raw, result = judged(text, length_after_reference="both")
    assert (raw.verdict, result.verdict) == ("inconclusive", "pass")


def test_a_finding_of_another_way_counts_at_the_level_that_is_asked_for():
    text = f"{HEAD}G43 H1 Z250\nG0 X0 Y0\nG0 Z170\nG49\nM5\nM30\n"
    machine = load_machine("table_tilt").with_readings(**{**KNOWN, "length_change": "both"})
    result = check_program(text, "part.nc", machine, replace(OPTIONS, clearance=20.0))
    verdicts = [
        Policy(fail_on=level).apply(result, text, stop_all=False).verdict
        for level in ("error", "warning")
    ]
    assert verdicts == ["pass", "inconclusive"]

"""The section `control` of machine files: its keys are the fields of Readings, once."""

from dataclasses import fields, replace

import pytest

from gcodesim.errors import ModelError
from gcodesim.machine.control_data import control_for
from gcodesim.machine.describe import schema_json
from gcodesim.machine.loading import load_machine
from gcodesim.nc.control.readings import ROWS, Readings

GIVEN = {
    "no_point": "increment",
    "increment_mm": 0.01,
    "increment_inch": 0.001,
    "increment_deg": 0.01,
    "m_per_block": "one",
    "m6_order": "last",
    "program_unit": "inch",
    "cycle_return": "G99",
    "rapids": "dogleg",
    "g28_no_axes": "none",
    "length_after_reference": "cancelled",
    "length_change": "at_once",
    "length_at_tool_change": "new_tool",
    "g28_rotary": "unwind",
    "arc_radii": "spiral",
    "cycle_no_q": "none",
    "unused_word": "alarm",
    "dwell_p": "s",
    "g80": "motion",
    "g87": "centre",
    "spindle_at_stop": "turns",
    "peck_backoff": 0.0,
    "spindle_seconds": 1.5,
    "bore_shift": "-Y",
    "r_and_ijk": "error",
    "arc_no_centre": "line",
    "arc_r_no_end": "none",
    "arc_normal_word": "ignored",
    "h_in_any_block": False,
    "length_without_h": "spindle",
    "same_group": "open",
    "g53_incremental": "stop",
    "g10_l2_p0": "active",
    "cycle_drills": "xy",
    "cycle_rotary": "error",
    "cycle_repeats": "K",
    "cycle_q": "signed",
    "cycle_upward": "alarm",
    "peck_words": "ijk",
    "g87_under_g99": "initial",
    "tapping_spindle": "starts",
    "same_letter": "last",
    "comma_corners": False,
    "feed_forgotten": "always",
    "h0": "spindle",
    "g10_in_g91": "replaces",
    "g10_l20": "solved",
    "g10_tool_r": "ignored",
    "m98_p": "number",
    "m99": "end",
    "macros": "o_words",
    "tape": False,
    "polar_words": True,
    "slash_deletes": False,
    "dollar_lines": True,
    "start_motion": "G1",
    "tcp_frame": "work",
    "tcp_rotary_feed": 3600.0,
    "orientation": "great_circle",
    "m_codes": {46.0: "none", 60.5: "stop"},
    "g_codes": {500.0: "clamp"},
    "ignore_words": ("E", "Q"),
    "programs": {"9810": "probe", "L6": "tool_change"},
}
"""Key -> a value that no row of fanuc has; others have tests of their own."""

KEYS = [*GIVEN, "arc", "tool_change", "library"]


def in_control(key, value):
    written = {True: "true", False: "false"}.get(value) if isinstance(value, bool) else value
    written = list(value) if isinstance(value, tuple) else written
    return f"control: {{{key}: {written}}}".replace("'", "")


def test_every_reading_but_the_dialect_is_a_key():
    assert {field.name for field in fields(Readings)} == {*KEYS, "dialect"}
    assert schema_json()["$defs"]["ReadingsKeys"]["properties"].keys() == {*KEYS}


@pytest.mark.parametrize("key", GIVEN)
def test_a_key_replaces_one_reading_of_the_dialect(changed, key):
    path = changed("name: tiny", f"name: tiny\n{in_control(key, GIVEN[key])}")
    assert getattr(ROWS["fanuc"], key) != GIVEN[key]
    machine = load_machine(path)
    assert machine.readings == replace(ROWS["fanuc"], **{key: GIVEN[key]})
    # It holds under a dialect given elsewhere too.
    readings = control_for(machine, "haas", None, False).readings
    assert readings == replace(ROWS["haas"], **{key: GIVEN[key]})


def test_a_tolerance_of_arcs_leaves_the_others_alone(changed):
    path = changed("name: tiny", "name: tiny\ncontrol:\n  arc: {tol_mm: 2e-2}")
    arc = load_machine(path).readings.arc
    assert arc == replace(ROWS["fanuc"].arc, tol_mm=0.02)


@pytest.mark.parametrize("key", KEYS)
def test_a_key_beside_control_is_told_where_it_stands(changed, key):
    with pytest.raises(ModelError) as caught:
        load_machine(changed("name: tiny", f"name: tiny\n{key}: 1"))
    assert (caught.value.line, caught.value.key) == (2, key)
    assert f"it stands in `control`: write `control: {{{key}: ...}}`" in str(caught.value)


def test_r_and_ijk_is_no_tolerance_any_more(changed):
    with pytest.raises(ModelError) as caught:
        load_machine(changed("name: tiny", "name: tiny\ncontrol:\n  arc: {r_and_ijk: error}"))
    assert (caught.value.line, caught.value.key) == (3, "control.arc.r_and_ijk")
    assert "write `control: {r_and_ijk: ...}`" in str(caught.value)


@pytest.mark.parametrize(
    ("given", "key", "text"),
    [
        ("no_point: inch", "no_point", "'units', 'increment', 'both' or 'open'"),
        ("increment_mm: 0", "increment_mm", "greater than 0"),
        ("dialect: haas", "dialect", "unknown key"),
        ("peck_back: 1", "peck_back", "did you mean 'peck_backoff'"),
        ("rapids: bent", "rapids", "'linear', 'dogleg' or 'both', not 'bent'"),
        ("peck_backoff: -1", "peck_backoff", "greater than or equal to 0"),
        ("tcp_rotary_feed: 0", "tcp_rotary_feed", "greater than 0"),
        ("comma_corners: 1", "comma_corners", "valid boolean"),
        ("arc: {tol_mm: true}", "arc.tol_mm", "valid number, not True"),
        ("arc: {tol_rel: 1e10}", "arc.tol_rel", "less than or equal to 1000000000"),
        ("m_codes: {'46': none}", "m_codes.46", "valid number"),
        ("m_codes: {46: off}", "m_codes.46", "'none', 'clamp', 'unclamp' or 'stop'"),
        ("ignore_words: [EE]", "ignore_words.0", "match pattern"),
    ],
)
def test_what_no_control_can_do_is_refused(changed, given, key, text):
    with pytest.raises(ModelError, match=text) as caught:
        load_machine(changed("name: tiny", f"name: tiny\ncontrol:\n  {given}"))
    assert (caught.value.line, caught.value.key) == (3, f"control.{key}")


def test_the_manual_tells_what_a_key_left_out_is():
    keys = schema_json()["$defs"]["ReadingsKeys"]["properties"]
    assert keys["dwell_p"]["description"].endswith(
        "left out: fanuc ms, haas point, linuxcnc s, grbl s"
    )
    assert keys["peck_backoff"]["description"].endswith("left out: 0.254")
    assert "left out" not in keys["tcp_rotary_feed"]["description"]

"""Answers of the frozen programs of the field that are right: given by hand, not by the check.

`test_frozen_cases` repeats the transcripts; here stands what a renewed transcript may say. The
programs are small forms of what people told of their machines, and of what real controls run.
"""

from __future__ import annotations

import json
from typing import NamedTuple

import pytest
from frozen.transcripts import TRANSCRIPTS


class Right(NamedTuple):
    """A right answer.

    Attributes:
        verdict: of the check; where more than one is right, with | between.
        code: of a finding that says why; empty where nothing has to be said.
        block: how the block of that finding begins.
        axes: where the axes stand at the first contact [mm, deg].
    """

    verdict: str
    code: str = ""
    block: str = ""
    axes: dict[str, float] | None = None


PASS, UNKNOWN, FAIL = "pass", "inconclusive", "fail"
OPEN = f"{PASS}|{UNKNOWN}"

FIELD = {
    # Rapids, references and tool length.
    "g01_dogleg_default": Right(UNKNOWN, "GC427"),
    "g01_dogleg_stated": Right(FAIL, "GC104", "N130", {"X": 4.8, "Y": 0.0}),
    "g02_g28_same_block_g91": Right(PASS),
    "g03_g49_dive": Right(FAIL, "GC102", "N140", {"Z": -360.0}),
    "g04_wrong_h": Right(FAIL, "GC102", "N120", {"Z": -360.0}),
    "g05_g43_without_h": Right(f"{FAIL}|{UNKNOWN}", "GC102", "N120"),
    "g06_tilt_before_retract": Right(FAIL, "GC102", "N140"),
    "g07_plate_hits_cradle": Right(FAIL, "GC108", "N120"),
    "g08_unwind_long_way": Right(FAIL, "GC104", "N60", {"C": 182.8}),
    "g08_unwind_short_way": Right(PASS),
    "g09_tcp_wrong_length": Right(FAIL, "GC104", "N70"),
    "g10_tcp_overtravel_inside": Right(FAIL, "GC301", "N120"),
    "g12_cycle_left_on": Right(FAIL, "GC104", "N130", {"X": 60.0, "Z": -340.0}),
    "g13_g28_no_axes": Right(FAIL, "GC104", "N130"),
    "g14_g91_left_by_sub": Right(FAIL, "GC104", "N70"),
    "g15_tiny_arc_full_circle": Right(FAIL, "GC104", "N130"),
    "g16_c_swing_no_post": Right(PASS),
    "g16_c_swing_under_tcp": Right(FAIL, "GC104", "N130"),
    "g17_spindle_nose_post": Right(FAIL, "GC108", "N130", {"X": -11.0}),
    "g19_rotate_while_clamped": Right(PASS),
    "g20_dwo_then_rapid_xyz": Right(FAIL, "GC102", "N130"),
    "g21_rapid_through_part": Right(FAIL, "GC105", "N130", {"X": -56.0}),
    "g21_rapid_through_stock": Right(FAIL, "GC105", "N130", {"X": -56.0}),
    "g23_stale_length_after_change": Right(FAIL, "GC102", "N160", {"Z": -360.0}),
    "g25_h_other_than_t_for_all": Right(PASS, "GC431", "N110"),
    "g26_g44_for_g43": Right(FAIL, "GC301", "N110"),
    "g27_rapid_xyz_diagonal_after_change": Right(FAIL, "GC104", "N100"),
    # Text, codes of single controls, offsets, macros.
    "l02_nested_comment": Right(FAIL, "GC401", "(POCKET"),
    "l03_bom_crlf_latin1": Right(PASS),
    "l03_bom_utf8": Right(PASS),
    "l04_leader_before_percent": Right(PASS),
    "l06_smoothing_axes_zero": Right(PASS),
    "l06_smoothing_hides": Right(FAIL, "GC104", "N150"),
    "l07_g10_l2_g91": Right(FAIL, "GC104", "N140", {"Z": -350.0}),
    "l07_g10_l2_g91_safe": Right(PASS),
    "l08_g53_under_g91": Right(f"{FAIL}|{UNKNOWN}", "GC104", "N140"),
    "l09_probe_macro": Right(UNKNOWN, "GC412", "N120"),
    "l10_dprnt": Right(PASS),
    "l11_slash_after_n": Right(PASS),
    "l13_m98_repeat_digits": Right(FAIL, "GC104", "N10", {"X": 24.0}),
    "l15_haas_m_codes": Right(PASS),
    "l16_cycle_upwards": Right(OPEN),
    "l17_sign_minus_zero": Right(PASS),
    "l18_haas_g13": Right(UNKNOWN, "GC402", "N130"),
    "l20_g28_wound_c": Right(PASS),
    "l21_g52_stays": Right(FAIL, "GC104", "N160", {"X": 21.0}),
    "l22_g92_mid_program": Right(FAIL, "GC104", "N150", {"X": 46.0}),
    "l23_inch_program": Right(FAIL, "GC104", "N70", {"X": 4.0}),
    "l24_comment_semicolon_eob": Right(PASS),
    "l25_g43_4_then_g28": Right(PASS),
    "l26_macro_alarm": Right(FAIL, "GC407", "N140"),
    "l27_t0_unload": Right(PASS),
    "l28_m01_m00": Right(PASS),
    "l30_g30_p3": Right(UNKNOWN, "GC409", "N120"),
    "l31_second_main_in_file": Right(PASS, "GC430", "O7057"),
    "l33_g28_under_g68_2": Right(PASS),
    "l34_dwell_forms": Right(PASS),
    "l35_k0_in_g17_arc": Right(PASS),
    "l36_g41_d_on_fanuc": Right(UNKNOWN, "GC422", "N130"),
    "l37_spindle_off_feed": Right(FAIL, "GC105", "N130"),
    "l38_rotary_axis_named_b": Right(UNKNOWN, "GC402", "N100"),
    "l39_safe_line_g50_g67": Right(FAIL, "GC102", "N60"),
    "l41_g43_1_tool_axis": Right(UNKNOWN, "GC402", "N110"),
    "l42_haas_peck_ijk": Right(OPEN),
    "l44_g28_rollover_turns": Right(PASS),
    "l45_haas_g28_cancels_length": Right(UNKNOWN, "GC427"),
}

PROGRAMS = {
    # K of an arc in G17 is not read, or stands in the way; nothing else is wrong with the block.
    "fanuc-arc-k-in-g17": Right(OPEN),
    "fanuc-arc-no-centre": Right(UNKNOWN, "GC427"),
    "fanuc-dprnt": Right(PASS),
    "fanuc-g54-p": Right(UNKNOWN, "GC409", "G54"),
    # After H0 the last block is a position of the spindle's face.
    "fanuc-h-d-any-block": Right(FAIL, "GC102", "G0", {"Z": -360.0}),
    # Of the next ones only the text matters: nothing in them moves.
    "fanuc-leader": Right(UNKNOWN, "GC430"),
    "fanuc-off-switches": Right(UNKNOWN, "GC430"),
    "fanuc-percent-only-at-end": Right(UNKNOWN, "GC430"),
    "fanuc-macro-in-control": Right(UNKNOWN, "GC412", "G65"),
    # It moves as G0, without a tool length.
    "fanuc-no-motion-code": Right(FAIL, "GC102", "Z-10.", {"Z": -360.0}),
    "fanuc-offset-register": Right(UNKNOWN, "GC409", "G55"),
    "fanuc-rotary-in-cycle": Right(PASS),
    "fanuc-same-group": Right(FAIL, "GC102", "G91", {"Z": -360.0}),
    "haas-peck-ijk": Right(PASS),
    "lcnc-hal-names": Right(UNKNOWN, "GC402", "F#<_hal["),
    "lcnc-m70-m72": Right(PASS),
    "lcnc-m99-restart": Right(UNKNOWN, "GC425"),
    "lcnc-oword-expr": Right(PASS),
    "lcnc-predefined-names": Right(PASS),
    "lcnc-value-before-call": Right(PASS),
    "other-language-heidenhain": Right(UNKNOWN, "GC403"),
    "speed-s-word": Right(PASS),
}

ANSWERS = {f"field/{name}": right for name, right in FIELD.items()} | {
    f"programs/{name}": right for name, right in PROGRAMS.items()
}


@pytest.mark.parametrize("name", ANSWERS)
def test_a_frozen_answer_is_right(name: str) -> None:
    right = ANSWERS[name]
    frozen = json.loads((TRANSCRIPTS / f"{name}.json").read_text(encoding="utf-8"))
    report = frozen["steps"][-1]["report"]
    assert report["verdict"] in right.verdict.split("|")
    if right.code:
        blocks = [f.get("block", "") for f in report["findings"] if f["code"] == right.code]
        assert any(block.startswith(right.block) for block in blocks)
    elif report["verdict"] == PASS:
        assert all(f["severity"] != "error" for f in report["findings"])
    for axis, position in (right.axes or {}).items():
        assert report["first_contact"]["axes"][axis] == pytest.approx(position, abs=0.1)


def test_a_rotary_axis_ends_at_zero() -> None:
    """C-0 with `wrap: sign` turns 90 degrees back; G28 takes C to zero, by at most one turn."""
    for name in ("l17_sign_minus_zero", "l20_g28_wound_c", "l44_g28_rollover_turns"):
        frozen = json.loads((TRANSCRIPTS / f"field/{name}.json").read_text(encoding="utf-8"))
        assert json.loads(frozen["steps"][0]["output"][-1])["to"][5] % 360.0 == 0.0, name

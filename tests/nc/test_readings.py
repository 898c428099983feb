"""Every reading changes what a program means, alone and without asking the dialect."""

import pytest

from gcodesim.nc.canon import canon_rows
from gcodesim.nc.control.readings import ROWS
from gcodesim.nc.interpret import interpret

READ = {
    "program_unit": ("inch", "G0 X1"),
    "cycle_return": ("G99", "G0 Z9\nM3 S1 F9\nG81 X1 Z-1 R2"),
    "dwell_p": ("s", "G4 P500"),
    "g80": ("motion", "G1 F9 X1\nG80\nX2"),
    "g87": ("centre", "M3 S1 F9\nG87 X1 Z-5 R-9 Q1 I1 J1 K2"),
    "g87_under_g99": ("alarm", "M3 S1 F9\nG99 G87 X1 Z-1 R-5 Q1"),
    "peck_backoff": (1.0, "M3 S1 F9\nG73 X1 Z-5 R1 Q2"),
    "bore_shift": ("-Y", "M3 S1 F9\nG76 X1 Z-5 R1 Q1"),
    "r_and_ijk": ("error", "G2 X10 R5 I5 F9"),
    "arc": ({"tol_mm": 1.0}, "G2 X10.5 I5 F9"),
    "comma_corners": (False, "G1 F9 X5 ,R1\nY5"),
    "feed_forgotten": ("always", "G94 F9 G1 X1\nG94 X2"),
    "h0": ("spindle", "T2 M6\nG43 H0\nG0 Z1"),
    "g10_in_g91": ("replaces", "G91 G10 L2 P2 X1\nG90 G55 G0 X0"),
    "g10_l20": ("solved", "G0 X5\nG10 L20 P2 X1\nG55 G0 X0"),
    "g10_l2_p0": ("active", "G10 L2 P0 X1\nG55 G0 X0"),
    "arc_no_centre": ("alarm", "G2 X5 F9"),
    "arc_radii": ("alarm", "G2 X12 I5 F9"),
    "arc_r_no_end": ("alarm", "G2 X0 Y0 R5 F9"),
    "arc_normal_word": ("ignored", "G2 X10 I5 K2 F9"),
    "h_in_any_block": (False, "G0 X1 H2"),
    "length_without_h": ("spindle", "T2 M6\nG43 G0 Z1"),
    "unused_word": ("alarm", "G0 X1 E2"),
    "same_group": ("alarm", "G0 G1 X1 F9"),
    "g53_incremental": ("incremental", "G91 G0 G53 X1"),
    "cycle_drills": ("xy", "G81 X1 Z-5 R1 F9\nZ-6"),
    "cycle_rotary": ("error", "G81 X1 Z-5 R1 F9\nA5"),
    "cycle_repeats": ("L", "G91 G81 X1 Z-5 R1 F9 K3"),
    "cycle_q": ("signed", "M3 S1 F9\nG83 X1 Z-5 R1 Q-2"),
    "cycle_no_q": ("alarm", "M3 S1 F9\nG76 X1 Z-5 R1"),
    "peck_words": ("ijk", "M3 S1 F9\nG73 X1 Z-5 R1 Q1 K2"),
    "same_letter": ("alarm", "G0 X1 X2"),
    "tapping_spindle": ("alarm", "S1 F9\nG84 X1 Z-5 R1"),
    "g10_tool_r": ("ignored", "T2 M6\nG10 L10 P2 R9\nG43 H2 G0 Z0"),
    "m98_p": ("number", "M98 P20007\nM30\nO7 G91 G0 X1\nM99\nO20007 G0 X5\nM99"),
    "macros": ("macro_b_haas", "#10500=3\nG0 X#10500"),
    "m99": ("end", "#1=#1+1\nIF[#1GT2]GOTO9\nG0 X#1\nM99\nN9"),
    "tape": (False, "G0 X1 /Y2"),
    "start_motion": ("G1", "F9 X1"),
    "m_codes": ({777: "stop"}, "M777"),
    "g_codes": ({777: "stop"}, "G777"),
    "ignore_words": (("E",), "G0 X1 E2"),
    "length_at_tool_change": ("new_tool", "T1 M6\nG43 H1\nT2 M6\nG0 Z1"),
    "programs": ({"7": "none"}, "M98 P7"),
}
"""Key -> another reading than that of fanuc, and a program that tells the two apart.

Rapid moves are read by motion/, and tool centre point control in test_five_axis.
"""


def outcome(meaning):
    return list(canon_rows(meaning)), [(f.meaning, f.line) for f in meaning.findings]


def met(meaning):
    return [reading.key for reading in meaning.readings]


ALARMS = {
    "arc_no_centre": ("G2 X5 F9", "arc_no_center", [5, 0, 0]),
    "arc_radii": ("G2 X12 I5 F9", "arc_radius_mismatch", [12, 0, 0]),
    "arc_r_no_end": ("G2 X0 Y0 R5 F9\nX1 R5", "arc_end_equals_start", [1, 0, 0]),
    "cycle_no_q": ("F9\nG99 G73 X1 Z-5 R1", "cycle_word_missing", [1, 0, 1]),
    "g87_under_g99": ("F9\nG99 G87 X1 Z-1 R-5 Q1", "cycle_return_unusable", [1, 0, 0]),
    "tapping_spindle": ("S1 M5 F9\nG99 G84 X1 Z-5 R1", "tapping_no_spindle", [1, 0, 1]),
    "same_letter": ("G0 X1 X2", "duplicate_word", [2, 0, 0]),
}
"""Key -> a program, the alarm of some controls, and where the program ends on others."""


@pytest.mark.parametrize("key", ALARMS)
def test_what_only_some_controls_refuse_runs_and_is_counted(key, control):
    text, alarm, end = ALARMS[key]
    text = f"S1 M3\n{text}\nM30"
    meaning = interpret(text, control())
    assert (met(meaning), meaning.stopped) == ([key], False)
    assert [row["to"][:3] for row in canon_rows(meaning) if "to" in row][-1] == end
    refused = interpret(text, control(**{key: "alarm"}))
    assert (refused.findings[-1].meaning, met(refused)) == (alarm, [])


@pytest.mark.parametrize("key", READ)
def test_a_reading_changes_what_a_program_means(key, control):
    other, text = READ[key]
    usual = interpret(f"{text}\nM30", control(max_blocks=50))
    changed = interpret(f"{text}\nM30", control(max_blocks=50, **{key: other}))
    assert (outcome(changed), met(changed)) != (outcome(usual), met(usual))


def test_readings_without_the_dialects_name_make_linuxcnc_of_fanuc(control):
    """Where both dialects have the codes, the readings alone say what a program means."""
    keys = {
        name: getattr(ROWS["linuxcnc"], name)
        for name in READ
        if name not in ("arc", "m_codes", "g_codes", "ignore_words", "programs")
    }
    for name in ("g80", "feed_forgotten", "h0", "g10_tool_r", "m99", "m98_p"):
        text = f"{READ[name][1]}\nM30"
        mixed = interpret(text, control("fanuc", max_blocks=50, **keys))
        assert outcome(mixed) == outcome(interpret(text, control("linuxcnc", max_blocks=50))), name

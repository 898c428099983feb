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
    "arc_no_centre": ("line", "G2 X5 F9"),
    "arc_r_no_end": ("none", "G2 X0 Y0 R5 F9"),
    "arc_normal_word": ("ignored", "G2 X10 I5 K2 F9"),
    "h_in_any_block": (False, "G0 X1 H2"),
    "length_without_h": ("spindle", "T2 M6\nG43 G0 Z1"),
    "same_group": ("alarm", "G0 G1 X1 F9"),
    "g53_incremental": ("incremental", "G91 G0 G53 X1"),
    "cycle_drills": ("xy", "G81 X1 Z-5 R1 F9\nZ-6"),
    "cycle_rotary": ("error", "G81 X1 Z-5 R1 F9\nA5"),
    "cycle_repeats": ("L", "G91 G81 X1 Z-5 R1 F9 K3"),
    "cycle_q": ("signed", "M3 S1 F9\nG83 X1 Z-5 R1 Q-2"),
    "peck_words": ("ijk", "M3 S1 F9\nG73 X1 Z-5 R1 Q1 K2"),
    "tapping_starts_spindle": (True, "S1 F9\nG84 X1 Z-5 R1"),
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


@pytest.mark.parametrize("key", READ)
def test_a_reading_changes_what_a_program_means(key, control):
    other, text = READ[key]
    usual = interpret(f"{text}\nM30", control(max_blocks=50))
    changed = interpret(f"{text}\nM30", control(max_blocks=50, **{key: other}))
    assert outcome(changed) != outcome(usual)


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

"""What one block leaves behind for the next, and what the control's own data changes."""

import math

import numpy as np
import pytest

from gcodesim.errors import UsageError
from gcodesim.nc.control.readings import choose_readings
from gcodesim.nc.control.supply import WorkOffset
from gcodesim.nc.interpret import interpret
from gcodesim.nc.lines import decode, read_program, split_lines
from gcodesim.nc.program import Kind, arc_sweeps, path_lengths, starts_of_moves


def moves(meaning):
    """End points of the moves, shape (n, 6)."""
    return meaning.program.to[meaning.program.kind <= Kind.ARC]


def meanings(meaning):
    return [finding.meaning for finding in meaning.findings if finding.severity != "note"]


def test_columns_point_at_the_word_and_not_at_the_blanks(control):
    meaning = interpret("  N5  (a comment)  G1 x 1 . 5  q7 F100", control())
    (finding,) = meaning.findings
    assert (finding.meaning, finding.column) == ("unused_word_open", 32)


def test_a_refused_block_leaves_nothing_behind(control):
    meaning = interpret("G0 X1\n(MSG,never)T1 M6 S-1 G55 G0 X2", control())
    assert meaning.program.line.max() == 1
    assert meaning.last_line == 2
    assert meaning.stopped


def test_the_order_inside_a_block_is_that_of_the_table(control):
    meaning = interpret("Z10 G0 H2 G43 M6 T2 G55\nM30", control())
    kinds = [Kind(k) for k in meaning.program.kind[2:]]
    assert kinds == [Kind.TOOL, Kind.TOOL_OFFSET, Kind.G5X, Kind.RAPID, Kind.STOP]
    assert moves(meaning)[0].tolist() == [0.0, 0.0, 95.5, 0.0, 0.0, 0.0]


def test_changing_offsets_never_moves_the_machine(control):
    meaning = interpret("G0 X0.1 Y0.2 Z0.3\nG55\nG43 H2\nG1 A90 F360\nM30", control())
    assert moves(meaning)[-1].tolist() == [0.1, 0.2, 0.3, 90.0, 0.0, 0.0]
    assert path_lengths(meaning.program)[meaning.program.kind == Kind.FEED] == [90.0]


def test_start_position_and_first_offset_come_from_the_setup(control):
    start, offsets = {"Z": 100.0, "C": 5.0}, {1: WorkOffset((0.0, 0.0, -20.0, 0.0, 0.0, 0.0))}
    meaning = interpret("G91 G0 X1\nG90 Z0\nM30", control(start=start, offsets=offsets))
    assert moves(meaning).tolist() == [[1, 0, 100, 0, 0, 5], [1, 0, -20, 0, 0, 5]]


def test_block_delete_is_a_switch(control):
    text = "/G0 X1\n/2 N5 G0 Y1\nM30"
    assert len(moves(interpret(text, control()))) == 2
    assert len(moves(interpret(text, control(block_delete=True)))) == 0


def test_nothing_runs_behind_the_end(control):
    for text in ("M30\nG0 X1 $$$", "M2\nX", "%\nG0 X1\n%\nrubbish"):
        meaning = interpret(text, control())
        assert not meaning.stopped
        assert not meaning.findings


def test_feed_option_stands_in_until_the_first_f_word(control):
    meaning = interpret("G1 X1\nF50\nX2\nM30", control(feed=10000.0))
    assert meaning.program.f[meaning.program.kind == Kind.FEED].tolist() == [10000.0, 50.0]
    for text in ("F0\nG1 X1", "G93 G1 X1", "S100 G95 G1 X1"):
        assert interpret(text, control(feed=10000.0)).stopped


def test_ignored_words_are_dropped_and_counted(control):
    text = "G1 E12 F4550\nG92 E0\nG28 E0\nG1 X1 E3\nG4 P0 E1\nM30"
    meaning = interpret(text, control(ignore_words=("E",)))
    assert meaning.ignored == ("word E (5 times)",)
    assert moves(meaning).tolist() == [[1, 0, 0, 0, 0, 0]]
    assert meanings(meaning) == []


def test_listed_m_codes_take_what_is_left_over(control):
    meaning = interpret("M104 S205 T1 P3\nM6\nM46\nM30", control(m_codes={104: "none", 46: "stop"}))
    assert meanings(meaning) == []
    assert meaning.ignored == ("M104 (1 time)", "M46 (1 time)")
    assert (meaning.program.speed[-1], meaning.program.aux[2]) == (0.0, 1)
    assert [Kind(k) for k in meaning.program.kind[2:]] == [Kind.TOOL, Kind.STOP, Kind.STOP]


def test_unknown_m_codes_are_reported_once_each(control):
    meaning = interpret("M123\nM124 P1 Q2\nM123\nG0 X1\nM30", control())
    assert [f.line for f in meaning.findings] == [1, 2]
    assert "(2 times)" in meaning.findings[0].message
    assert meaning.unsupported == ("M123 line 1", "M124 line 2")
    assert len(moves(meaning)) == 1


def test_without_a_tool_table_the_mounted_tool_stands_in(control):
    text = "T7 M6\nG43 H7\nG0 Z0\nM30"
    known = interpret(text, control(tools=None, tool_for_all=True, mounted_length=160.0))
    assert known.findings == ()
    assert moves(known)[0, 2] == 160.0
    unknown = interpret(text, control(tools=None, mounted_length=160.0))
    assert [f.meaning for f in unknown.findings] == ["tool_without_shape"] * 2
    assert not unknown.stopped


def test_h0_and_t0_are_no_tool(control):
    meaning = interpret("T0 M6\nG43 H0\nG0 Z1\nM30", control())
    assert meaning.findings == ()
    assert moves(meaning)[0, 2] == 1.0


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-16-be"])
def test_a_program_in_utf_16_is_told_as_such(encoding, control):
    text = decode("%\r\nO1\r\nG0 X1\r\nM30\r\n%\r\n".encode(encoding))
    (finding,) = interpret(text, control()).findings
    assert finding.meaning == "bad_character"
    assert "looks like UTF-16; NC programs are ASCII or UTF-8" in finding.message
    (other,) = interpret("G0 X1 \0 Y2", control()).findings
    assert "UTF-16" not in other.message


def test_max_blocks_ends_interpretation(control):
    meaning = interpret("G0 X1\nX2\nX3\nM30", control(max_blocks=2))
    assert meanings(meaning) == ["max_blocks"]
    assert (meaning.blocks, meaning.last_line, meaning.stopped) == (2, 2, True)


@pytest.mark.parametrize(
    ("dialect", "code"),
    [("fanuc", "G43.4 H1"), ("fanuc", "G68.2 I0 J9 K0"), ("haas", "G254"), ("linuxcnc", "M428")],
)
def test_five_axis_codes_need_rotary_axes_and_stop_nothing_but_moves(dialect, code, control):
    off = {"G68.2 I0 J9 K0": "G69", "G254": "G255", "M428": "M429"}.get(code, "G49")
    held = interpret(f"{code}\n{off}\nG0 X1\nM30", control(dialect))
    assert (meanings(held), len(moves(held))) == ([], 1)
    (finding,) = interpret(f"{code}\nG28 X0\nM30", control(dialect)).findings
    assert (finding.code, finding.line) == ("GC402", 2)
    assert finding.message.startswith(code.split()[0])
    assert meanings(interpret(code, control(dialect, axes="XYZ"))) == ["rotary_axes_missing"]


def test_position_words_follow_the_wrap_of_their_axis(control):
    wrap, travel = {"C": "shortest", "B": "sign", "A": "shortest"}, {"A": (-30.0, 120.0)}
    text = "G0 C350\nC10\nC-170\nC10\nG91 C720\nG90 B90\nB-30\nA100\nA-100\nM30"
    to = moves(interpret(text, control(wrap=wrap, travel=travel)))
    assert to[:5, 5].tolist() == [-10.0, 10.0, 190.0, 370.0, 1090.0]
    assert to[5:7, 4].tolist() == [90.0, 30.0]
    assert to[7:, 3].tolist() == [100.0, 260.0]


def test_rotary_words_without_wrap_are_unwound_angles(control):
    assert moves(interpret("G0 A730\nA10\nM30", control()))[:, 3].tolist() == [730.0, 10.0]


@pytest.mark.parametrize(
    ("dialect", "word", "seconds"),
    [
        ("fanuc", "P500", 0.5),
        ("fanuc", "X1.5", 1.5),
        ("haas", "P500", 0.5),
        ("haas", "P1.5", 1.5),
        ("haas", "U2", 2.0),
        ("linuxcnc", "P1.5", 1.5),
    ],
)
def test_dwell_counts_as_the_dialect_does(dialect, word, seconds, control):
    program = interpret(f"G4 {word}\nM30", control(dialect)).program
    assert program.f[program.kind == Kind.DWELL].tolist() == [seconds]


def test_g80_ends_the_motion_mode_for_linuxcnc_only(control):
    text = "G0 X1\nG80\nX2\nM30"
    assert interpret(text, control("linuxcnc")).stopped
    for dialect in ("fanuc", "haas"):
        assert len(moves(interpret(text, control(dialect)))) == 2


def test_r_wins_over_centre_words_for_fanuc_only(control):
    text = "G2 X10 R5 I99 F100 S1 M3\nM30"
    assert interpret(text, control("fanuc")).program.arcs["center"].tolist() == [[5, 0, 0]]
    for dialect in ("haas", "linuxcnc"):
        assert meanings(interpret(text, control(dialect))) == ["arc_r_and_center"]


def test_a_dialect_key_can_be_overridden():
    assert choose_readings("fanuc", {"dwell_p": "s"}).dwell_p == "s"
    arc = choose_readings("fanuc", {"arc": {"tol_mm": 0.5}}).arc
    assert (arc.tol_mm, arc.r_tol_mm) == (0.5, 0.00127)
    with pytest.raises(UsageError, match="fanuc, haas, linuxcnc"):
        choose_readings("heidenhain")


def sweeps_and_lengths(text, control):
    program = interpret(text + "\nM30", control()).program
    arcs = program.kind == Kind.ARC
    start, end = starts_of_moves(program)[arcs, :3], program.to[arcs, :3]
    return arc_sweeps(start, end, program.arcs), path_lengths(program)[arcs]


@pytest.mark.parametrize(
    ("text", "turned", "length"),
    [
        ("G3 X10 Y10 J10 F1", math.pi / 2, 5 * math.pi),
        ("G2 X10 Y10 J10 F1", -3 * math.pi / 2, 15 * math.pi),
        ("G2 I5 F1", -2 * math.pi, 10 * math.pi),
        ("G3 X0 Y0 I5 P3 Z1 F1", 6 * math.pi, math.hypot(30 * math.pi, 1)),
        ("G2 X10 Y10 R10 F1", -math.pi / 2, 5 * math.pi),
        ("G2 X10 Y10 R-10 F1", -3 * math.pi / 2, 15 * math.pi),
        ("G19 G3 Y10 Z10 R10 X7 F1", math.pi / 2, math.hypot(5 * math.pi, 7)),
        ("G0 X0.1\nG91 X0.2\nG90 G2 X0.3 I5 F1", -2 * math.pi, 10 * math.pi),
        ("G2 X10.01 I5 F1", -math.pi, math.hypot(5.005 * math.pi, 0.01)),
    ],
)
def test_arcs_turn_through_closed_forms(text, turned, length, control):
    sweeps, lengths = sweeps_and_lengths(text, control)
    np.testing.assert_allclose(sweeps, [turned], rtol=1e-12)
    np.testing.assert_allclose(lengths, [length], rtol=1e-12)


def test_text_is_decoded_and_split_without_loss(tmp_path):
    assert decode(b"\xef\xbb\xbfG0 (\xc3\xa4)") == "G0 (ä)"
    assert decode(b"G0 (\xe4)") == "G0 (ä)"
    assert split_lines("a\r\nb\rc\n\x0cd\u2028e\n") == ["a", "b", "c", "\x0cd\u2028e"]
    with pytest.raises(UsageError, match="cannot be read"):
        read_program(tmp_path / "missing.nc")


def test_tape_leaders_line_ends_and_nul_bytes(control):
    wanted = [[1.0, 0.0], [1.0, 2.0]]
    for text in ("G0 X1\nY2\nM30", "\0\0\x7fG0 X1\r\nY2\r\nM30\r\n\0\0", "G0X1\rY2\rM30\r"):
        meaning = interpret(text, control())
        assert moves(meaning)[:, :2].tolist() == wanted
        assert meaning.findings == ()
    assert meanings(interpret("G0 X1\n\0\nM30", control("linuxcnc"))) == ["bad_character"]


def test_lines_are_a_sequence_that_is_decoded_when_asked_for():
    lines = split_lines("a\n\xe4\u20ac\n\nb")
    assert (len(lines), lines[1], lines[-1], lines[1:3]) == (
        4,
        "\xe4\u20ac",
        "b",
        ["\xe4\u20ac", ""],
    )
    with pytest.raises(IndexError):
        lines[4]
    assert len(split_lines("")) == 0
    assert list(split_lines("\n")) == [""]

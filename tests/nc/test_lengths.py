"""Numbers without a decimal point, lengths without a unit, and M6 beside motion words."""

import numpy as np
import pytest
from nc.controls import make_control

from gcodesim.nc.control import runs
from gcodesim.nc.control.readings import ROWS, is_varied, ways_of
from gcodesim.nc.interpret import interpret
from gcodesim.nc.program import Kind

OPEN = {"no_point": "open"}
INCREMENT = {"no_point": "increment"}


def moves(text, dialect="fanuc", **fields):
    """Kind and end point of every move, with X Y Z A B C rounded."""
    program = interpret(f"{text}\nM30", make_control(dialect, **fields)).program
    at = np.flatnonzero(program.kind <= Kind.ARC)
    return [(Kind(program.kind[i]), np.round(program.to[i], 6).tolist()) for i in at]


def ends(text, dialect="fanuc", **fields):
    return [end for _, end in moves(text, dialect, **fields)]


def findings(text, dialect="fanuc", **fields):
    """Meaning, line and message of what is neither a note nor about the spindle."""
    found = interpret(f"{text}\nM30", make_control(dialect, **fields)).findings
    return [(f.meaning, f.line, f.message) for f in found if f.severity != "note"]


def met(text, dialect="fanuc", **fields):
    """Key -> line and count of the readings that a program depends on."""
    readings = interpret(f"{text}\nM30", make_control(dialect, **fields)).readings
    return {reading.key: (reading.line, reading.count) for reading in readings}


def test_fanuc_and_haas_leave_open_what_a_number_without_a_point_is():
    assert [row.no_point for row in ROWS.values()] == ["both", "both", "units", "units"]
    assert is_varied("no_point")
    assert not is_varied("program_unit")
    assert ways_of("no_point") == ("units", "increment")


@pytest.mark.parametrize(
    ("word", "counts"),
    [("X5", True), ("X-5", True), ("A5", True), ("X5.", False), ("X.5", False), ("X0", False),
     ("X-0", False), ("X#1", False), ("X[2+3]", False), ("X-#1", False), ("F5", False)],
)  # fmt: skip
def test_words_with_a_point_zeros_and_worked_out_values_never_matter(word, counts):
    text = f"#1=5\nG0 {word}"
    assert met(text, no_point="both") == ({"no_point": (2, 1)} if counts else {})
    assert findings(text, no_point="units") == []
    expected = [("no_point_open", 2)] if counts else []
    assert [found[:2] for found in findings(text, **OPEN)] == expected


@pytest.mark.parametrize(
    "block",
    ["G4 X5", "M19 R90", "G5.1 Q1", "G64 Q5", "G81 X1. Z-1. R1. K3 F9.", "N5 G0 X1.", "G10 L2 P1"],
)
def test_numbers_that_are_no_lengths_do_not_matter(block):
    assert met(f"S1 M3\n{block}\nG80", no_point="both").keys() <= {"start_motion"}


def test_open_is_one_finding_with_the_first_line_the_count_and_the_key():
    ((meaning, line, message),) = findings("G0 X1.\nX5 Y7\nX6.\nY8", **OPEN)
    assert (meaning, line) == ("no_point_open", 2)
    assert message == (
        "X5 without a decimal point: give control: {no_point: units | increment} (2 times)"
    )


def test_increments_follow_the_unit_and_the_kind_of_axis():
    assert ends("G0 X5000 Y2.5 A90000", **INCREMENT) == [[5, 2.5, 0, 90, 0, 0]]
    assert ends("G20 G0 X5000 A90000", **INCREMENT) == [[12.7, 0, 0, 90, 0, 0]]
    assert ends("G20\nG21 G0 X5000", **INCREMENT) == [[5, 0, 0, 0, 0, 0]]
    given = {**INCREMENT, "increment_mm": 0.01, "increment_inch": 0.001, "increment_deg": 0.1}
    assert ends("G0 X500 A9", **given) == [[5, 0, 0, 0.9, 0, 0]]
    assert ends("G20 G0 X500", **given) == [[12.7, 0, 0, 0, 0, 0]]


@pytest.mark.parametrize(
    ("bare", "pointed"),
    [
        ("G2 X10000 Y0 I5000 J0 F100", "G2 X10. Y0 I5. J0 F100"),
        ("G2 X10000 Y0 R9000 F100", "G2 X10. Y0 R9. F100"),
        ("G83 X1000 Z-3000 R2000 Q1000 F9", "G83 X1. Z-3. R2. Q1. F9"),
        ("G1 X9000 ,R2000 F9\nY9000", "G1 X9. ,R2. F9\nY9."),
        ("G1 X9000 ,C2000 F9\nY9000", "G1 X9. ,C2. F9\nY9."),
        ("G68 X1000 Y0 R90000\nG0 X5000", "G68 X1. Y0 R90.\nG0 X5."),
        ("G16\nG0 X5000 Y90000", "G16\nG0 X5. Y90."),
        ("G91 G28 X5000", "G91 G28 X5."),
        ("G92 X5000\nG0 X0", "G92 X5.\nG0 X0"),
        ("G52 X5000\nG0 X0", "G52 X5.\nG0 X0"),
        ("G10 L2 P1 X5000\nG0 X0", "G10 L2 P1 X5.\nG0 X0"),
        ("G65 P9 X5000 A7000", "G65 P9 X5. A7."),
    ],
)
def test_every_word_of_a_length_or_an_angle_is_scaled(bare, pointed):
    sub = "\nM30\nO9\nG0 X#24 Y#1\nM99"
    assert moves(bare + sub, **INCREMENT) == moves(pointed + sub, no_point="units")


def test_a_block_that_runs_twice_is_scaled_in_the_unit_of_each_time():
    text = "M98 P9\nG20\nM98 P9\nM30\nO9\nG0 X5000\nX0\nM99"
    assert [end[0] for end in ends(text, **INCREMENT)] == [5, 0, 12.7, 0]


def test_words_of_a_dwell_are_milliseconds_where_numbers_are_increments():
    program = interpret("G4 X500\nG4 X2.\nM30", make_control(**INCREMENT)).program
    assert program.f[program.kind == Kind.DWELL].tolist() == [0.5, 2.0]


@pytest.mark.parametrize("dialect", ["fanuc", "haas"])
@pytest.mark.parametrize("no_point", ["units", "increment", "both", "open"])
def test_runs_of_plain_blocks_read_points_as_single_blocks_do(no_point, dialect, monkeypatch):
    lines = [f"X{i}{'.' * (i % 3 == 0)} Y-{i * 7}" for i in range(300)]
    holes = [f"X{i} Y{i}.5" for i in range(200)]
    text = "\n".join(["G21 G0", *lines, "S1 M3", "G81 Z-1. R2 F9", *holes, "G80", "M30"])
    found = []
    for shortest in (16, 10**9):
        monkeypatch.setattr(runs, "SHORTEST", shortest)
        meaning = interpret(text, make_control(dialect, no_point=no_point))
        found.append((meaning.program.to.tolist(), meaning.findings, meaning.readings))
    assert found[0] == found[1]


def test_a_program_without_a_unit_takes_that_of_the_machine_file_and_says_so():
    text, unsaid = "G28 X0\nG0 Y0\nG0 X2.\nG0 X3.", {"program_unit": None}
    ((meaning, line, message),) = findings(text, unit="inch", **unsaid)
    assert (meaning, line) == ("unit_assumed", 3)
    assert message.startswith("no G20 or G21 before X: lengths are in inch, as `units`")
    assert ends("G0 X2.", unit="inch", **unsaid)[0][0] == 50.8
    (reading,) = interpret("G0 X2.\nM30", make_control(unit="inch", **unsaid)).readings
    assert (reading.key, reading.value, reading.line) == ("program_unit", "inch", 1)


def test_a_program_without_a_unit_that_nothing_gives_is_inconclusive():
    ((meaning, line, _),) = findings("G0 X2.", program_unit=None)
    assert (meaning, line) == ("unit_open", 1)
    assert findings("G21 G0 X2.", program_unit=None) == []
    assert findings("G0 X0 Y0", program_unit=None) == []
    assert findings("G0 X2.", "linuxcnc", program_unit="mm") == []
    assert ROWS["linuxcnc"].program_unit == "mm"


def test_m6_beside_motion_changes_before_or_after_it():
    def kinds(order, block="T1 M6 X5."):
        program = interpret(f"G0 {block}\nM30", make_control(m6_order=order)).program
        at = np.flatnonzero(np.isin(program.kind, [Kind.RAPID, Kind.TOOL]))
        return [Kind(program.kind[i]) for i in at]

    assert kinds("first") == [Kind.TOOL, Kind.RAPID]
    assert kinds("last") == [Kind.RAPID, Kind.TOOL]
    assert kinds("last", "G91 G28 X5. T1 M6")[-1] == Kind.TOOL
    assert met("G0 T1 M6 X5.\nT2 M6 X6.", m6_order="both") == {"m6_order": (1, 2)}
    assert met("T1 M6\nG0 X5.", m6_order="both") == {}
    assert [row.m6_order for row in ROWS.values()] == ["both", "both", "first", "first"]


def test_a_block_holds_as_many_m_codes_as_its_control_takes():
    assert findings("M3 M8", "haas", m_per_block="any") == []
    assert findings("M3 M8", "fanuc") == []
    ((meaning, line, message),) = findings("M3 M8\nM5 M9", "haas")
    assert (meaning, line) == ("m_per_block_open", 1)
    assert message.endswith("(2 times)")
    assert [found[0] for found in findings("M3 M8", "haas", m_per_block="one")] == ["too_many_m"]

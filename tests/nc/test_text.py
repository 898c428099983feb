"""Program text as machines read it: leaders, %, names, control characters, block delete, output."""

import pytest

from gcodesim.nc.interpret import interpret
from gcodesim.nc.program import Kind

FANUC_LIKE = ["fanuc", "haas"]


def ends(meaning):
    """X Y Z at the end of every move."""
    return meaning.program.to[meaning.program.kind <= Kind.ARC][:, :3].tolist()


def meanings(meaning):
    return [finding.meaning for finding in meaning.findings]


@pytest.mark.parametrize("dialect", FANUC_LIKE)
@pytest.mark.parametrize(
    "text",
    [
        "JOB 123\n%\nO1\nG0 X1\nM30\n%\n",
        "PART 4711 REV B  DNC 9600 7E2\n\0\0\n%\nO7031\nG0 X1\nM30\n%\n   SENT OK\n",
        "(NAME)\n%\nG0 X1\nM30",
        "%O7031(NAME)\nG0 X1\nM30\n%",
        "% TITLE\nG0 X1\nM30\n%",
        "O1\nG0 X1\n%",
        "%\n<PART_1>(NAME)\nG0 X1\nM30\n%",
        "\x11%\x13\nG0\x11 X1\x7f\n\0M30\n%\x12\nG0 X99",
    ],
)
def test_leaders_percent_names_and_control_characters_mean_nothing(text, dialect, control):
    meaning = interpret(text, control(dialect))
    assert ends(meaning) == [[1.0, 0.0, 0.0]]
    assert meaning.findings == ()


def test_blocks_before_a_percent_are_no_leader(control):
    meaning = interpret("O1\nG0 X1\nM30\n%\nO2\nG0 X2\n", control())
    assert ends(meaning) == [[1.0, 0.0, 0.0]]
    assert meanings(interpret("% G0 X5\nM30", control())) == ["bad_character"]


def test_a_program_number_after_percent_can_be_called(control):
    text = "%O7031(MAIN)\nM98 P2\nM30\nO2\nG0 X1\nM99\n%"
    meaning = interpret(text, control())
    assert (ends(meaning), meaning.findings) == ([[1.0, 0.0, 0.0]], ())


@pytest.mark.parametrize(
    ("block", "run", "left_out"),
    [
        ("N120 /Y5", [1.0, 5.0, 0.0], None),
        ("N120 /2 Y5", [1.0, 5.0, 0.0], None),
        ("Y5 / Z7", [1.0, 5.0, 7.0], [1.0, 5.0, 0.0]),
        ("Y5. /3 Z7 M8", [1.0, 5.0, 7.0], [1.0, 5.0, 0.0]),
        ("Y[10/2] /Z7", [1.0, 5.0, 7.0], [1.0, 5.0, 0.0]),
        ("N5 /IF [1 EQ 1] GOTO 9", None, None),
    ],
)
def test_a_slash_leaves_out_the_rest_of_its_block(block, run, left_out, control):
    text = f"G0 X1\n{block}\nN9 M30"
    for delete, end in ((False, run), (True, left_out)):
        meaning = interpret(text, control(block_delete=delete))
        assert ends(meaning) == [[1.0, 0.0, 0.0], *([end] if end else [])]
        assert meaning.findings == ()


def test_a_slash_in_an_expression_divides(control):
    text = "#1=10/2\n#2=#1/#1\nG0 X[#1/2] Y#2\nM30"
    assert ends(interpret(text, control())) == [[2.5, 1.0, 0.0]]


def test_columns_of_findings_count_what_a_slash_leaves_out(control):
    (finding,) = interpret("G0 X1 / Y2 J5\nM30", control()).findings
    assert finding.column == 12


def test_linuxcnc_takes_a_slash_only_first(control):
    assert meanings(interpret("G0 X1 /Y5\nM2", control("linuxcnc"))) == ["bad_character"]


@pytest.mark.parametrize("dialect", FANUC_LIKE)
def test_output_to_a_printer_moves_nothing(dialect, control):
    text = "G0 X1\n#101=1.5\nN5 POPEN\nDPRNT[BORE*D#101[43]]\nBPRNT[X#101[3]]\nPCLOS\nY2\nM30"
    meaning = interpret(text, control(dialect))
    assert ends(meaning) == [[1.0, 0.0, 0.0], [1.0, 2.0, 0.0]]
    assert meaning.findings == ()


def test_the_motion_at_the_start_is_a_reading(control):
    text = "F100 S1 M3\nX1\nY2\nM30"
    for dialect in FANUC_LIKE:
        meaning = interpret(text, control(dialect))
        assert [reading.key for reading in meaning.readings] == ["start_motion"]
        assert meaning.program.kind[-3:].tolist() == [Kind.RAPID, Kind.RAPID, Kind.STOP]
    for code, kind in (("G0", Kind.RAPID), ("G1", Kind.FEED)):
        meaning = interpret(text, control(start_motion=code))
        assert meaning.findings == ()
        assert meaning.program.kind[-3:-1].tolist() == [kind, kind]
    assert meanings(interpret("G28 Z0\nG4 X1\nG0 X1\nM30", control())) == []


def test_a_program_by_name_ends_the_one_before(control):
    text = "O1\nG0 X1\nGOTO 5\nM30\n<SUB>\nN5 G0 X2\nM30"
    assert meanings(interpret(text, control())) == ["block_not_found"]


@pytest.mark.parametrize(
    ("block", "dialect"), [("M98 <SUB>", "fanuc"), ("M98 (/USB/A.NC)", "haas")]
)
def test_calls_by_name_and_path_are_not_followed(block, dialect, control):
    meaning = interpret(f"G0 X1\n{block}\nM30\n<SUB>\nM99", control(dialect))
    assert [finding.code for finding in meaning.findings] == ["GC402"]

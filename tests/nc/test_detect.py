"""Which language a program is written in: by exclusive marks, hints, or not at all."""

import pytest

import gcodesim
from gcodesim.nc.control.readings import ROWS, choose_readings
from gcodesim.nc.detect import LINES, contradiction, dialect_of, marks_of
from gcodesim.nc.interpret import interpret

MARKS = {
    "heidenhain": [
        "0 BEGIN PGM PART MM",
        "BEGIN PGM 4711 INCH",
        "1 BLK FORM 0.1 Z X+0 Y+0 Z-20",
        "12 TOOL CALL 1 Z S3000",
    ],
    "din_iso": ["%PART G71 *", "N10 G30 G17 X+0 Y+0 Z-40*", "N50 G01 X+10 F100 *"],
    "siemens": [
        "%_N_PART_MPF",
        ";$PATH=/_N_WKS_DIR/_N_PART_WPD",
        'CYCLE832(0.01,_FINISH,1)',
        'N10 MSG("ROUGH")',
        'N20 T="MILL_10"',
        "G2 X10 Y5 CR=12",
        "G0 SUPA Z0 D0",
        "TRAORI",
        "N10 R1=5",
        "G0 G710 X1",
        "DEF REAL DEPTH",
        "GOTOF END",
        "G1 X=IC(5)",
        "WORKPIECE(,,,\"BOX\")",
    ],
    "okuma": ["$PART.MIN%", "VC1=5", "CALL O1000 Q2", "IF [V1 GT 2] NLAP1"],
    "linuxcnc": ["o100 sub", "O<probe> call [1]", "N5 o1 if [#1 GT 2]", "#<depth>=5", "o[#1] call"],
}  # fmt: skip
PLAIN = [
    "%",
    "O1234 (T=\"X\" CR=5 TRAORI)",
    "G0 X1 (TOOL CALL 5) (MSG 1)",
    "(MSG, tool)",
    "; CYCLE832 BEGIN PGM",
    "#100=#101*2",
    "IF [#1 GT 2] GOTO 100",
    "DPRNT[A#100[44]*]",
    "G65 P9810 Z5.",
    "M98 P1000 (CALL)",
    "G15 G17 G40 G49 G80",
]  # fmt: skip


@pytest.mark.parametrize(("language", "line"), [(k, v) for k in MARKS for v in MARKS[k]])
def test_one_exclusive_mark_tells_the_language(language, line):
    assert list(marks_of([line])) == [language]


@pytest.mark.parametrize("line", PLAIN)
def test_comments_and_plain_blocks_are_no_marks(line):
    assert marks_of([line]) == {}


@pytest.mark.parametrize("language", ["heidenhain", "din_iso", "siemens", "okuma", "linuxcnc"])
@pytest.mark.parametrize("dialect", ["fanuc", "haas"])
def test_nothing_of_another_language_is_read(language, dialect, control):
    text = f"G0 X1\n{MARKS[language][0]}\nG0 X2\nM30"
    meaning = interpret(text, control(dialect), "p.nc")
    (finding,) = meaning.findings
    assert (finding.code, finding.meaning, finding.line) == ("GC403", "other_language", 2)
    assert MARKS[language][0] in finding.message
    assert dialect in finding.message
    assert (meaning.stopped, meaning.blocks, len(meaning.program)) == (True, 0, 2)


def test_both_lines_are_quoted_where_two_languages_meet(control):
    text = "#<depth>=5\n0 BEGIN PGM PART MM\nM2"
    (finding,) = interpret(text, control("linuxcnc")).findings
    assert "line 1: #<depth>=5" in finding.message
    assert "line 2: 0 BEGIN PGM PART MM" in finding.message


def test_only_the_first_lines_are_looked_at():
    lines = ["G0 X1"] * LINES
    assert contradiction([*lines, "TRAORI"], ROWS["fanuc"]) is None
    assert contradiction([*lines[1:], "TRAORI"], ROWS["fanuc"]) is not None


def test_o_words_are_no_contradiction_where_macros_are_written_in_them():
    assert contradiction(["o1 sub"], choose_readings("fanuc", {"macros": "o_words"})) is None


@pytest.mark.parametrize(
    ("lines", "dialect", "line"),
    [
        (["G0 X1", "o1 sub"], "linuxcnc", 1),
        (["G0 X1", "G154 P3"], "haas", 1),
        (["G68.2 X0", "G0 X1"], "fanuc", 0),
        (["M428"], "linuxcnc", 0),
        (["G154 P3", "G43.4 H1"], "fanuc", None),
        (["G0 X1 (G154)"], "fanuc", None),
    ],
)
def test_hints_choose_a_dialect_where_they_agree(lines, dialect, line):
    found, mark = dialect_of(lines, ROWS)
    assert (found, mark.line if mark else None) == (dialect, line)


def test_the_text_tells_the_dialect_only_where_nothing_else_does(control):
    told = interpret("#<a>=1\nG0 X#<a>\nM2", control(given={}))
    (note,) = told.findings
    assert (note.code, note.meaning) == ("GC430", "dialect_told")
    assert "dialect linuxcnc, by line 1: #<a>=1" in note.message
    (note,) = interpret("G21 G0 X1\nM30", control(given={})).findings
    assert "dialect assumed: fanuc; nothing in the text decides" in note.message
    assert interpret("G0 X1\nM30", control()).findings == ()


def test_a_called_file_in_another_language_is_not_read(tmp_path, control):
    (tmp_path / "O0005.nc").write_text("TRAORI\nG0 X9\nM99\n")
    main = tmp_path / "main.nc"
    main.write_text("G0 X1\nM98 P5\nM30\n")
    meaning = interpret(main.read_text(), control(), str(main))
    assert [finding.code for finding in meaning.findings] == ["GC403"]


def test_a_machine_file_may_leave_the_dialect_to_the_text(tmp_path):
    (tmp_path / "m.yaml").write_text(
        "name: m\ndialect: auto\nlinks: {bed: {}, X: {}}\n"
        "joints: {X: {type: linear, parent: bed, child: X, axis: [1, 0, 0], limits: [-9, 9], rapid: 1000}}\n"  # noqa: E501
    )
    (tmp_path / "p.ngc").write_text("G21 G90\n#<a>=1\nG0 X#<a>\nM2\n")
    result = gcodesim.check(tmp_path / "p.ngc", tmp_path / "m.yaml")
    assert result.dialect == "linuxcnc"
    assert "dialect_told" in [finding.meaning for finding in result.findings]
    options = gcodesim.Options(dialect="fanuc")
    result = gcodesim.check(tmp_path / "p.ngc", tmp_path / "m.yaml", options=options)
    assert [finding.code for finding in result.findings][:1] == ["GC403"]

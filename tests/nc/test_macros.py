"""Macros compute what their control computes, and make the program go where they say."""

import pytest

from gcodesim.nc.canon import canon_rows
from gcodesim.nc.interpret import interpret
from gcodesim.nc.program import Kind


def reached(meaning):
    """X of every move, in order."""
    program = meaning.program
    return [round(x, 9) for x in program.to[program.kind <= Kind.ARC][:, 0].tolist()]


def value_of(expression, dialect, control):
    text = f"#1=[{expression}]\nG0 X[#1+1000]\nM30"
    meaning = interpret(text, control(dialect))
    assert meaning.findings == (), meaning.findings
    return reached(meaning)[0] - 1000


@pytest.mark.parametrize(
    ("expression", "fanuc", "linuxcnc"),
    [
        ("1+2*3", 7, 7),
        ("[1+2]*3", 9, 9),
        ("7-2-1", 4, 4),
        ("1+6/4", 2.5, 2.5),
        ("ROUND[2.5]", 3, 3),
        ("ROUND[-2.5]", -3, -3),
        ("FIX[-2.8]", -2, -3),
        ("FUP[-2.8]", -3, -2),
        ("ATAN[-1]/[-1]", 225, -135),
        ("ATAN[1]", 45, 45),
        ("SIN[30]+COS[60]", 1, 1),
        ("SQRT[16]+ABS[-4]", 8, 8),
        ("LN[EXP[2]]", 2, 2),
        ("BCD[25]", 37, 37),
        ("BIN[37]", 25, 25),
        ("-7 MOD 3", -1, 2),
        ("7 AND 12", 4, 1),
        ("1 OR 0 AND 0", 1, 0),
        ("6 XOR 3", 5, 0),
        ("3 GT 2", 1, 1),
        ("2 GE 3", 0, 0),
        ("[2 EQ 2] + [2 NE 2]", 1, 1),
        ("--3", 3, 3),
    ],
)
def test_expressions(expression, fanuc, linuxcnc, control):
    assert value_of(expression, "fanuc", control) == pytest.approx(fanuc, abs=1e-9)
    assert value_of(expression, "linuxcnc", control) == pytest.approx(linuxcnc, abs=1e-9)


def test_powers_and_signs_of_linuxcnc(control):
    assert value_of("-2**2", "linuxcnc", control) == 4
    assert value_of("2*2**3", "linuxcnc", control) == 16


PROGRAMS = {
    "assignments take effect behind the block": ("fanuc", "#1=1\n#1=2 G0 X#1\nX#1", [1, 2]),
    "indirect": ("fanuc", "#1=100\n#100=5\nG0 X##1 Y#[99+1]", [5]),
    "signs": ("fanuc", "#1=2\nG0 X-#1\nX-[#1+1]", [-2, -3]),
    "a vacant word is dropped": ("fanuc", "G0 X1\nX#1 Y1\nX#0 Y2", [1, 1, 1]),
    "vacant equals only vacant": (
        "fanuc",
        "#2=0\nIF[#1EQ#0]GOTO1\nG0X1\nN1 IF[#2EQ#0]GOTO2\nG0X2\nN2 G0 X3",
        [2, 3],
    ),
    "if then": ("fanuc", "IF [1 GT 2] THEN #1=5\nIF [1 LT 2] THEN #2=6\nG0 X[#1+#2]", [6]),
    "while": (
        "fanuc",
        "#1=0\nG0\nWHILE [#1 LT 3] DO1\n#1=#1+1\nX#1\nEND1\nX9",
        [1, 2, 3, 9],
    ),
    "nested loops": (
        "fanuc",
        "#1=0\nG0\nWHILE[#1LT2]DO1\n#1=#1+1\n#2=0\nWHILE[#2LT2]DO2\n#2=#2+1\nX[#1*10+#2]\nEND2\nEND1",
        [11, 12, 21, 22],
    ),
    "goto backwards": ("fanuc", "#1=0\nN10 #1=#1+1\nG0 X#1\nIF [#1 LT 3] GOTO 10", [1, 2, 3]),
    "m98 repeats": (
        "fanuc",
        "M98 P12 L2\nM98 P30012\nM30\nO12 G91 G0 X1\nG90\nM99",
        [1, 2, 3, 4, 5],
    ),
    "m99 p": ("fanuc", "M98 P12\nG0 X9\nN7 X2\nM30\nO12 G0 X1\nM99 P7", [1, 2]),
    "m98 shares locals, g65 does not": (
        "fanuc",
        "#1=5\nM98 P12\nG65 P12 A7\nG0 X[#1+1]\nM30\nO12\nG0 X#1\nM99",
        [5, 7, 6],
    ),
    "g65 sets of ijk": (
        "fanuc",
        "G65 P12 I1 J2 K3 I4 K7 M13 F1\nM30\nO12 G0 X[#4+#5+#6]\nX[#7+#8]\nX#13\nX#9\nM99",
        [6, 4, 13, 1],
    ),
    "globals": ("fanuc", "M98 P12\nG0 X#500\nM30\nO12 #500=3\nM99", [3]),
    "m97": ("haas", "M97 P100 L2\nM30\nN100 G91 G0 X1\nM99", [1, 2]),
    "m99 ends haas": ("haas", "G0 X1\nM99\nX2", [1]),
    "position": ("fanuc", "G55 G0 X5\n#1=#5021\n#2=#5041\nG54 G0 X#1\nX#2", [105, 5]),
    "modal": ("fanuc", "G0 X#4002\nG91 X1\nG90\nX#4003", [17, 18, 90]),
    "block delete and structure": ("fanuc", "/ #1=3\nG0 X#1", [3]),
    "o sub": (
        "linuxcnc",
        "o100 sub\nG0 X#1\no100 return [#1*2]\nG0 X99\no100 endsub\no100 call [4]\nX#<_value>",
        [4, 8],
    ),
    "o if": (
        "linuxcnc",
        "#1=2\nG0\no1 if [#1 EQ 1]\nX1\no1 elseif [#1 EQ 2]\nX2\no1 else\nX3\no1 endif\nX4",
        [2, 4],
    ),
    "o else": ("linuxcnc", "G0\no1 if [0]\nX1\no1 else\nX3\no1 endif\nX4", [3, 4]),
    "o while": (
        "linuxcnc",
        "#1=0\nG0\no1 while [#1 LT 9]\n#1=[#1+1]\no2 if [#1 EQ 2]\no1 continue\no2 endif\nX#1\n"
        "o3 if [#1 EQ 3]\no1 break\no3 endif\no1 endwhile",
        [1, 3],
    ),
    "o do": ("linuxcnc", "#1=0\nG0\no1 do\n#1=[#1+1]\nX#1\no1 while [#1 LT 2]\nX9", [1, 2, 9]),
    "o repeat": ("linuxcnc", "G91 G0\no1 repeat [3]\nX1\no1 endrepeat\nX5", [1, 2, 3, 8]),
    "names": (
        "linuxcnc",
        "#<a b>=4\n#<_g>=[#<ab>+EXISTS[#<zz>]]\no<s> call\nM2\no<s> sub\nG0 X#<_g>\no<s> endsub",
        [4],
    ),
    "reference": ("linuxcnc", "#5161=7\nG0 X1\nG28 X2", [1, 2, 7]),
}


@pytest.mark.parametrize("name", PROGRAMS)
def test_programs_go_where_they_say(name, control):
    dialect, text, wanted = PROGRAMS[name]
    meaning = interpret(text + "\nM30", control(dialect))
    assert not meaning.stopped, meaning.findings
    assert reached(meaning) == wanted


def test_vacant_words_are_inconclusive_and_named_parameters_errors(control):
    dropped = interpret("G0 X#1 Y1\nM30", control())
    assert [f.code for f in dropped.findings] == ["GC425"]
    assert dropped.program.to[2].tolist() == [0, 1, 0, 0, 0, 0]


def test_messages_show_values(control):
    meaning = interpret("#1=2.5\n(DEBUG, x is #1 and #<no>)\n(MSG, #1)\nM2", control("linuxcnc"))
    assert meaning.program.texts == [" x is 2.5 and #<no>", " #1"]


@pytest.mark.parametrize(
    ("dialect", "text", "reached"),
    [
        ("fanuc", "G0 X1\nX2\nM99", [1, 2, 1, 2]),
        ("haas", "G0 X1\nX2 Y1\nM99", [1, 2, 1, 2]),
        ("linuxcnc", "G0 X1\nX0\nM99", [1, 0, 1, 0]),
        ("fanuc", "G91 G0 X1\nG90 X0\nM99 P5\nN5 X3\nM99 P5", [1, 0, 3]),
        ("fanuc", "#1=#1+1\nIF[#1LT4]GOTO5\n#1=0\nN5 G0 X#1\nM99", [1, 2, 3, 0, 1]),
    ],
)
def test_m99_in_the_main_program_repeats_it_until_a_pass_begins_as_another_did(
    dialect, text, reached, control
):
    meaning = interpret(text, control(dialect))
    moves = (meaning.program.kind == Kind.RAPID) & (meaning.program.line > 0)
    assert meaning.program.to[moves, 0].tolist()[: len(reached)] == reached
    assert [f.meaning for f in meaning.findings] == ["main_program_repeats"]
    assert not meaning.stopped


def test_full_turns_of_a_table_make_no_pass_another_one(control):
    table = {"wrap": {"C": "shortest"}, "axes": "XYZC"}
    assert not interpret("G91 G0 C90\nM99", control("fanuc", **table)).stopped


def test_a_pass_that_ends_outside_the_travel_is_the_last(control):
    meaning = interpret("G91 G0 Z-10\nM99", control("fanuc", travel={"Z": (-100.0, 0.0)}))
    assert (meaning.blocks, meaning.stopped) == (22, False)


@pytest.mark.parametrize(
    ("dialect", "text"),
    [
        ("fanuc", "N1 GOTO 1"),
        ("fanuc", "WHILE [1 EQ 1] DO1\nEND1"),
        ("fanuc", "M98 P1 L999999999\nM30\nO1\nM99"),
        ("fanuc", "#1=#1+1\nG0 X1\nM99"),
        ("linuxcnc", "o1 do\no1 while [1]"),
        ("linuxcnc", "o1 repeat [1000000000]\no1 endrepeat"),
    ],
)
def test_endless_programs_end_at_the_limit(dialect, text, control):
    meaning = interpret(text, control(dialect, max_blocks=500))
    assert [f.meaning for f in meaning.findings] == ["max_blocks"]
    assert meaning.stopped


def test_unless_told_otherwise_only_blocks_that_repeat_are_few(tmp_path, monkeypatch, control):
    """A file's own blocks, those of its subprograms too, are bounded by its size."""
    monkeypatch.setattr("gcodesim.nc.control.program_flow.MAX_REPEATED_BLOCKS", 50)
    endless = "WHILE[1EQ1]DO1\nX1\nX0\nEND1"
    meaning = interpret(f"G0\n{endless}\nM30", control())
    (finding,) = meaning.findings
    assert finding.meaning == "max_blocks"
    assert "limit of 50 blocks that repeat; --max-blocks N allows more" in finding.message
    assert meaning.blocks == 6 + 50
    # Given, the one number stands for both limits.
    assert interpret(f"G0\n{endless}\nM30", control(max_blocks=400)).blocks == 400

    main, called = tmp_path / "main.nc", tmp_path / "O2.nc"
    called.write_text("O2\n" + "X1 (block by block)\nX0\n" * 100 + "M99\n")
    text = "G0\n" + "X2\nX3\n" * 100 + "M98 P2\nM30\n"
    main.write_text(text)
    meaning = interpret(text, control(), str(main))
    assert (meaning.findings, meaning.blocks) == ((), 203 + 202)


def test_subprograms_come_from_files_beside_the_program_and_keep_their_names(tmp_path, control):
    main = tmp_path / "main.nc"
    main.write_text("G0 X1\nM98 P77\nX3\nM30\n")
    (tmp_path / "O0077.nc").write_text("%\nO0077\nG0 X2\nG1 X5\nM99\n%\n")
    meaning = interpret(main.read_text(), control(feed=100.0), str(main))
    assert reached(meaning) == [1, 2, 5, 3]
    line = int(meaning.program.line[3])
    assert meaning.place(line) == (str(tmp_path / "O0077.nc"), 3)
    assert meaning.lines[line - 1] == "G0 X2"
    assert meaning.place(3) == (str(main), 3)
    files = [row.get("file", "main") for row in canon_rows(meaning) if "to" in row]
    assert files == ["main", *[str(tmp_path / "O0077.nc")] * 2, "main"]
    (finding,) = meaning.findings
    assert (finding.file, finding.line) == (str(tmp_path / "O0077.nc"), 4)


def test_nothing_outside_the_folder_of_the_program_is_read(tmp_path, control):
    (tmp_path / "secret.ngc").write_text("o<secret> sub\no<secret> endsub\n")
    folder = tmp_path / "programs"
    folder.mkdir()
    (folder / "linked.ngc").symlink_to(tmp_path / "secret.ngc")
    main = folder / "main.ngc"
    for name in ("../secret", "linked", str(tmp_path / "secret")):
        main.write_text(f"o<{name}> call\nM2\n")
        meaning = interpret(main.read_text(), control("linuxcnc"), str(main))
        assert [f.meaning for f in meaning.findings] == ["subprogram_not_found"]


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("G0 X1\nM98 P77", True),
        ("G0 X1\nM98 P20077", True),
        ("G0 X1\nG65 P77 A1", True),
        ("G0 X1\nM98 P9\nG0 X2\nM98 P77\nM30\nO9\nM99", True),
        ("G0 X1\nGOTO5\nM98 P77\nN5", False),
        ("G0 X1\nIF[1EQ2]THEN#1=1\nM98 P77", False),
        ("G0 X1\nM98 P#1", False),
        ("G0 X1\n/M98 P77", False),
        ("G0 X1\n(M98 P77)\nX2", False),
        ("G0 X1\nM30\nM98 P77", False),
    ],
)
def test_a_call_that_is_sure_to_fail_is_found_before_anything_moves(text, found, control):
    meaning = interpret(text, control())
    moved = (meaning.program.kind == Kind.RAPID).any()
    assert moved != found
    if found:
        (finding,) = meaning.findings
        line = next(i for i, block in enumerate(text.split("\n"), 1) if "77" in block)
        assert (finding.meaning, finding.line) == ("subprogram_not_found", line)

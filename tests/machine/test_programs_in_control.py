"""Programs and variables that live in the control: given by the machine file and the setup."""

import pytest
from nc.controls import make_control

from gcodesim.errors import ModelError
from gcodesim.machine.control_data import control_for
from gcodesim.machine.files import files_of
from gcodesim.machine.loading import load_machine
from gcodesim.nc.interpret import interpret
from gcodesim.nc.program import Kind


def run(text, file="", dialect="fanuc", **given):
    return interpret(f"{text}\nM30", make_control(dialect, **given), str(file))


def xz(meaning):
    program = meaning.program
    moves = (program.kind <= Kind.ARC) & (program.line > 0)
    return program.to[moves][:, [0, 2]].tolist()


def test_a_program_that_does_nothing_is_passed_over_and_listed():
    meaning = run("G0 X1\nG65 P9023 A1\nM98 P9023\nX2", programs={"9023": "none"})
    assert (xz(meaning), meaning.ignored) == ([[1, 0], [2, 0]], ("O9023 (2 times)",))
    assert not meaning.stopped


def test_a_program_that_changes_tools_does_what_m6_does():
    motion = {"retract": ["Z"], "position": {"Z": 9.0}}
    meaning = run("G0 X1\nT3\nM98 P9000", programs={"9000": "tool_change"}, tool_change=motion)
    assert xz(meaning) == [[1, 0], [1, 9]]
    assert meaning.program.aux[meaning.program.kind == Kind.TOOL].tolist() == [3]


def test_a_probing_program_is_a_skip_move_that_is_not_followed_further():
    meaning = run("G0 Z50\nG65 P9811 Z10.\nG0 Z50\nX9", programs={"9811": "probe"})
    assert [(f.code, f.meaning, f.line) for f in meaning.findings] == [
        ("GC423", "program_of_probe", 2)
    ]
    assert xz(meaning) == [[0, 50], [0, 10], [0, 50], [9, 50]]
    assert len(meaning.program.touching) == 2
    assert xz(run("G20 G65 P9811 Z1.", programs={"9811": "probe"})) == [[0, 25.4]]


def test_the_programs_own_come_first_then_files_beside_it_then_those_of_the_control(tmp_path):
    (tmp_path / "control").mkdir()
    (tmp_path / "library").mkdir()
    (tmp_path / "main.nc").write_text("")
    for folder, x in (("control", 3), ("library", 4)):
        (tmp_path / folder / "O0007.nc").write_text(f"O7\nG0 X{x}\nM99\n")
        (tmp_path / folder / "bolt.ngc").write_text("o<bolt> sub\nG0 X5\no<bolt> endsub\n")
    given = {"programs": {"7": str(tmp_path / "control/O0007.nc")}}
    shelf = {"library": str(tmp_path / "library")}
    call, file = "M98 P7", tmp_path / "main.nc"
    assert xz(run("M98 P7\nM30\nO7 G0 X1\nM99", file, **given, **shelf))[0][0] == 1
    assert xz(run(call, file, **given, **shelf))[0][0] == 3
    assert xz(run(call, file, **shelf))[0][0] == 4
    assert xz(run(call, **shelf))[0][0] == 4
    assert xz(run("o<bolt> call", dialect="linuxcnc", **shelf))[0][0] == 5
    (tmp_path / "O0007.nc").write_text("G0 X2\nM99\n")
    assert xz(run(call, file, **given, **shelf))[0][0] == 2
    assert run("M98 P8", file, **given, **shelf).findings[0].meaning == "subprogram_not_found"


def test_a_machine_file_names_them_relative_to_itself(changed, tiny):
    (tiny / "parts").mkdir()
    (tiny / "parts/o8000.nc").write_text("M99\n")
    keys = "programs: {9810: probe, L6: tool_change, 8000: parts/o8000.nc}, library: parts"
    path = changed("name: tiny", f"name: tiny\ncontrol: {{{keys}}}")
    readings = control_for(load_machine(path), None, None, False).readings
    assert readings.programs["9810"] == "probe"
    assert readings.programs["8000"] == str(tiny / "parts/o8000.nc")
    assert readings.library == str(tiny / "parts")
    assert tiny / "parts/o8000.nc" in files_of(path, None, None)


@pytest.mark.parametrize(
    ("keys", "text"),
    [
        ("programs: {8000: gone.nc}", "does not exist; write none, probe, tool_change or a file"),
        ("programs: {8000: ../gone.nc}", "lies outside the folder"),
        ("library: gone", "is no folder"),
        ("library: /tmp", "lies outside the folder"),
    ],
)
def test_what_is_not_there_is_refused(changed, keys, text):
    with pytest.raises(ModelError, match=text):
        load_machine(changed("name: tiny", f"name: tiny\ncontrol: {{{keys}}}"))


@pytest.mark.parametrize(
    "text",
    [
        *("G0 X#500", "G0 X[#100+1]", "IF[#500EQ1]GOTO9\nN9", "IF[#500NE#0]GOTO9\nN9"),
        *("WHILE[#500LT1]DO1\nEND1", "#101=ABS[#500]\nG0 X#101", "G0 X#[#500]", "GOTO#500"),
        *("#101=[#500AND1]\nG0 X#101", "IF[#500GT1]THEN#1=2", "#101=ATAN[#500]/[1]\nG0 Y#101"),
    ],
)
@pytest.mark.parametrize("dialect", ["fanuc", "haas"])
def test_what_is_made_of_a_variable_that_nobody_set_stops(text, dialect):
    meaning = run(text, dialect=dialect)
    assert [(f.code, f.meaning) for f in meaning.findings] == [("GC409", "value_unknown")]


def test_a_variable_that_is_never_used_is_no_question():
    assert not run("#101=[#500+1]\n#101=2\nG0 X#101").stopped
    assert xz(run("#500=#0\n#501=[#500+3]\nG0 X#501")) == [[3, 0]]


def test_the_setup_gives_what_the_control_remembers(tiny):
    (tiny / "setup.yaml").write_text("variables: {500: 12.5, 1: 3}\n")
    machine = load_machine(str(tiny / "tiny.yaml"), setup=str(tiny / "setup.yaml"))
    control = control_for(machine, None, None, False)
    assert control.variables == {500: 12.5, 1: 3}
    assert xz(run("G0 X#500", variables=control.variables)) == [[12.5, 0]]
    # Those of a call begin vacant.
    assert xz(run("G0 X#1 Z2", variables=control.variables)) == [[0, 2]]

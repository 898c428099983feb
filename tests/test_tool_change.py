"""A tool change moves as its control moves it: the new tool appears where that leaves the axes."""

from dataclasses import replace

import pytest
from nc.controls import make_control

import gcodesim
from gcodesim.checking.flow import check_program
from gcodesim.errors import ModelError
from gcodesim.machine.loading import load_machine
from gcodesim.nc.control.readings import ToolChangeMotion, choose_readings
from gcodesim.nc.interpret import interpret
from gcodesim.nc.program import Kind

LOW = "G21 G90 G94 G54\nT1 M6\nG0 X0 Y30 M3 S8000\nG43 H1 Z100\nG1 Z5 F3000\n{}G0 G53 Z0\nM30\n"
"""The longer tool goes into the spindle with the shorter one 5 mm above the table."""

OPTIONS = gcodesim.Options(device="cpu")
KNOWN = {"rapids": "linear", "length_after_reference": "kept", "length_change": "next_move"}
KNOWN |= {"no_point": "units", "spindle_at_stop": "stops"}
TOOLS = """\
tools:
  - {number: 1, length: 130, flute: {diameter: 16, length: 50}, holder: [[20, 0], [20, 80]]}
  - {number: 2, length: 160, flute: {diameter: 16, length: 50}, holder: [[20, 0], [20, 110]]}
"""


@pytest.fixture
def machine(tmp_path):
    (tmp_path / "tools.yaml").write_text(TOOLS)
    machine = load_machine("table_tilt", tools=str(tmp_path / "tools.yaml"))
    return machine.with_readings(**KNOWN)


def check(machine, text, dialect, **readings):
    machine = machine.with_readings(**readings)
    return check_program(text, "part.nc", machine, replace(OPTIONS, dialect=dialect))


def test_a_haas_takes_z_up_before_the_longer_tool_appears(machine):
    assert check(machine, LOW.format("T2 M6\n"), "haas").verdict == "pass"
    assert check(machine, LOW.format("T2 M16\n"), "haas").verdict == "pass"
    stays = check(machine, LOW.format("T2 M6\n"), "haas", tool_change="stays")
    assert (stays.verdict, stays.findings[-1].code) == ("fail", "GC106")


def test_where_nobody_knows_a_collision_in_one_way_is_inconclusive(machine):
    result = check(machine, LOW.format("T2 M6\n"), "fanuc")
    assert result.verdict == "inconclusive"
    (finding,) = [f for f in result.findings if f.code == "GC427"]
    assert finding.message.startswith(
        "tool_change: stays gives a contact of cutter and C in line 6"
    )
    assert "reference gives PASS" in finding.message


def test_a_collision_in_both_ways_fails(machine):
    dive = LOW.format("T2 M6\nG0 X0 Y0\nG43 H1 Z10\n")
    assert check(machine, dive, "fanuc").verdict == "fail"


def test_a_change_at_the_reference_point_depends_on_nothing(machine):
    result = check(machine, LOW.format("G53 G0 Z0\nT2 M6\n"), "fanuc")
    assert (result.verdict, result.coverage.readings) == ("pass", ())


def rows(text, **given):
    program = interpret(f"{text}\nM30", make_control(**given)).program
    keep = [i for i in range(len(program)) if program.kind[i] <= Kind.TOOL and program.line[i]]
    return [(int(program.kind[i]), *program.to[i, :3], program.f[i]) for i in keep]


def test_the_axes_of_retract_go_first_then_those_of_position_and_then_the_time_passes():
    motion = {"retract": ["Z"], "position": {"X": 5.0, "Z": 9.0}, "seconds": 6.0}
    found = rows("G0 X1 Y2 Z3\nT1 M6\nX0", dialect="fanuc", tool_change=motion)
    assert found == [
        (Kind.RAPID, 1, 2, 3, 0),
        (Kind.RAPID, 1, 2, 9, 0),
        (Kind.RAPID, 5, 2, 9, 0),
        (Kind.DWELL, 0, 0, 0, 6),
        (Kind.TOOL, 0, 0, 0, 0),
        (Kind.RAPID, 0, 2, 9, 0),
    ]


def test_an_axis_of_retract_without_a_position_goes_to_its_reference_point():
    reference = {"G28": {"Z": 70.0}}
    given = {"tool_change": {"retract": ["Z", "B"]}, "axes": "XYZ", "reference": reference}
    found = rows("G0 Z3\nT1 M6", dialect="fanuc", **given)
    assert found[1] == (Kind.RAPID, 0, 0, 70, 0)


def test_linuxcnc_changes_tools_where_it_stands():
    assert len(rows("G0 Z3\nT1 M6", dialect="linuxcnc")) == 2


def test_single_keys_of_the_motion_replace_those_of_the_dialect():
    haas = choose_readings("haas", {"tool_change": {"seconds": 6.0}}).tool_change
    assert haas == ToolChangeMotion(("Z",), {"Z": 0.0}, 6.0)
    fanuc = choose_readings("fanuc", {"tool_change": {"position": {"Z": 0.0}}}).tool_change
    assert fanuc == ToolChangeMotion((), {"Z": 0.0}, 0.0)
    assert choose_readings("haas", {"tool_change": "both"}).tool_change == "both"


def test_an_axis_that_the_machine_lacks_is_refused(tmp_path):
    path = load_machine("table_tilt").path
    with open(path) as file:
        text = file.read().replace("control: ", "control:\n  tool_change: {position: {B: 0}}\n#")
    text = text.replace("mesh: table_tilt/", f"mesh: {path.removesuffix('.yaml')}/")
    (tmp_path / "m.yaml").write_text(text)
    with pytest.raises(ModelError, match="no axis B"):
        load_machine(str(tmp_path / "m.yaml"), allow_outside=True)


def test_the_axes_wait_until_the_spindle_turns(machine):
    """It starts twice and turns round once; M3 while it turns already takes no time."""
    text = "G21 G90 G94 G54\nM3 S800\nM3\nM4\nM5\nM3\nG0 Z99.\nM30\n"
    plain = check(machine, text, "fanuc")
    waiting = check(machine, text, "fanuc", spindle_seconds=1.5)
    assert waiting.duration_s - plain.duration_s == pytest.approx(4.5, abs=1e-6)
    assert waiting.verdict == plain.verdict
